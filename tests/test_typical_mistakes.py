"""Typical mistakes in one scene, each told once, at its place, with a way out.

Every mistake is a replacement in a scene that is right. Where the hint proposes an edit, making
it gives a text without errors.
"""

import shlex
from collections.abc import Iterable

import pytest
from click.testing import CliRunner

from tests.every import every
from tests.magnitudes import keeps_magnitudes
from tests.mistakes import Mistake, clinics, habits, layers, meanings, volumes
from tests.scene.test_mistakes_together import SCENE as TOGETHER
from tissuec.cli import group
from tissuec.core.errors import CompileError, Diagnostic, TissueError
from tissuec.core.source import Source
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

SCENE = """language 1
use "fuzzy/soft_tissue"
about "A vessel that is lifted."
param lift = 5 mm between 0 mm and 9 mm
tissue gum { spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg }
tissue skin {
  described in soft tissue
  hardness is soft; elasticity is big; weight is low; shiftability is low
  consistency is smooth
}
body vessel {
  mesh is tube {
    axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 5; sides = 10
    diagonals is both; interior is crossed
  }
  tissue is gum
}
body patch {
  mesh is sheet {
    corner = (0, 0, 10) mm; first edge = (9, 0, 0) mm; second edge = (0, 9, 0) mm
    rows = 4; columns = 4; diagonals is both
  }
  tissue is skin
}
set root = nodes of vessel where x < 1 mm
set tip = nodes of vessel where x between 19 mm and 21 mm
set rim = nodes of patch where y < 1 mm
tool forceps A { kind is forceps }
tool shears { kind is scissors }
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: { fix root; fix rim }
  at 0.1 s: grasp tip with forceps A
  from 0.1 s to 0.2 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile
  at 0.3 s: cut vessel along plane through (10, 0, 0) mm facing (1, 0, 0) with shears
  when force(forceps A) > 1 N: release forceps A
}
simulate { duration = 0.4 s; tolerance = 1e-3 }
output { trajectory every 10 ms; force of forceps A every 1 ms }
expect speed(rim) < 1 m/s over run
"""


