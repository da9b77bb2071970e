"""What is offered: whatever stands in a scene, where it stands, and nothing that cannot."""

import random

import pytest

import tissuec
from tests.every import every
from tests.lsp.editor_documents import GOOD, LIBRARY, MARK, asked, shipped
from tissuec.lsp.completion import complete
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.hover import hover
from tissuec.lsp.views import view_of

HEAD = 'language 1\nuse "tissues/fallopian_tube"\nparam lift = 6 mm\nparam pause = 1 s\n'
BODY = "body oviduct { mesh is tube { rings = 16 }; tissue is fallopian tube }\n"
REGIONS = """body bed { mesh is lattice { cell = 1 mm }; tissue is fallopian tube
  region wall where z < 1 mm { tissue is fallopian tube }
  region pad where z > 2 mm { tissue is fallopian tube }
  """
SETS = "set waist = nodes of oviduct where x > 1 mm\ntool forceps A { kind is forceps }\n"
BED = "force bed { kind is foundation; acts on oviduct; stiffness = 1 kPa/m }\n"
TOE = "tissue t like fallopian tube { spring law is toe { strain = 3 % } }\n"


def offered(text):
    """Return the labels that are offered at the mark of a text."""
    return [one.label for one in complete(*asked(HEAD + text))]


def written(text):
    """Return a text with the best offer in the place that it takes."""
    view, offset = asked(HEAD + text)
    best = complete(view, offset)[0]
    whole = view.source.text
    return (whole[: best.start] + best.insert + whole[best.stop :]).removeprefix(HEAD)


