"""Mistakes of all stages are told in one go, and none that only follows from another.

A scene is made wrong in two places at a time. Each mistake alone is told by one error; both are
told by the same two.
"""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.every import every
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.meshes.generators.tube import Tube
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

SCENE = """language 1
use "tissues/skin"
param lift = 5 mm between 0 mm and 9 mm
let twice = 2 * lift
tissue gum { spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg }
tissue stiff gum like gum { spring constant = 90 N/m }
body vessel {
  mesh is tube {
    axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 5; sides = 10
    interior is crossed
  }
  tissue is gum
  interface is mean
  region far where x > 15 mm { tissue is stiff gum }
}
body patch {
  mesh is sheet {
    corner = (0, 0, 10) mm; first edge = (9, 0, 0) mm; second edge = (0, 9, 0) mm
    rows = 4; columns = 4
  }
  tissue is skin
}
set root = nodes of vessel where x < 1 mm
set tip = nodes of vessel where region is far
set both = [root, tip]
set rim = nodes of patch where y < 1 mm
tool forceps A { kind is forceps }
tool shears { kind is scissors }
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: fix root
  at 0 s: fix rim
  at 0.1 s: grasp tip with forceps A
  from 0.1 s to 0.2 s: move forceps A by (0 mm, 0 mm, twice) using smooth profile
  at 0.3 s: cut vessel along plane through (10, 0, 0) mm facing (1, 0, 0) with shears
  when force(forceps A) > 1 N: release both
}
simulate { duration = 0.4 s; tolerance = 1e-3 }
output { trajectory every 10 ms; force of forceps A every 1 ms }
expect gap(vessel) > 1 mm at 0.4 s
expect speed(rim) < 1 m/s over run
"""


class Mistake(NamedTuple):
    """A replacement in the scene, and the code of the one error that tells it."""

    old: str
    new: str
    code: str


MISTAKES = {
    "use of no file": Mistake("tissues/skin", "tissues/skim", "TIS601"),
    "part misspelt": Mistake("set root", "sett root", "TIS303"),
    "block misspelt": Mistake("simulate {", "simulat {", "TIS303"),
    "body misspelt": Mistake("body vessel", "bodi vessel", "TIS303"),
    "tool misspelt": Mistake("tool forceps A", "tol forceps A", "TIS303"),
    "param out of bounds": Mistake("param lift = 5 mm", "param lift = 10 mm", "TIS308"),
    "sum of two dimensions": Mistake("2 * lift", "2 * lift + 1 s", "TIS502"),
    "unit of a tissue": Mistake("= 40 N/m", "= 40 N", "TIS502"),
    "tissue misspelt": Mistake("tissue is skin", "tissue is skinn", "TIS301"),
    "unit of a mesh": Mistake("radius = 3 mm", "radius = 3 N", "TIS502"),
    "mesh that cannot be": Mistake("(0, 9, 0) mm", "(9, 0, 0) mm", "TIS309"),
    "interface misspelt": Mistake("is mean", "is men", "TIS305"),
    "tissue of a region": Mistake("is stiff gum", "is stif gum", "TIS301"),
    "region misspelt": Mistake("region is far", "region is fra", "TIS301"),
    "empty region": Mistake("where x > 15 mm", "where x > 15 m", "TIS302"),
    "empty set": Mistake("where y < 1 mm", "where y < -1 mm", "TIS302"),
    "kind of a tool": Mistake("kind is forceps", "kind is forcep", "TIS305"),
    "gravity as a number": Mistake("(0, 0, -9.81) m/s^2", "-9.81 m/s^2", "TIS312"),
    "verb misspelt": Mistake("fix rim", "fx rim", "TIS404"),
    "tool of an order misspelt": Mistake("with shears", "with sheers", "TIS301"),
    "unit of a motion": Mistake("by (0 mm, 0 mm, twice)", "by (0, 0, 1) N", "TIS502"),
    "set of a grasp misspelt": Mistake("grasp tip", "grasp tipp", "TIS301"),
    "unit of a condition": Mistake("> 1 N:", "> 1 m:", "TIS502"),
    "unit of the duration": Mistake("duration = 0.4 s", "duration = 0.4 mm", "TIS502"),
    "tolerance too large": Mistake("tolerance = 1e-3", "tolerance = 1", "TIS308"),
    "output misspelt": Mistake("trajectory every", "trajectry every", "TIS701"),
    "measure misspelt": Mistake("expect gap", "expect gapp", "TIS701"),
    "unit that there is not": Mistake("mass = 10 mg", "mass = 10 mgg", "TIS104"),
    "unit behind a vector": Mistake("0, 10) mm", "0, 10) mmm", "TIS104"),
    "units side by side": Mistake("viscosity = 0.01 N*s/m", "viscosity = 0.01 N s/m", "TIS104"),
    "unit of no size": Mistake("facing (1, 0, 0)", "facing (1, 0, 0) m^999", "TIS104"),
    "number too large": Mistake("every 1 ms", "every 1e999 ms", "TIS119"),
    "unit of an expectation": Mistake("< 1 m/s over", "< 1 m over", "TIS502"),
}