M = Mistake
MISTAKES = {
    # units and numbers
    "unit spelt out": M("0.4 s;", "0.4 sec;", "TIS104", "sec", '"s"'),
    "unit in the plural": M("at 0.1 s", "at 0.1 seconds", "TIS104", "seconds", '"s"'),
    "unit by its name": M("10 mg", "10 milligrams", "TIS104", "milligrams", '"mg"'),
    "unit in capitals": M("10 mg", "10 MG", "TIS104", "MG", '"mg"'),
    "unit left out": M("radius = 3 mm", "radius = 3", "TIS501", "3", '"3 mm"'),
    "unit of a vector left out": M(
        "(20, 0, 0) mm", "(20, 0, 0)", "TIS501", "(20, 0, 0)", '"(20, 0, 0) mm"'
    ),
    "unit of another kind": M("40 N/m;", "40 Pa;", "TIS502", "40 Pa", "N/m"),
    "units side by side": M("0.01 N*s/m", "0.01 Ns/m", "TIS104", "Ns", '"N*s/m"'),
    "decimal comma": M("0.4 s;", "0,4 s;", "TIS108", ",", "0.4 s"),
    "digits grouped": M("40 N/m;", "1'000 N/m;", "TIS114", "'", '"1000"'),
    "point without a digit": M("0.4 s;", ".4 s;", "TIS100", ".", '"0.4"'),
    "superscript": M("m/s^2", "m/s²", "TIS114", "²", "^2"),
    "share for a percentage": M(
        "10 mg }", "10 mg; prestress = 2 }", "TIS308", "2", '"2 %"'
    ),
    "whole number as a fraction": M("rings = 5;", "rings = 5.5;", "TIS308", "5.5", "5 or 6"),
    "negative mass": M("10 mg", "-10 mg", "TIS308", "-10 mg", '"10 mg"'),
    # names
    "tissue misspelt": M("tissue is gum", "tissue is gumm", "TIS301", "gumm", '"gum"'),
    "word misspelt": M("is soft;", "is sofft;", "TIS201", "sofft", '"soft"'),
    "entry misspelt": M("radius =", "raduis =", "TIS303", "raduis", '"radius"'),
    "entry by another word": M(
        "spring constant = 40 N/m", "stiffness = 40 N/m", "TIS303", "stiffness",
        '"spring constant"',
    ),
    "part misspelt": M("environment {", "enviroment {", "TIS303", "enviroment", "environment"),
    "verb misspelt": M("fix root", "fixx root", "TIS404", "fixx", '"fix"'),
    "set misspelt": M("grasp tip", "grasp tipp", "TIS301", "tipp", '"tip"'),
    "tool misspelt": M("with shears", "with sheers", "TIS301", "sheers", '"shears"'),
    "measure misspelt": M("expect speed", "expect sped", "TIS701", "sped", '"speed"'),
    "measure without a subject misspelt": M(
        "speed(rim) < 1 m/s", "enrgy drift < 1 %", "TIS701", "enrgy drift", '"energy drift"'
    ),
    "mesh misspelt": M("is tube {", "is tub {", "TIS305", "tub", '"tube"'),
    "file misspelt": M("fuzzy/soft_tissue", "fuzzy/soft_tisue", "TIS601", None, "soft_tissue"),
    "property of tissue in a body": M(
        "tissue is gum\n",
        "tissue is gum; viscosity = 2 N*s/m\n",
        "TIS312",
        "viscosity = 2 N*s/m",
        "tissue NAME { viscosity = 2 N*s/m }",
    ),
    "entry of the mesh in a body": M(
        "tissue is gum\n",
        "tissue is gum; rings = 5\n",
        "TIS303",
        "rings",
        "mesh is tube { rings = 5 }",
    ),
    "on for of in an output": M(
        "force of forceps A", "force on forceps A", "TIS702", None, '"force(forceps A)"'
    ),
    "number in a name": M("set rim =", "set rim 2 =", "TIS109", "2", '"rim 2"'),
    "reserved word in a name": M(
        "set rim =", "set end of rim =", "TIS115", "of", '"end of rim"'
    ),
    "reserved word as a name": M(
        "tool shears {", "tool table {", "TIS115", "table", 'tool "table"'
    ),
    "word as a tissue": M("tissue is gum", "tissue is soft", "TIS301", "soft", "hardness is"),
    "number as a tissue": M(
        "tissue is gum", "tissue = gum", "TIS312", None, '"tissue is gum"'
    ),
    # signs of other languages
    "assignment as in a program": M(
        "body vessel {", "speed = 0.006\nvessel = Body(mesh=3)\nbody vessel {", "TIS312", "=",
        "body NAME",
    ),
    "key with a colon": M("radius = 3 mm;", "radius: 3 mm;", "TIS312", ":", "radius = 3 mm"),
    "block with a colon": M("body patch {", "body skin:\nbody patch {", "TIS312", ":", "{"),
    "comma between entries": M("rings = 5;", "rings = 5,", "TIS107", ",", '";"'),
    "comment with slashes": M("use", "// words\nuse", "TIS312", "//", '"#"'),
    "equals as a test": M("where y < 1 mm", "where y = 1 mm", "TIS111", "=", '"y == 1 mm"'),
    "chained comparison": M(
        "x between 19 mm and 21 mm", "19 mm < x < 21 mm", "TIS100", "<",
        '"x between 19 mm and 21 mm"',
    ),
    "limits reversed": M(
        "between 19 mm and 21 mm", "between 21 mm and 19 mm", "TIS308", "21 mm",
        '"between 19 mm and 21 mm"',
    ),
    "limits of a param reversed": M(
        "between 0 mm and 9 mm", "between 9 mm and 0 mm", "TIS308", "9 mm",
        '"between 0 mm and 9 mm"',
    ),
    "logarithm of zero": M(
        "gravity = (0, 0, -9.81) m/s^2", "gravity = (0, 0, log(0)) m/s^2", "TIS504", "0",
        "the logarithm of 0 has no value",
    ),
    "division by zero as a power": M(
        "gravity = (0, 0, -9.81) m/s^2", "gravity = (0, 0, 0^-1) m/s^2", "TIS504", "0",
        "division by zero",
    ),
    "if for when": M("when force", "if force", "TIS312", "if", "when force"),
    "is for equals": M("param lift =", "param lift is", "TIS312", "is", "="),
    "is for equals in a block": M(
        "tolerance = 1e-3", "tolerance is 1e-3", "TIS312", "is", '"tolerance = 1e-3"'
    ),
    "is for equals before a vector": M(
        "gravity = (", "gravity is (", "TIS312", "is", '"gravity = (0, 0, -9.81) m/s^2"'
    ),
    "equals for is before a block": M(
        "mesh is tube {", "mesh = tube {", "TIS312", "=", '"mesh is tube {"'
    ),
    "equals for is of a tool": M(
        "{ kind is forceps }", "{ kind = forceps }", "TIS312", "kind = forceps",
        '"kind is forceps"',
    ),
    "equals for is of bending": M(
        "tissue is skin", "tissue is skin; bending = soft", "TIS312", "bending = soft",
        '"bending is soft"',
    ),
    "equals for is of a law": M(
        "mass = 10 mg", "mass = 10 mg; spring law = linear", "TIS312", "spring law = linear",
        '"spring law is linear"',
    ),
    "param as a word": M("set tip", "param h is soft\nset tip", "TIS312", "soft", "number"),
    "and for a semicolon": M(
        "is soft; elast", "is soft and elast", "TIS107", "and", '";"'
    ),
    "is left out": M(
        "tissue is skin", "tissue is skin; rupture allowed", "TIS303", "rupture allowed",
        '"rupture is allowed"',
    ),
    "curly quotes": M('about "A vessel that is lifted."', "about “A”", "TIS114", None, '"'),
    "quotes left out": M(
        'use "fuzzy/soft_tissue"', "use fuzzy/soft_tissue", "TIS312", "/", 'use "fuzzy/'
    ),
    "brace missing": M("tissue is skin\n}\n", "tissue is skin\n", "TIS101", "", '"}"'),
    "brace too many": M("tissue is skin\n}\n", "tissue is skin\n}}\n", "TIS102", "}", "remove"),
    "opening brace missing": M("script {", "script", "TIS101", "script", "script {"),
    "bracket missing": M("(0, 0, 10) mm", "(0, 0, 10 mm", "TIS102", "(", '")"'),
    "colon missing": M("at 0.1 s: grasp", "at 0.1 s grasp", "TIS105", "grasp", "s: grasp"),
    "two statements on a line": M("rings = 5;", "rings = 5", "TIS107", "sides", "before"),
    "time of a condition": M(
        "> 1 N: rel", "> 1 N at 0.1 s: rel", "TIS105", "at", '"when force(forceps A) > 1 N: …"'
    ),
    "language further down": M(
        "set rim", "language 1\nset rim", "TIS307", "language", "remove"
    ),
    "measure without its body": M(
        "expect speed(rim) < 1 m/s", "expect energy < 1 J", "TIS702", "energy",
        "write energy(vessel)",
    ),
    "measure without its tool": M(
        "when force(forceps A)", "when force", "TIS702", "force", "write force(vessel)"
    ),
    "measure of jaws without them": M(
        "when force(forceps A)", "when grip", "TIS702", "grip", "write grip(A)"
    ),
    "measure of two without both": M(
        "expect speed(rim) < 1 m/s", "expect distance < 1 m", "TIS702", "distance",
        "write distance(A, B)",
    ),
    # meaning
    "gravity as a number": M(
        "(0, 0, -9.81) m/s^2", "-9.81 m/s^2", "TIS312", "-9.81 m/s^2", "(0, 0, -9.81) m/s^2"
    ),
    "gravity upwards": M(
        "(0, 0, -9.81) m/s^2", "9.81 m/s^2", "TIS312", "9.81 m/s^2", "(0, 0, -9.81) m/s^2"
    ),
    "gravity without a unit": M(
        "(0, 0, -9.81) m/s^2", "9.81", "TIS312", "9.81", "(0, 0, -9.81) m/s^2"
    ),
    "vector without brackets": M(
        "(0, 0, -9.81) m/s^2", "0, 0, -9.81 m/s^2", "TIS100", ",", '"(0, 0, -9.81) m/s^2"'
    ),
    "entry missing": M("; sides = 10", "", "TIS304", None, "sides = 10"),
    "duration missing": M("duration = 0.4 s; ", "", "TIS304", None, "duration = 1 s"),
    "profile of another name": M(
        "using smooth profile", "using linear", "TIS305", None, '"constant speed"'
    ),
    "profile that jumps": M(
        "using smooth profile", "using constant", "TIS306", None, "constant speed"
    ),
    "profile unfinished": M("using smooth profile", "using sine", "TIS304", None, "of 2 Hz"),
    "nothing to stop": M(
        "release forceps A", "stop", "TIS304", "stop", "stop moving SET"
    ),
    "tool of another kind": M("with shears", "with forceps A", "TIS405", None, "shears"),
    "fixed nodes moved": M("grasp tip", "grasp root", "W409", None, "free them"),
    "cut through nothing": M("(10, 0, 0) mm", "(10, 0, 0) cm", "W410", None, "x runs from"),
    "word of other programs misspelt": M(
        "spring constant = 40 N/m;", "stifness = 40 N/m;", "TIS303", "stifness",
        'did you mean "spring constant"?',
    ),
    "force compared for equality": M(
        "expect speed(rim) < 1 m/s over run", "expect force(root) == 5 mN at 0.3 s", "W702",
        "force(root) == 5 mN", "force(root) between 4.95 mN and 5.05 mN",
    ),
    "hedge without effect": M("is soft;", "is very soft;", "W205", "very soft", '"soft"'),
}  # fmt: skip