@pytest.mark.parametrize(
    ("text", "some"),
    [
        ("bo‸", ["body"]),
        ("tissue scar like f‸", ["fallopian tube"]),
        ("tissue scar like fallopian tube { hard‸ }", ["hardness"]),
        ("tissue scar like fallopian tube { hardness is ‸ }", ["soft", "hard", "very"]),
        ("tissue scar like fallopian tube { hardness is very ‸ }", ["soft", "medium", "hard"]),
        ("tissue scar { described in ‸ }", ["soft tissue"]),
        ("tissue scar { kn‸ }", ["known"]),
        ("tissue scar { known ‸ }", ["Young's modulus", "density", "shear modulus"]),
        ("tissue scar { known breaking s‸ }", ["breaking strain"]),
        ("tissue scar { known density from 1 g/cm^3 ‸ }", ["to"]),
        ("tissue scar { known density from 1 g/cm^3 to 2 g/cm^3 ‸ }", ["by"]),
        ("tissue scar { known stress ‸ }", ["in"]),
        ("tissue scar { known stress in ‸ }", ["tension", "equibiaxial tension"]),
        ("param far = 5 mm between 1 mm ‸", ["and"]),
        ("tissue scar { known density = 1 g/cm^3 by ‸ }", ["unverified"]),
        ("tissue scar { spring law is ‸ }", ["linear", "toe", "tension only"]),
        ("body b { mesh is ‸ }", ["tube", "lattice", "imported"]),
        ("body b { mesh is lattice { re‸ } }", ["reach"]),
        ("body b { mesh is lattice { kind is ‸", ["diamond", "braced cubes"]),
        ("simulate { integrator is propagation { ‸ } }", ["growth", "compared forces"]),
        ("simulate { integrator is propagation { repeated is ‸ } }", ["step", "frame"]),
        ("simulate { integrator is relaxation { ‸ } }", ["threshold", "activities"]),
        ("body b { tissue is ‸", ["fallopian tube"]),
        (REGIONS + "interface ‸", ["is", "from"]),
        (REGIONS + "interface is softer ‸", ["from"]),
        (REGIONS + "interface is softer from ‸", ["wall", "pad"]),
        (REGIONS + "interface from wall to ‸", ["wall", "pad"]),
        (BODY + "set s = ‸", ["nodes", "springs"]),
        (BODY + "set s = nodes of ‸", ["oviduct"]),
        (BODY + "set s = nodes of oviduct where ‸", ["x", "surface", "region", "lift"]),
        (BODY + SETS + "script { at 0 s: gr‸ }", ["grasp"]),
        (BODY + SETS + "script { at 0 s: grasp ‸ }", ["waist", "oviduct"]),
        (BODY + SETS + "script { at 0 s: grasp waist ‸ }", ["with"]),
        (BODY + SETS + "script { at 0 s: grasp waist with ‸ }", ["forceps A"]),
        (BODY + SETS + "script { at 0 s: tie waist with s‸", ["square knot", "surgeons knot"]),
        (BODY + SETS + "script { from 0 s to 1 s: move waist by (0, 0, ‸", ["lift"]),
        (BODY + SETS + "script { at 0 s: stop ‸", ["pushing", "turning"]),
        (BODY + SETS + "output { ‸ }", ["trajectory", "force", "energy drift", "surface"]),
        (BODY + SETS + "output { force(‸ }", ["waist", "forceps A"]),
        (BODY + SETS + "output { force(waist) ‸ }", ["every"]),
        (BODY + "output { trajectory ‸ }", ["of", "with", "every"]),
        (BODY + "output { trajectory with ‸ }", ["pressure", "modulus"]),
        ("output { precision is ‸ }", ["single", "double"]),
        (BODY + SETS + "expect ‸", ["force", "count", "lift", "energy drift"]),
        (BODY + SETS + "expect force(‸", ["waist", "forceps A"]),
        (BODY + SETS + "expect force(waist) > 1 N ‸", ["at", "over", "until"]),
        ("simulate { integrator is ‸ }", ["automatic", "velocity verlet", "dop853"]),
        ("environment { contact ‸ }", ["is", "contact stiffness"]),
        ("rules r { if ‸", ["hardness", "elasticity"]),
        ("rules r { if hardness is soft then ‸", ["spring constant", "viscosity"]),
        ("rules r { if hardness is soft then viscosity is ‸", ["low", "medium", "high"]),
        ("learn t { ‸ }", ["data", "fit", "adjust", "hold out", "passes", "against column"]),
        ("learn t { adj‸ }", ["adjust"]),
        (TOE + "learn t { adjust ‸ }", ["spring constant", "strain", "start position", "lift"]),
        (TOE + "learn t { adjust = [‸] }", ["spring constant", "viscosity", "strain"]),
        (BODY + "learn t { adjust mass of ‸ }", ["fallopian tube", "oviduct"]),
        (BODY + BED + "learn t { adjust ‸ }", ["spring constant", "stiffness", "damping"]),
        (BODY + BED + "learn t { adjust stiffness of ‸ }", ["bed", "oviduct"]),
        (BODY + BED + "learn bed { adjust = [‸] }", ["stiffness", "damping"]),
        ("learn t { adjust words of ‸ }", ["hardness", "spring constant"]),
        ("learn t { adjust mass of oviduct per ‸ }", ["node", "region"]),
        ("learn t { adjust weights of ‸ }", ["soft tissue"]),
        (BODY + "learn t { fit = Young's modulus of ‸ }", ["fallopian tube", "all tissues"]),
        ("learn t { revise rules of ‸ }", ["soft tissue"]),
        ("learn t { fit = ‸ }", ["force", "position", "positions"]),
        (BODY + SETS + "learn t { fit = positions(‸", ["waist", "oviduct"]),
        ("learn t { fit = force(waist) ‸ }", ["using", "every", "weighing", "with"]),
        ("learn t { fit = force(waist) using ‸ }", ["column", "columns"]),
        ("learn t { fit = force(waist) with ‸ }", ["free zero"]),
        ("learn t { integrator is ‸ }", ["automatic", "trbdf2", "esdirk43"]),
        ("learn t { method is ‸ }", ["least squares", '"l-bfgs-b"']),
        ('learn t { data "a.csv" { ‸ } }', ["lift", "pause"]),
        ("study s { ‸ }", ["vary", "measure", "design", "keep", "runs", "seed", "expect"]),
        (BODY + "study s { vary ‸ }", ["lift", "hardness", "tissue", "rings"]),
        ("simulate { step = 1 ms }; study s { vary ‸ }", ["integrator", "tolerance"]),
        (BODY + "study s { vary hardness of ‸ }", ["fallopian tube"]),
        (BODY + "study s { vary rings of ‸ }", ["oviduct"]),
        ("study s { vary hardness of fallopian tube = [soft, very ‸] }", ["soft", "hard"]),
        (BODY + "study s { vary tissue of oviduct = [‸] }", ["fallopian tube"]),
        ("study s { vary integrator = [‸] }", ["trbdf2", "dop853"]),
        ("study s { vary lift = ‸ }", ["uniform", "normal", "pause"]),
        ("study s { vary lift = 1 mm ‸ }", ["to", "between"]),
        ("study s { vary lift = 1 mm to 9 mm ‸ }", ["in", "by"]),
        ("study s { vary lift = 1 mm to 9 mm in 9 ‸ }", ["steps"]),
        (BODY + SETS + "study s { measure p = ‸ }", ["max", "force", "time"]),
        (BODY + SETS + "study s { measure p = max(force(‸", ["waist", "forceps A"]),
        (BODY + SETS + "study s { measure p = force(waist) ‸ }", ["at", "every"]),
        (BODY + SETS + "study s { measure p = distance(waist, ‸ }", ["waist", "oviduct"]),
        (BODY + SETS + "study s { measure p = max(force(waist)) ‸ }", ["over", "from"]),
        ("study s { measure p = time of ‸ }", ["rupture", "end the run"]),
        (BODY + SETS + "study s { measure p = time of rupture of ‸ }", ["waist", "oviduct"]),
        (BODY + "study s { measure p = energy at 1 ms; expect max(‸", ["p", "lift"]),
        ("study s { expect ‸ }", ["share", "quantile"]),
        ("study s { design is ‸ }", ["grid", "one at a time", "sobol indices"]),
        ("study s { design is one at ‸ }", ["one at a time"]),
        ("study s { keep is ‸ }", ["nothing", "results"]),
        ("rules r { result is centre of ‸ }", ["centre of gravity"]),
        ("expect ‸", ["error"]),
        ("expect error(‸", ["held out", "data"]),
        ('use "‸', ["fuzzy/soft_tissue", "tissues/fat"]),
        ('body b { mesh is imported { file "‸', ["meshes/liver.obj"]),
        ("body b { mesh is imported { filling is ‸", ["cubes", "tetrahedra"]),
    ],
)  # fmt: skip
def test_what_can_stand_there_is_offered(text, some):
    assert set(some) <= set(offered(text))


