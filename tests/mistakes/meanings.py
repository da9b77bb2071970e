# ruff: noqa: E501  # texts as they are
"""Ranges, other words for entries, other forms of times and cuts, in the scene of layers."""

from tests.mistakes import Mistake as M

_OWN = "tissue own { described"
_CUT = "cut strip along plane through (20, 0, 0) mm facing (1, 0, 0) with shears"
_PROBE = "kind is probe; radius = 4 mm; centre = (20, 10, 30) mm"


def _own(written: str, code: str, marked: str, hint: str, *rest: str) -> M:
    return M(_OWN, f"tissue own {{ {written}; described", code, marked, hint, rest)


def _time(written: str, code: str, marked: str, hint: str) -> M:
    return M("at 0.4 s:", f"{written}:", code, marked, hint)


MISTAKES = {
    # ranges where one number is needed
    "range with a hyphen": _own(
        "Young's modulus = 5-6 kPa", "TIS312", "5-6 kPa", 'write "5 kPa" or "6 kPa"'
    ),
    "range with to": _own(
        "Young's modulus = 5 to 6 kPa", "TIS312", "5 to 6 kPa", 'write "5 kPa" or "6 kPa"'
    ),
    "range with a dash": _own(
        "Young's modulus = 5 – 6 kPa", "TIS114", "–", 'write "5 kPa" or "6 kPa"'
    ),
    "range with dots": _own(
        "Young's modulus = 5 kPa .. 6 kPa", "TIS312", "5 kPa .. 6 kPa", 'write "5 kPa" or "6 kPa"'
    ),
    "range with both units": _own(
        "Young's modulus = 5 kPa - 6 kPa", "TIS308", "5 kPa - 6 kPa", 'write "5 kPa" or "6 kPa"'
    ),
    "range with between": _own(
        "Young's modulus = between 5 kPa and 6 kPa",
        "TIS312", "between 5 kPa and 6 kPa", 'write "5 kPa" or "6 kPa"',
    ),
    "range of a tool": M("radius = 4 mm", "radius = 3-4 mm", "TIS312", "3-4 mm", 'write "3 mm" or "4 mm"'),
    "tolerance in ASCII": _own(
        "Young's modulus = 5 +/- 1 kPa", "TIS312", "5 +/- 1 kPa", 'write "5 kPa"'
    ),
    "about": _own("Young's modulus = about 5 kPa", "TIS312", "about 5 kPa", 'write "5 kPa"'),
    "tilde": _own("Young's modulus = ~5 kPa", "TIS114", "~", 'write "5 kPa"'),
    "limit": _own("Young's modulus = < 6 kPa", "TIS312", "< 6 kPa", 'write "6 kPa"'),
    # numbers beyond their limits
    "incompressible": _own("Poisson's ratio = 0.5", "TIS308", "0.5", 'write "0.4999"'),
    "negative thickness": M("thickness = 2 mm", "thickness = -2 mm", "TIS308", "-2 mm", 'write "2 mm"'),
    "negative share": _own(
        "relaxing share = -0.3; relaxation time = 1 s",
        "TIS308", "-0.3", 'write "0.3", or "0" for none',
    ),
    "no radius": M("radius = 4 mm", "radius = 0 mm", "TIS308", "0 mm", "write a number above 0 m"),
    "one row": M("rows = 5", "rows = 1", "TIS308", "1", 'write "2"'),
    "param beyond its limits": M(
        "param lift = 6 mm", "param lift = 20 mm", "TIS308", "20 mm", "write a number between its limits"
    ),
    "no time between outputs": M("every 20 ms", "every 0 ms", "TIS308", "0 ms", "every 10 ms"),
    # per cent
    "motion in per cent": M(
        "by (0 mm, 0 mm, lift)", "by 20 %", "TIS312", "by 20 %", "by (0, 0, 1 mm)"
    ),
    # entries by other words
    "letter of Young's modulus": _own("E = 5 kPa", "TIS202", "E", '"Young\'s modulus"'),
    "letter of a spring constant": M(
        "spring constant = 40 N/m", "k = 40 N/m", "TIS303", "k", '"spring constant"'
    ),
    "stiffness as a pressure": _own(
        "stiffness = 5 kPa", "TIS202", "stiffness", '"Young\'s modulus"'
    ),
    "misspelt stiffness": M(
        "spring constant = 40 N/m", "stifness = 40 N/m", "TIS303", "stifness", '"spring constant"'
    ),
    "letter of Poisson's ratio": _own("nu = 0.4", "TIS202", "nu", '"Poisson\'s ratio"'),
    "letter of a density": _own("rho = 1000 kg/m^3", "TIS202", "rho", '"density"'),
    "diameter of a probe": M(
        "radius = 4 mm", "diameter = 8 mm", "TIS303", "diameter", 'write "radius = 8 mm / 2", half the diameter'
    ),
    "thickness of a hook": M(
        _PROBE,
        "kind is hook; thickness = 4 mm; shaft from (0, 0, 60) mm to (0, 0, 40) mm; bend = (9, 0, 40) mm",
        "TIS303", "thickness", 'write "radius = 4 mm / 2", half the thickness',
    ),
    "diameter by a name": M(
        "radius = 4 mm", "diameter = lift", "TIS303", "diameter", 'write "radius = lift / 2", half the diameter'
    ),
    "position of a probe": M("centre = (20", "position = (20", "TIS303", "position", '"centre"'),
    "height of a sheet": M("thickness = 2 mm", "height = 2 mm", "TIS303", "height", 'write "thickness = 2 mm"'),
    # what is given twice
    "word twice": M("hardness is soft;", "hardness is soft; hardness is hard;", "TIS307", "hardness is hard", "remove one"),
    "entry of a tool twice": M("radius = 4 mm;", "radius = 4 mm; radius = 5 mm;", "TIS307", "radius = 5 mm", "remove one"),
    "clause twice": M(
        "grasp right edge with forceps A", "grasp right edge with forceps A with forceps A",
        "TIS307", "with forceps A", "remove one",
    ),
    # units as names
    "unit as a name": M("let side = 40 mm", "let side = 40 mm\nlet N = 40 mm", "TIS507", "N", "choose a word, also where it is used"),
    "unit without a number": M("let side = 40 mm", "let side = mm", "TIS301", "mm", 'write "1 mm"'),
    # times
    "after for at": _time("after 0.4 s", "TIS403", "after 0.4 s:", 'write "at 0.4 s"'),
    "every alone": _time("every 0.2 s", "TIS403", "every 0.2 s:", 'write "from 0 s to 500 ms every 0.2 s"'),
    "every first": _time("every 0.2 s from 0 s to 0.4 s", "TIS403", "every 0.2 s from 0 s to 0.4 s:", "to 0.4 s every 0.2 s"),
    "from alone": _time("from 0.4 s", "TIS403", "from 0.4 s:", 'write "at 0.4 s", or "from 0.4 s to 500 ms"'),
    "until alone": _time("until 0.4 s", "TIS403", "until 0.4 s:", 'write "from 0 s to 0.4 s"'),
    "in for at": _time("in 0.4 s", "TIS312", "in 0.4 s", 'write "at 0.4 s"'),
    "by for at": _time("by 0.4 s", "TIS312", "by 0.4 s", "an interval that ends then"),
    "over an interval": _time("over 0.1 s", "TIS312", "over 0.1 s", "when it begins and ends"),
    "at for": _time("at 0.4 s for 0.05 s", "TIS312", "at 0.4 s for 0.05 s", 'write "from 0.4 s to 0.4 s + 0.05 s"'),
    "later": _time("0.1 s later", "TIS312", "0.1 s later", "the time since the start of the run"),
    "expected at a name after the end": M(
        "at 0.3 s\nexpect", "at 3 * 0.3 s\nexpect", "TIS703", "3 * 0.3 s", "a longer duration in simulate"
    ),
    # cuts
    "cut of a depth": M(_CUT, "cut strip 5 mm deep", "TIS312", "5 mm deep", "along line from"),
    "cut along a coordinate": M(
        _CUT, "cut strip along x = 22 mm with shears",
        "TIS312", "along x = 22 mm", 'write "along plane through (22, 0, 0) mm facing (1, 0, 0)"',
    ),
    "cut along a plane of a coordinate": M(
        _CUT, "cut strip along plane y = 9 mm", "TIS312", "along plane y = 9 mm", "facing (0, 1, 0)"
    ),
}  # fmt: skip