def said(text: str) -> tuple[Diagnostic, ...]:
    try:
        return check_request(Request(Source("scene.tis", text)))[1]
    except CompileError as error:
        return error.diagnostics


#: Scenes by the mistakes in them.
EVERY = [
    *((SCENE, name, mistake) for name, mistake in MISTAKES.items()),
    *((layers.SCENE, name, mistake) for name, mistake in layers.MISTAKES.items()),
    *((layers.SCENE, name, mistake) for name, mistake in habits.MISTAKES.items()),
    *((layers.SCENE, name, mistake) for name, mistake in meanings.MISTAKES.items()),
    *((layers.SCENE, name, mistake) for name, mistake in clinics.MISTAKES.items()),
    *((volumes.SCENE, name, mistake) for name, mistake in volumes.MISTAKES.items()),
]


@pytest.mark.parametrize(
    "scene", [SCENE, layers.SCENE, volumes.SCENE], ids=["vessel", "layers", "volumes"]
)
def test_the_scene_itself_is_right(scene):
    assert not said(scene)


def weight(findings: Iterable[Diagnostic]) -> tuple[int, int]:
    errors = [one.severity == "error" for one in findings]
    return sum(errors), len(errors)


@every("case", EVERY, parts=5)
def test_a_typical_mistake_is_answered_once_at_its_place_with_a_way_out(case):
    scene, name, mistake = case
    text = mistake.made_in(scene)
    before = said(text)
    found = [one for one in before if one.code != "W502"]
    told = f"{name}\n" + "\n".join(map(str, found))
    assert [one.code for one in found] == [mistake.code], told
    (finding,) = found
    assert finding.span is not None
    assert mistake.marked in (None, finding.span.text[:80]), told
    assert mistake.hint in (finding.hint or finding.message), told
    assert "expected a time word" not in finding.hint, f"a list of tokens\n{told}"
    for number, edit in enumerate(finding.edits):
        mended = text[: edit.span.start] + edit.text + text[edit.span.end :]
        after = said(mended)
        rest = [one.code for one in after if one.code != "W502"]
        left = f"{told}\n{edit.text!r} leads to\n" + "\n".join(map(str, after))
        assert keeps_magnitudes(edit) or mistake.code == "TIS308", left
        if number == 0 and mistake.rest:
            assert rest == [*mistake.rest], left
        else:
            # A name that is mended in one place may be wanted in another.
            assert weight(after) < weight(before) or mistake.code not in rest, left


