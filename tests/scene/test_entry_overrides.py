"""Entries of blocks given by ``--set``: found, replaced, added, or refused with a way out."""

import numpy as np
import pytest

import tissuec
from tests.every import every
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

SCENE = """language 1
use "tissues/liver"
tissue fat like cirrhotic liver { mass = 2 mg }
param lift = 2 mm between 1 mm and 5 mm
body liver {
  mesh is lattice {
    kind is braced cubes; box from (0, 0, 0) mm to (30, 20, 10) mm; cell = 10 mm
  }
  tissue is fat
  interface is mean
  region scar where x > 20 mm { tissue is liver }
}
tool hand { kind is forceps }
set left = nodes of liver where x < 1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: grasp left with hand; from 0 s to 0.1 s: move hand by (0, 0, lift) using ramp }
simulate { duration = 0.1 s; tolerance = 1e-3 }
output { position of left every 10 ms }
"""


def compiled(**given):
    return tissuec.compile(SCENE, params=given)


def refused(**given) -> str:
    with pytest.raises(CompileError) as error:
        compiled(**given)
    return str(error.value)


def tissue(scene, name="fat"):
    return scene.scene.tissues[name]


def word(scene, name, entry):
    return next(f.written for f in tissue(scene, name).facts if f.property == entry)


@pytest.mark.filterwarnings("ignore::tissuec.TissueWarning")
class TestFound:
    def test_a_word_of_a_tissue_is_replaced(self):
        assert word(compiled(), "liver", "hardness") == "soft"
        free = {"spring constant of liver": "concluded"}
        found = compiled(**{"hardness of liver": "slightly hard", **free})
        assert word(found, "liver", "hardness") == "slightly hard"
        assert word(found, "fat", "hardness") == "hard"  # which has a word of its own

    def test_what_only_the_parent_writes_is_added(self):
        found = compiled(**{"elasticity of fat": "medium"})
        assert word(found, "fat", "elasticity") == "medium"
        assert word(found, "cirrhotic liver", "elasticity") == "small"
        assert tissue(compiled(**{"viscosity of fat": "1 N*s/m"})).given["viscosity"].value == 1

    def test_an_underscore_stands_for_a_blank(self):
        assert tissue(compiled(mass_of_fat="3 mg")).given["mass"].value == pytest.approx(3e-6)

    def test_an_entry_of_the_mesh_is_found_inside_its_body(self):
        assert len(compiled().network.position) < len(
            compiled(**{"cell of liver": "5 mm"}).network.position
        )

    def test_an_entry_that_the_mesh_does_not_write_is_added_there(self):
        found = compiled(**{"reach of liver": "second neighbours"})
        assert found.network.spring_count > compiled().network.spring_count

    def test_a_tissue_of_a_body_is_not_that_of_its_region(self):
        found = compiled(**{"tissue of liver": "cirrhotic liver"}).scene.bodies["liver"]
        assert found.tissue.name == "cirrhotic liver"
        assert found.regions[0].tissue.name == "liver"
        found = compiled(**{"tissue of scar of liver": "fat"}).scene.bodies["liver"]
        assert (found.tissue.name, found.regions[0].tissue.name) == ("fat", "fat")

    def test_a_kind_of_block_tells_two_of_one_name_apart(self):
        found = compiled(**{"mass of body liver": "30 g"})
        assert found.network.mass.sum() == pytest.approx(0.03)
        found = compiled(**{"mass of tissue liver": "30 mg"})
        assert tissue(found, "liver").given["mass"].value == pytest.approx(3e-5)

    def test_simulate_and_environment_need_no_name(self):
        found = compiled(tolerance=1e-6, integrator="dop853", gravity="(0, 0, -9.81) m/s^2")
        simulation = found.plan.simulation
        assert (simulation.tolerance, simulation.integrator) == (1e-6, "dop853")
        assert np.array_equal(found.plan.gravity, [0, 0, -9.81])
        assert compiled(**{"duration of simulate": "0.2 s"}).plan.simulation.duration == 0.2

    def test_a_step_replaces_the_tolerance(self):
        simulation = compiled(step="0.1 ms", integrator="velocity verlet").plan.simulation
        assert (simulation.step, simulation.tolerance) == (1e-4, None)

    def test_a_param_is_a_param_and_the_last_value_counts(self):
        assert compiled(lift="3 mm").scene.constants.parameters()[0].value.amount == 0.003

    def test_a_whole_block_can_be_replaced(self):
        mesh = (
            "lattice { kind is diamond; box from (0, 0, 0) mm to (30, 20, 10) mm; cell = 5 mm }"
        )
        from tissuec.core.source import Source
        from tissuec.pipeline import compile_request
        from tissuec.scene.request import Request

        request = Request(Source("scene", SCENE), (f"mesh of liver is {mesh}",))
        assert compile_request(request)[0].scene.bodies["liver"].mesh.kind == "diamond"

    def test_the_result_says_what_was_set(self):
        result = tissuec.run(SCENE, params={"cell of liver": "5 mm"})
        assert result.manifest["overrides"] == ["cell of liver = 5 mm"]