#: Mistakes beside those that they hide: what asks for a name that may be declared in what could
#: not be read, and what stands in a part that could not be read at all.
HIDDEN = {
    "use of no file": (
        "tissue misspelt",
        "tissue of a region",
        "region misspelt",
        "tool of an order misspelt",
        "set of a grasp misspelt",
    ),
    "block misspelt": ("unit of the duration", "tolerance too large"),
    "body misspelt": (
        "unit of a mesh",
        "interface misspelt",
        "tissue of a region",
        "region misspelt",
        "empty region",
    ),
    "tool misspelt": ("kind of a tool", "unit of a condition"),
    "param out of bounds": ("sum of two dimensions",),
    "unit of a mesh": ("region misspelt", "empty region"),
    "mesh that cannot be": ("empty set", "unit of an expectation"),
    "empty region": ("region misspelt",),
    "empty set": ("unit of an expectation",),
    "unit behind a vector": ("mesh that cannot be", "empty set", "unit of an expectation"),
}


@cache
def said(*mistakes: str) -> frozenset[str]:
    """Return what is said about the scene with some mistakes."""
    text = SCENE
    for name in mistakes:
        old, new, _ = MISTAKES[name]
        assert text.count(old) == 1
        text = text.replace(old, new)
    return said_of(text)


def said_of(text: str) -> frozenset[str]:
    """Return the code and the place of all that is said about a text."""
    try:
        _, found = check_request(Request(Source("scene.tis", text)))
    except CompileError as error:
        found = error.diagnostics
    return frozenset(f"{d.code} {d.span.place if d.span else '?'} {d.message}" for d in found)


def test_the_scene_itself_is_right() -> None:
    assert not said()


@every("name", MISTAKES)
def test_a_mistake_is_told_by_one_error(name: str) -> None:
    (error,) = said(name)
    assert error.startswith(MISTAKES[name].code)


def assert_told_together(name: str, other: str) -> None:
    expected = said(name) | said(other)
    if other in HIDDEN.get(name, ()):
        expected = said(name)
    elif name in HIDDEN.get(other, ()):
        expected = said(other)
    assert said(name, other) == expected, other


@pytest.mark.parametrize("name", MISTAKES)
def test_two_mistakes_are_told_by_the_errors_of_each(name: str) -> None:
    """Each with those it hides, and with a fifth of the others, near ones and far ones."""
    place = list(MISTAKES).index(name)
    fifth = list(MISTAKES)[place + 1 :: 5]
    for other in dict.fromkeys((*HIDDEN.get(name, ()), *fifth)):
        assert_told_together(name, other)


@pytest.mark.slow
@pytest.mark.parametrize("name", MISTAKES)
def test_any_two_mistakes_are_told_by_the_errors_of_each(name: str) -> None:
    for other in list(MISTAKES)[list(MISTAKES).index(name) + 1 :]:
        assert_told_together(name, other)


# --- what only follows from a mistake is not told ---


@pytest.mark.parametrize(
    "piece",
    [
        "spin = 1 rad/s; velocity = (0, 0, 1) m/s",
        "mass = heavy",
        "prestress = 3 %",
        "region near where x < 3 mm and region is far { tissue is gum }",
    ],
)
def test_a_body_that_cannot_be_made_can_be_named(piece: str) -> None:
    (error,) = said_of(SCENE.replace("interface is mean", f"interface is mean; {piece}"))
    assert error.split(" ")[1] == "scene.tis:13"