@pytest.mark.parametrize(
    ("old", "new", "mended"),
    [
        ("force(floor) < 1 N", "force(floor) == 5-6 mN", "force(floor) between 5 mN and 6 mN"),
        ("x > 39 mm", "x == 39-40 mm", "x between 39 mm and 40 mm"),
    ],
)
def test_a_range_is_tested_with_between(old, new, mended):
    scene = f"{layers.SCENE}expect force(floor) < 1 N at 0.3 s\n".replace(old, new)
    (found,) = said(scene)
    (edit,) = found.edits
    after = scene[: edit.span.start] + edit.text + scene[edit.span.end :]
    assert found.code == "TIS312"
    assert mended in after
    assert not said(after)


def test_a_file_beside_the_scene_is_proposed_with_its_dot(tmp_path):
    (tmp_path / "other.tis").write_text("language 1\nlet width = 1 mm\n")
    scene = tmp_path / "scene.tis"
    scene.write_text('language 1\nuse "other"\n')
    with pytest.raises(CompileError) as caught:
        check_request(Request.file(scene))
    found = next(one for one in caught.value.diagnostics if one.code == "TIS601")
    assert found.hint.startswith('did you mean "./other"')
    assert [edit.text for edit in found.edits] == ["./other"]


COMMAND_LINES = [
    ("--set lift = 8 mm", '--set "lift = 8 mm"'),
    ("--set lift = -8 mm --strict", '--set "lift = -8 mm"'),
    ("--set hardness of skin is soft", '--set "hardness of skin is soft"'),
    ("--tolerance 1e-6", '--set "tolerance = 1e-6"'),
    ("--tolerance=1e-6", '--set "tolerance = 1e-6"'),
    ("--step -1e-6 --quiet", '--set "step = -1e-6"'),
    ("--breaking-force 3 N", '--set "breaking force = 3 N"'),
    ("--gravity '(0, 0, 0) m/s^2'", '--set "gravity = (0, 0, 0) m/s^2"'),
    ("--title 'a \"b\"'", "--set 'title = a \"b\"'"),
    ("--tolerance", '--set "tolerance = …"'),
]


