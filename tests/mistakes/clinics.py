# ruff: noqa: E501  # texts as they are
"""Mistakes of clinicians and researchers: units of papers, habits of other files, copies, loops."""

from tests.mistakes import Mistake as M

_PAD = "tissue is fat\n"
_LIFT = "by (0 mm, 0 mm, lift) using smooth profile"
_PRESS = "move probe by (0, 0, -3) mm using smooth profile"
_COUNT = "expect count(pieces"
_FORCE = "expect force(forceps A along (0, 0, 1)) > 1 mN at 0.3 s"
_OWN = "tissue own { described"
_MESH = "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (40, 20, 10) mm }"


def _pad(written: str, code: str, marked: str, hint: str, *rest: str) -> M:
    return M(_PAD, f"tissue is fat; {written}\n", code, marked, hint, rest)


def _top(written: str, code: str, marked: str, hint: str, *rest: str) -> M:
    return M(_COUNT, f"{written}\n{_COUNT}", code, marked, hint, rest)


def _fix(written: str, code: str, marked: str, hint: str, *rest: str) -> M:
    return M("fix left edge; fix floor", written, code, marked, hint, rest)


MISTAKES = {
    # quantities by other names, files for tissues
    "fibre stiffness": M(_OWN, "tissue own { fibre stiffness = 5 MPa; described", "TIS202", "fibre stiffness", '"fibre modulus"'),
    "fiber modulus": M(_OWN, "tissue own { fiber modulus = 5 MPa; described", "TIS202", "fiber modulus", '"fibre modulus"'),
    "like a file": M("tissue graft like own", 'tissue graft like "matter/liver"', "TIS301", '"matter/liver"', 'use "matter/liver" at the top, and liver here (also in it: cirrhotic liver, steatotic liver)'),
    "like a file in use": M("tissue graft like own", 'tissue graft like "matter/fat"', "TIS301", '"matter/fat"', "its tissues: fat"),
    "mesh by its file": M(_MESH, 'mesh is "meshes/liver.obj"', "TIS305", '"meshes/liver.obj"', 'mesh is imported { file "meshes/liver.obj" in mm }', ("TIS304",)),
    "backslash in a path": M('use "matter/fat"', 'use "matter\\fat"', "TIS603", 'use "matter\\fat"', 'write "matter/fat"'),
    # units
    "length for a frequency": M("damping = 1 mN*s/m }", "mass damping = 5 mm }", "TIS502", "5 mm", "such as 5 Hz"),
    "power without its sign": M(_OWN, "tissue own { Young's modulus = 0.005 N/mm2; described", "TIS104", "0.005 N/mm2", '"0.005 N/mm^2"'),
    "power of ten": M("tolerance = 1e-3", "tolerance = 1 x 10^-3", "TIS312", "1 x 10^-3", '"1e-3"'),
    "power of ten with a dot": M("tolerance = 1e-3", "tolerance = 1·10^-3", "TIS312", "1·10^-3", '"1e-3"'),
    "unit after a range": M("> 1 mN at 0.3 s", "between 1 and 3000 mN at 0.3 s", "TIS501", "1", '"1 mN"'),
    "unit after a range of a study": _top("study s { vary lift = 2 to 10 mm in 5 steps; measure pull = max(force(forceps A)) }", "TIS501", "2", '"2 mm"'),
    "modulus without a unit": M(_OWN, "tissue own { Young's modulus = 5; described", "TIS501", "5", '"5 kPa"'),
    "values without brackets or blanks": _top("study s { vary lift = 1,2,3; measure pull = max(force(forceps A)) }", "TIS312", "1,2,3", '"[1,2,3]"', "TIS501"),
    "values without a sign": _top("study s { vary lift 2 mm to 3 mm; measure pull = max(force(forceps A)) }", "TIS312", " ", 'write "="'),
    "degree sign": _pad("turned by 20° around (0, 0, 1)", "TIS114", "°", "type deg"),
    # order of words
    "tool before the verb": M("grasp right edge with forceps A", "with forceps A grasp right edge", "TIS312", "with", "grasp SET with TOOL"),
    "way before what moves": M(f"move forceps A {_LIFT}", "move by (0 mm, 0 mm, lift) forceps A using smooth profile", "TIS312", "by (0 mm, 0 mm, lift) forceps A", '"forceps A by (0 mm, 0 mm, lift)"'),
    "profile without using": M(_LIFT, "by (0 mm, 0 mm, lift) smooth profile", "TIS312", " smooth profile", '"using smooth profile"'),
    "speed without using": M(_LIFT, "by (0 mm, 0 mm, lift) constant speed", "TIS312", " constant speed", '"using constant speed"'),
    "way downwards": M(_PRESS, "move probe 3 mm down using smooth profile", "TIS312", "3 mm down", '"by (0, 0, -3 mm)"'),
    "turn about": _pad("turned by 20 deg about (0, 0, 1)", "TIS312", "about", '"around"'),
    "scaled without by": _pad("scaled 120 %", "TIS312", " ", 'write "by"'),
    "mirrored at a coordinate": _pad("mirrored at x = 0", "TIS312", "at x = 0", "about plane through (0, 0, 0) mm facing (1, 0, 0)"),
    # copies, sets, plurals
    "is like": M("body pad {", "body twin is like pad { moved by (0, 0, 50) mm }\nbody pad {", "TIS312", " is like", '"like"'),
    "copy of": M("body pad {", "body twin copy of pad { moved by (0, 0, 50) mm }\nbody pad {", "TIS312", "of pad", "body twin like pad"),
    "tissue is another": M("tissue graft like own", "tissue graft is own", "TIS312", "tissue graft is own { elasticity is big }", "tissue graft like own"),
    "bodies": M("body pad {", "bodies pad {", "TIS303", "bodies pad", '"body"'),
    "sets": M("set floor =", "sets floor =", "TIS303", "sets", '"set"'),
    "tissue are": M(_PAD, "tissue are fat\n", "TIS303", "tissue are fat", '"tissue is fat"'),
    "set in an action": _fix("fix left edge; fix set floor", "TIS312", "set ", 'leave out "set"'),
    "sum of sets": _fix("fix left edge + floor", "TIS312", "fix left edge + floor", '"fix [left edge, floor]"'),
    "sets in parentheses": _fix("fix (left edge, floor)", "TIS312", "fix (left edge, floor)", '"fix [left edge, floor]"'),
    "hyphen in a name": M("set floor =", "set lower-floor =", "TIS312", "lower-floor", '"lower floor"', ("TIS301",)),
    # blocks
    "block in parentheses": M("tool shears { kind is scissors }", "tool shears ( kind is scissors )", "TIS312", "tool shears ( kind is scissors )", "tool shears { kind is scissors }"),
    "block in brackets": M("tool shears { kind is scissors }", "tool shears [ kind is scissors ]", "TIS312", "[ kind is scissors ]", "{ kind is scissors }"),
    "list as in YAML": M("  trajectory every 20 ms", "  - trajectory every 20 ms", "TIS312", "- ", "leave out the dash"),
    # laws
    "law without an argument": M("cord { spring constant = 40 N/m;", "cord { spring force of = 40 N/m * e;", "TIS312", "spring force of", '"spring force of e"'),
    "law in parentheses": M("cord { spring constant = 40 N/m;", "cord { spring force(e) = 40 N/m * e;", "TIS312", "spring force(e)", '"spring force of e"'),
    # repetitions
    "repeat with dots": _top("repeat i from 1..4 { set row i = nodes of pad where id == i }", "TIS312", "1..4", '"1 to 4"'),
    "repeat in dots": _top("repeat i in [1..4] { set row i = nodes of pad where id == i }", "TIS312", "in [1..4]", '"from 1 to 4"'),
    "repeat with equals": _top("repeat i = 1 to 4 { set row i = nodes of pad where id == i }", "TIS312", "repeat i = 1 to 4", '"repeat i from 1 to 4"'),
    "for with limits": _top("for i from 1 to 4 { set row i = nodes of pad where id == i }", "TIS303", "for i", '"repeat"'),
    "name without the index": _top("repeat i from 1 to 4 { set row = nodes of pad where id == i }", "TIS503", "row", '"row i"'),
    # expectations and studies
    "two limits": M("> 1 mN at 0.3 s", ">= 1 mN and <= 3 N at 0.3 s", "TIS312", ">= 1 mN and <= 3 N", '"between 1 mN and 3 N"'),
    "never": M(_FORCE, "expect never ruptured(pad) over run", "TIS701", "never ruptured", '"not ruptured"'),
    "list of a study with one unit": _top("study s { vary lift = [2, 4, 6] mm; measure pull = max(force(forceps A)) }", "TIS312", "[2, 4, 6] mm", "[1 mm, 2 mm]"),
    "study without vary": _top("study s { lift = [2 mm, 3 mm]; measure pull = max(force(forceps A)) }", "TIS303", "lift", '"vary lift"'),
    "measure without a name": _top("study s { vary lift = [2 mm, 3 mm]; measure max(force(forceps A)) }", "TIS312", "measure max(force(forceps A))", "measure NAME = max(force(forceps A))"),
    "measure by a name alone": _top("study s { vary lift = [2 mm, 3 mm]; measure = pull }", "TIS701", "pull", "pull = max(force(A))"),
    "measure with the name of a factor": _top("study s { vary lift = [2 mm, 3 mm]; measure = lift }", "TIS312", "lift", "NAME = max(force(A))"),
    "pressurise": _fix("fix left edge; fix floor; pressurise pad with 1 kPa", "TIS404", "pressurise", '"press"'),
}  # fmt: skip