@pytest.mark.parametrize("entry", ["mass", "radius"])
def test_a_param_that_is_wrong_is_told_once_however_often_it_is_used(entry: str) -> None:
    """The second body finds it wrong already."""
    wrong = SCENE.replace("param lift", "let wrong = 3 mm + 1 s\nparam lift")
    if entry == "mass":
        wrong = wrong.replace("mass = 10 mg", "mass = wrong")
        wrong = wrong.replace("spring constant = 90 N/m", "spring constant = wrong")
    else:
        wrong = wrong.replace("radius = 3 mm", "radius = wrong")
        wrong = wrong.replace("corner = (0, 0, 10) mm", "corner = (0 mm, 0 mm, wrong)")
    (error,) = said_of(wrong)
    assert error.startswith("TIS502 scene.tis:3 ")


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("simulate { duration", "simulate { duratoin", "TIS303"),
        ("tolerance = 1e-3", "integrator is velocity verle; step = 1 ms", "TIS305"),
        ("tolerance = 1e-3", "integrator is propagation; step = 1 mm", "TIS502"),
        ("environment { gravity", "enviroment { gravity", "TIS303"),
        ("tool shears { kind is scissors }", "tool shears", "TIS312"),
        ('use "tissues/skin"', "use skin", "TIS312"),
        ("at 0.1 s: grasp tip with forceps A", "at 0.1 s: grsp tip with forceps A", "TIS404"),
    ],
)
def test_what_follows_from_a_misspelt_part_is_not_told(old: str, new: str, code: str) -> None:
    assert SCENE.count(old) == 1
    (error,) = said_of(SCENE.replace(old, new))
    assert error.startswith(code)


BLOCK = """body block {
  mesh is lattice { cell = (4, 4, 2) mm; box from (0, 0, 20) mm to (16, 16, 24) mm }
  tissue is gel; made of quadratic elements
}
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3 }
"""


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [("(4, 4, 2) mm", "(4, 4) mm", "TIS312"), ("elements", "element", "TIS305")],
)
def test_a_block_of_elements_is_told_one_mistake(old: str, new: str, code: str) -> None:
    (warning,) = said_of(SCENE + BLOCK)
    assert warning.startswith("W310 ")  # nothing holds it
    (error,) = said_of(SCENE + BLOCK.replace(old, new))
    assert error.startswith(code)


def test_a_wrong_table_leaves_its_body_undrawn() -> None:
    net = """body net { mesh is explicit; tissue is gum }
table nodes of net in mm with columns "id x" { 1 0; 2 5 }
table sprins of net with columns "a b" { 1 2 }
set links = springs of net where x < 9 mm
expect strain(links) < 1 over run
"""
    (error,) = said_of(SCENE + net)
    assert error.startswith("TIS303 ")


def test_a_scene_without_bodies_is_not_told_what_it_names() -> None:
    start, stop = SCENE.index("body vessel"), SCENE.index("set root")
    (error,) = said_of(SCENE[:start] + SCENE[stop:])
    assert error.endswith("the scene has no body")


def test_a_huge_body_is_not_drawn_only_to_find_more_mistakes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Tube, "build", lambda mesh: pytest.fail("it was drawn"))
    huge = SCENE.replace("rings = 5", "rings = 300000")
    assert len(said_of(huge.replace("fix rim", "fx rim").replace("0.4 s;", "0.4 mm;"))) == 2


def test_findings_of_the_files_that_a_scene_uses_come_with_its_own(tmp_path: Path) -> None:
    (tmp_path / "broken.tis").write_text("language 1\ntissue fat { mass = 10 mgg }\n")
    scene = tmp_path / "scene.tis"
    scene.write_text(SCENE.replace('use "tissues/skin"', 'use "tissues/skin"; use "./broken"'))
    wrong = scene.read_text().replace("fix rim", "fx rim").replace("is skin\n", "is fat\n")
    scene.write_text(wrong)
    with pytest.raises(CompileError) as caught:
        check_request(Request.file(scene))
    assert {d.code for d in caught.value.diagnostics} == {"TIS104", "TIS404"}