@pytest.mark.parametrize("place", ["before", "behind"])
@pytest.mark.parametrize(("words", "proposed"), COMMAND_LINES)
def test_what_is_no_option_is_answered_once_by_what_sets_it(tmp_path, words, proposed, place):
    scene = tmp_path / "scene.tis"
    scene.write_text(TOGETHER)
    line = [*shlex.split(words), str(scene)] if place == "before" else None
    said = CliRunner().invoke(group, ["check", *(line or [str(scene), *shlex.split(words)])])
    assert said.exit_code == 2
    assert said.output.count("Error") == 1
    assert said.output.rstrip().endswith(proposed)


MISSING = [
    ("meshes/liver.obj", "tissuec library copy meshes/liver"),
    ("liver.obj", "tissuec library copy meshes/liver"),
    ("spleeen.stl", 'did you mean "spleen.stl"?'),
]


@pytest.mark.parametrize(("name", "hint"), MISSING)
def test_a_mesh_that_is_not_there_may_be_one_of_the_library(tmp_path, monkeypatch, name, hint):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "spleen.stl").touch()
    with pytest.raises(TissueError) as caught:
        CliRunner().invoke(group, ["import", name], catch_exceptions=False)
    assert str(caught.value).endswith(hint)


def test_a_mesh_that_is_not_there_is_named_with_its_folder(tmp_path):
    missing = tmp_path / "scans" / "kidney.stl"
    with pytest.raises(TissueError) as caught:
        CliRunner().invoke(group, ["import", str(missing)], catch_exceptions=False)
    assert str(missing) in str(caught.value)


def test_numbers_above_a_call_are_told_how_to_be_declared():
    (found,) = said("language 1\nspeed = 0.006\nvessel = Body(mesh=3)\n")
    assert [note.message for note in found.notes] == [
        'to declare a number, write "param speed = …"'
    ]
