"""The stiffening of a tissue: the law of Fung in bars, walls, nets and solid elements."""

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.matter.test_bodies import THREAD, text_of
from tests.matter.test_laws_of_elements import MODULUS, scene, tension
from tissuec.core.source import Source
from tissuec.learn.derivatives.refusals import refusal as refusal_of
from tissuec.learn.fit.learning import learn
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.learn.presets.tissues import PRESET_FORMS as FORMS
from tissuec.learn.presets.tissues import TissueWriter, drafts_of
from tissuec.learn.vocabulary.moving import WordsModel
from tissuec.pipeline import check_request, compile_request, read_words
from tissuec.scene.request import Request

AREA = np.pi * 1e-6  # of the thread, 2 mm thick
OWN = 32  # springs that resist being drawn; the thread has one more, of its loop
DENSE = "density = 1060 kg/m^3; retardation time = 2 ms"
SOFT = "Young's modulus = 20 kPa"


def net(tissue, mesh=THREAD, more=""):
    return tissuec.compile(text_of(mesh, tissue, more)).network


def pull(network, strain):
    """Return the tension of all springs at a strain [N]."""
    return network.springs.behaviour.pull(strain * network.springs.rest)


@pytest.mark.parametrize("strain", [-0.1, 0.0, 0.1, 0.3])
def test_a_bar_follows_the_law_of_fung(strain):
    found = pull(net(f"{SOFT}; stiffening = 10; {DENSE}"), strain)[:OWN]
    assert found == pytest.approx(AREA * 2e3 * np.expm1(10.0 * strain), rel=1e-12, abs=1e-18)


@pytest.mark.parametrize("stretch", [1.05, 1.15, 1.3])
def test_elements_follow_it_in_tension(stretch):
    expected = MODULUS / 8.0 * np.expm1(8.0 * (stretch - 1.0))
    # 1 % is what the documentation says of curves; the stress grows to 12 times.
    assert tension(scene("stiffening = 8"), stretch) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("stretch", [0.6, 0.8, 1.2])
def test_elements_with_a_poissons_ratio_are_those_of_the_same_stress(stretch):
    given, written = (
        tension(scene(f"Poisson's ratio = 0.45; {law}"), stretch)
        for law in ("stiffening = 8", "stress of strain = 10 kPa / 8 * (exp(8 * strain) - 1)")
    )
    assert given == pytest.approx(written, rel=1e-9)


def test_none_is_the_law_of_rubber():
    plain, none = (tension(scene(law), 1.3) for law in ("", "stiffening is none"))
    assert plain == none
    assert np.array_equal(
        pull(net(f"{SOFT}; {DENSE}"), 0.3),
        pull(net(f"{SOFT}; stiffening is none; {DENSE}"), 0.3),
    )


def test_springs_with_a_constant_stiffen_too():
    typed = "spring constant = 4 N/m; viscosity = 1 mN*s/m; mass = 1 mg"
    found = net(f"{typed}; stiffening = 10")
    rest = found.springs.rest
    expected = 4.0 * rest / 10.0 * np.expm1(2.0)
    assert pull(found, 0.2)[:OWN] == pytest.approx(expected[:OWN], rel=1e-12)


# --- precedence -------------------------------------------------------------------------------

WORDS = """language 1
property grip from 0 to 1 { evenly = [loose, tight] }
quantity Young's modulus from 1 kPa to 1 MPa on log scale { evenly = [low, high] }
quantity stiffening from 1 to 20 on log scale { evenly = [low, high] }
rules r {
  result is gradual mean
  if grip is loose then stiffening is low and Young's modulus is low
  if grip is tight then stiffening is high and Young's modulus is high
}
tissue band { described in r; grip is tight; density = 1 g/cm^3 }
"""


def tissues(text):
    return read_words(Request(Source("x.tis", WORDS + text, None)))[0].tissues


def refusal(text):
    return finding_of(tissues, text)


def test_rules_conclude_it():
    band = tissues("")["band"]
    assert 10.0 < band.given["stiffening"].value < 20.0
    assert band.given["stiffening"].how == "rules"
    assert band.laws["spring law"].law.stiffening == band.given["stiffening"].value
    assert not band.written_laws


LAWS = [
    "spring law is toe { strain = 3 % }",
    "solid law is yeoh { second = 1 }",
    "stress of strain = 2 kPa * (exp(10 * strain) - 1)",
]


@pytest.mark.parametrize("law", LAWS)
def test_a_written_law_takes_precedence_over_a_concluded_one(law):
    own = tissues(f"tissue own like band {{ {law} }}")["own"]
    assert "stiffening" not in own.given
    assert own.concluded["stiffening"] > 0.0
    assert own.laws == own.written_laws
    heir = tissues(f"tissue own like band {{ {law} }}\ntissue heir like own {{ }}")["heir"]
    assert "stiffening" not in heir.given


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("is_first", [True, False])
def test_both_in_one_tissue_are_an_error(law, is_first):
    both = [law, "stiffening = 5"]
    found = refusal(f"tissue own like band {{ {'; '.join(both if is_first else both[::-1])} }}")
    assert found.code == "TIS306"
    assert "exclude each other in a tissue" in found.message
    assert found.notes[0].message == "the other entry"