@every(
    ("text", "units", "others"),
    [
        ("param far = 5 m‸", {"mm", "m", "ms", "mN"}, set()),
        ("body b { mesh is tube { radius = 3 ‸", {"mm", "m"}, {"s", "N", "mg"}),
        ("simulate { duration = 3 ‸", {"s", "ms", "min"}, {"mm", "N"}),
        ("script { at 3 ‸", {"s", "ms"}, {"mm", "N"}),
        ("script { from 0 s to 3 m‸", {"ms", "min"}, {"mm", "mN"}),
        ("tissue t { spring constant = 3 ‸", {"N/m", "kN/m"}, {"N", "mm"}),
        ("tissue t { viscosity = 3 mN‸", {"mN*s/m"}, {"mN"}),
        ("tissue t { known density from 3 ‸", {"kg/m^3"}, {"mm", "Pa"}),
        ("tissue t { known shear modulus from 3 kPa to 7 ‸", {"kPa", "Pa"}, {"mm", "N"}),
        ("output { energy every 3 ‸", {"ms", "s"}, {"mm"}),
        ("body b { moved by (1, 2, 3) ‸", {"mm", "m"}, {"s", "N"}),
        ('learn t { time using column "t" in ‸', {"ms", "s"}, {"mm"}),
        ("let a = 3 mm + 4 ‸", {"mm", "m"}, {"s"}),
        ("study s { vary lift = [3 ‸", {"mm", "m"}, {"s", "N"}),
        ("study s { vary viscosity of t = 3 ‸", {"mN*s/m"}, {"s", "N"}),
        ("study s { measure p = energy at 3 ‸", {"ms", "s"}, {"mm"}),
    ],
)
def test_units_are_those_of_the_dimension(text, units, others):
    found = set(offered(text))
    assert units <= found
    assert not others & found


@every(
    ("text", "becomes"),
    [
        ("body b { me‸", "body b { mesh is "),
        ("tissue t { known poi‸", "tissue t { known Poisson's ratio from "),
        ("environment { contact sti‸", "environment { contact stiffness = "),
        ("tissue t like fallopian t‸", "tissue t like fallopian tube"),
        ("simulate { integrator is velo‸ }", "simulate { integrator is velocity verlet }"),
        ('use "tissues/upp‸"', None),
        ('use "tissues/ut‸"', 'use "tissues/uterus"'),
        ("set s = no‸ of oviduct", "set s = nodes of oviduct"),
    ],
)
def test_an_offer_takes_the_place_of_what_is_typed(text, becomes):
    if becomes is None:
        assert offered(text) == []
    else:
        assert written(text) == becomes