@every(
    ("given", "said"),
    [
        ({"hardness of liver": "hrad"}, ['"hrad" is not a word for hardness', "--set:1:22"]),
        (
            {"hardnes of liver": "soft"},
            ['"hardnes" is not an entry of tissue liver or body liver', 'mean "hardness"'],
        ),
        ({"hardness of livr": "soft"}, ['no block called "livr"', 'did you mean "liver"']),
        (
            {"mass of liver": "3 g"},
            ['"liver" can be tissue liver or body liver', '"mass of tissue liver" or'],
        ),
        ({"tissue of scr of liver": "fat"}, ['"liver" has no block called "scr"']),
        ({"cell of liver": "5 N"}, ["cell must be a length (m), but 5 N is a force"]),
        ({"cell": "5 mm"}, ['"cell" cannot be set', 'such as "cell of liver"']),
        ({"lfit": "5 mm"}, ['"lfit" cannot be set', 'did you mean "lift"']),
        ({"lift": "soft"}, ["soft"]),
        ({"integrator": "dop"}, ['integrator cannot be "dop"']),
        ({"tolerance": "1e-3 ="}, ["two statements", "--set:1:18"]),
        ({"kind of hand": "scisors"}, ['"scisors"']),
    ],
)
def test_what_is_wrong_is_told_with_its_place(given, said):
    message = refused(**given)
    for part in said:
        assert part in message, message


@every(
    ("written", "proposed"),
    [
        ("hardness of fat = soft", 'write "hardness of fat is soft"'),
        ("hardness of tissue fat = hard", 'write "hardness of tissue fat is hard"'),
        ("mass of fat is heavy", "write mass of fat = 1 kg"),
        ("interface of body liver = stiffer", 'write "interface of body liver is stiffer"'),
        ("cell of liver is 5 mm", 'write "cell of liver = 5 mm"'),
        ("cell of liver 5 mm", 'write "cell of liver = 5 mm"'),
        ("rupture of body liver = allowed", 'write "rupture of body liver is allowed"'),
        ("kind of hand = hook", 'write "kind of hand is hook"'),
    ],
)
def test_what_is_proposed_names_the_block_and_can_be_set(written, proposed):
    with pytest.raises(CompileError) as error:
        check_request(Request(Source("scene.tis", SCENE), (written,)))
    (finding,) = error.value.diagnostics
    assert proposed in finding.hint
    for edit in finding.edits:
        mended = written[: edit.span.start] + edit.text + written[edit.span.end :]
        assert " of " in mended


def test_an_entry_in_two_blocks_inside_is_ambiguous():
    two = SCENE.replace(
        "region scar", "region tip where x < 5 mm { tissue is fat }\n  region scar"
    )
    two = two.replace("  tissue is fat\n", "")
    with pytest.raises(
        CompileError, match='"tissue" is written 2 times in body liver'
    ) as error:
        tissuec.compile(two, params={"tissue of liver": "fat"})
    assert '"tissue of region tip of liver" or "tissue of region scar' in str(error.value)


def test_two_texts_can_be_set_at_once_and_learning_reads_them_again():
    from tissuec.learn.vocabulary.used import reread

    scene = compiled(**{"weight of liver": "high", "elasticity of fat": "medium"}).scene
    again = reread(scene, {})
    assert word_of(again, "liver", "weight") == "high"
    assert word_of(again, "fat", "elasticity") == "medium"


def word_of(scene, name, entry):
    return next(f.written for f in scene.tissues[name].facts if f.property == entry)