@pytest.mark.parametrize("law", LAWS)
def test_a_child_replaces_one_by_the_other(law):
    found = tissues(
        f"tissue a like band {{ {law} }}\ntissue b like a {{ stiffening = 5 }}\n"
        f"tissue c like b {{ {law} }}\ntissue d like a {{ stiffening is concluded }}"
    )
    assert not found["b"].written_laws and found["b"].given["stiffening"].value == 5.0
    assert found["c"].written_laws and "stiffening" not in found["c"].given
    assert not found["d"].written_laws and found["d"].given["stiffening"].how == "rules"


def test_a_number_out_of_range_is_refused():
    assert refusal("tissue own like band { stiffening = 0 }").code == "TIS308"
    assert refusal("tissue own like band { stiffening = 300 }").code == "TIS308"


@pytest.mark.parametrize(
    ("entry", "name"),
    [("stiffening = 180", "stiffening"), ("toughness = 5e9 J/m^2", "toughness")],
)
def test_numbers_that_no_living_tissue_has_are_reported(entry, name):
    words = f"{WORDS}tissue own like band {{ {entry} }}"
    _, found = read_words(Request(Source("x.tis", words, None)))
    (unusual,) = (one for one in found if one.code == "W504")
    assert unusual.message.startswith(f"the {name} of own is")
    assert "outside of the usual range" in unusual.message


# --- changed from outside ---------------------------------------------------------------------

PULLED = f"""language 1
tissue gel {{ {SOFT}; stiffening = 10; {DENSE} }}
body cord {{
  mesh is thread {{ line from (0, 0, 0) mm to (40, 0, 0) mm; pieces = 4; thickness = 2 mm }}
  tissue is gel
}}
set left = nodes of cord where x < 0.1 mm
set right = nodes of cord where x > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix left
  from 0 s to 1 s: move right by (8, 0, 0) mm using constant speed
}}
simulate {{ duration = 1 s }}
"""


def test_it_can_be_set_and_varied():
    found = tissuec.compile(PULLED, params={"stiffening of gel": "5"})
    assert found.scene.tissues["gel"].laws["spring law"].law.stiffening == 5.0
    study = "study s { vary stiffening of gel = [2, 10]; measure pull = max(force of right) }\n"
    _, findings = check_request(Request(Source("x.tis", PULLED + study, None)))
    assert not [one for one in findings if one.severity == "error"]


LEARN = """
learn gel {
  data = "pull.csv"
  displacement of right using column "u_mm" in mm
  fit = force(right along (1, 0, 0)) using column "force_mN" in mN
  adjust stiffening of gel
}
"""


def test_learning_finds_it_and_writes_it_as_a_number(tmp_path):
    strain = np.linspace(0.04, 0.2, 5)
    force = AREA * 2e6 * np.expm1(10.0 * strain)
    rows = np.stack([40.0 * strain, force], axis=1)
    np.savetxt(tmp_path / "pull.csv", rows, delimiter=",", header="u_mm,force_mN", comments="")
    path = tmp_path / "cord.tis"
    path.write_text((PULLED + LEARN).replace("stiffening = 10", "stiffening = 4"))
    request = Request.file(path)
    compiled, _ = compile_request(request)
    found = learn(compiled, compiled.fit_problems[0], request)
    (learnt,) = found.estimates
    assert learnt.value == pytest.approx([10.0], rel=1e-3)
    (draft,) = drafts_of(found, compiled.scene)
    for form in FORMS:
        lines = TissueWriter(compiled.scene, "").block(draft, form)
        assert any(line.startswith("stiffening = ") for line in lines)
        assert not [line for line in lines if "law" in line]


@pytest.mark.parametrize(
    ("moved", "reason"),
    [("stiffening", "words change the stiffening of tissues"), ("Young's modulus", "")],
)
def test_words_that_stiffen_have_no_exact_derivatives(tmp_path, moved, reason):
    path = tmp_path / "cord.tis"
    (tmp_path / "pull.csv").write_text("u_mm,force_mN\n1,1\n2,2\n")
    words = WORDS.replace("described in r", "retardation time = 2 ms; described in r")
    scene = PULLED.split("}", 1)[1].replace("tissue is gel", "tissue is band")
    path.write_text(words + scene + LEARN.replace("stiffening of gel", f"words of {moved}"))
    compiled, _ = compile_request(Request.file(path))
    problem = compiled.fit_problems[0]
    shaping = Parametrisation(compiled, problem, WordsModel(compiled.scene, problem.adjusts))
    assert refusal_of(shaping) == reason