@pytest.mark.parametrize(
    "text",
    [
        "# a rem‸",
        "param ‸",
        "tissue f‸ {",
        'about "so‸"',
        "table springs of a { 1 ‸",
        "body b‸",
    ],
)
def test_nothing_is_offered_where_anything_new_can_stand(text):
    assert offered(text) == []


def test_the_unit_of_a_path_is_offered_behind_its_table_only():
    order = "script { from 0 s to 1 s: move waist "
    assert {"along", "using"} <= set(offered(f"{BODY}{SETS}{order}‸ }}"))
    assert "in" not in offered(f"{BODY}{SETS}{order}‸ }}")
    assert "in" in offered(f'{BODY}{SETS}{order}along table "a.csv" i‸ }}')


def test_a_name_with_a_reserved_word_is_written_in_quotes():
    text = 'set "head of gland" = nodes of oviduct\nscript { at 0 s: fix head‸ }'
    assert 'fix "head of gland" }' in written(BODY + text)


def test_names_of_files_that_are_not_saved_are_offered(tmp_path):
    documents = OpenDocuments()
    documents.put(tmp_path / "own.tis", "language 1\ntissue silk { mass = 1 mg }\n")
    text = 'language 1\nuse "./own"\nbody b { tissue is s‸ }'
    found = complete(*asked(text, tmp_path / "scene.tis", documents))
    assert "silk" in [one.label for one in found]


@pytest.mark.parametrize("path", [*LIBRARY, *GOOD], ids=lambda path: path.stem)
def test_every_word_of_a_good_scene_is_offered_where_it_stands(path):
    view = view_of(OpenDocuments(), path)
    text, missed = view.source.text, []
    for statement in view.structure.statements:
        if statement.outer is not None and statement.outer.is_table:
            continue
        indices = {head.words[1] for head in statement.chain if head.words[:1] == ["repeat"]}
        for part in statement.parts:
            phrase = view.phrase_at(part.start + 1)
            is_new = phrase is not None and phrase.expected.declares and phrase.term is None
            if part.kind not in ("word", "keyword") or is_new:
                continue
            typed = (
                " ".join(text[one.start : part.stop].lower().split()) == one.label.lower()
                or f"{one.label.lower()} ".startswith(
                    " ".join(text[one.start : part.stop].lower().split()) + " "
                )
                for one in complete(view, part.start + 1)
            )
            if not any(typed) and part.text not in indices:  # a part of many names
                missed.append(part.text)
    assert missed == []


SIGNS = (
    "of", "to", "from", "=", "is", "(", ")", "[", "]", ",", "{", "}", ":", "and", "between",
    "in", "by", "at", "every", "3 mm", "max(", "force", "time", "not", "where", "over", "along",
)  # fmt: skip


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_any_text_can_be_completed_and_explained(path):
    chance, text = random.Random(path.stem), path.read_text(encoding="utf-8")
    for _ in range(12 if path.stem == "studies" else 3):
        place = chance.randrange(len(text))
        typed = " ".join(chance.choices(SIGNS, k=3))
        view, _ = asked(f"{text[:place]} {typed} ‸{text[place + 5 :]}")
        for offset in range(place, place + len(typed) + 9, 2):
            complete(view, min(offset, len(view.source.text)))
            hover(view, min(offset, len(view.source.text)))


def test_the_mark_is_nothing_that_a_scene_holds():
    assert MARK not in shipped("scenes/sterilisation.tis")


WHOLE = """set held = nodes of oviduct where x < 1 mm
environment { damping = 1 mN*s/m }
script { at 0 s: fix held }
simulate { duration = 1 ms }
"""


def test_entries_are_offered_to_vary_if_a_scene_takes_them():
    """The compiler names what a block does not have; of values nothing is asked here."""
    labels = offered(BODY + WHOLE + "study s { vary ‸ }")
    entries = [one for one in labels if one not in ("lift", "pause")]
    assert {"rings", "tissue", "hardness", "mass", "tolerance", "gravity"} <= set(entries)
    assert not {"cell", "reach", "tip", "mesh", "Young's modulus", "of"} & set(entries)
    for entry in entries:
        found = offered(BODY + WHOLE + f"study s {{ vary {entry} of ‸ }}")
        names = [f"{entry} of {owner}" for owner in found] or [entry]
        assert any(is_taken(name) for name in names), names


def is_taken(name):
    said = tissuec.check(HEAD + BODY + WHOLE, params={name: "0"})
    return not any(one.code in ("TIS202", "TIS303", "TIS505") for one in said)
