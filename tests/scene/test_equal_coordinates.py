"""Comparisons of drawn coordinates: equal to within rounding, and each node on one side."""

import re

import numpy as np
import pytest

import tissuec
from tests.every import every
from tests.validate.scenes import compiled_scene

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; density = 1000 kg/m^3 }}
body block {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to ({cell}, {cell}, {long}) mm }}
  tissue is gel
  {moved}
}}
{sets}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 us }}
"""


def chosen(conditions, cell=1.0, cells=10, moved=""):
    """Return the sets of nodes of a column of cells, and their number."""
    sets = "\n".join(
        f"set s{n} = nodes of block where {one}" for n, one in enumerate(conditions)
    )
    text = SCENE.format(cell=cell, long=f"{cells * cell:.6g}", moved=moved, sets=sets)
    compiled = compiled_scene(text)
    return [set(group.indices.tolist()) for group in compiled.groups.named()], compiled.network


@every("cell", [0.1, 0.3, 0.7, 1.1, 3.3, 17.9])
def test_every_plane_of_a_lattice_is_found_as_it_is_written(cell):
    written = [f"{n * cell:.6g}" for n in range(1, 51)]
    found, _ = chosen([f"z == {one} mm" for one in written], cell, 50)
    assert [len(one) for one in found] == [4] * 50


@every(
    "limit",
    [f"z {{}} {n * 0.1:.6g} mm" for n in range(1, 10)]
    + [
        "0.3 mm {} z", "z - 0.3 mm {} 0 mm", "z / 0.3 mm {} 1", "z^2 {} 0.09 mm^2",
        "(x^2 + y^2 + z^2)^(1/2) {} 0.7 mm", "abs(z - 0.4 mm) {} 0.3 mm", "z + x {} 0.7 mm",
        "z {} 0.35 mm", "z {} y",
    ],
)  # fmt: skip
def test_one_of_less_equal_and_greater_is_true_of_every_node(limit):
    signs = ("<", "==", ">", "<=", ">=", "!=")
    conditions = [f"{limit.format(sign)} or id == 1" for sign in signs]
    found, network = chosen(conditions, cell=0.1)
    first = {0}  # keeps sets from being empty
    less, equal, more, at_most, at_least, other = (one - first for one in found)
    everything = set(range(network.node_count)) - first
    assert len(less) + len(equal) + len(more) == len(everything)
    assert less | equal | more == everything
    assert at_most == less | equal and at_least == more | equal and other == less | more
    compared = network.node_count - 1
    if limit == "z {} 0.35 mm":
        assert not equal
    elif "x" not in limit and "{} y" not in limit:
        assert len(equal) in (4, 8) and compared > len(equal)


def test_between_has_both_of_its_limits():
    ball = "within 0.7 mm of (0, 0, 0) mm and x == 0 mm and y == 0 mm"
    (found, within), _ = chosen(["z between 0.3 mm and 0.7 mm", ball], cell=0.1)
    assert len(found) == 5 * 4 and len(within) == 8


def test_bodies_far_away_and_turned_have_their_planes():
    far, _ = chosen(["z == 100.3 m", "z < 100.3 m"], 100.0, 10, "moved by (0, 0, 100) m")
    assert [len(one) for one in far] == [4, 12]
    turned, _ = chosen(
        [f"x * sin(30 deg) + z * cos(30 deg) == {0.1 * n:.6g} mm" for n in range(11)],
        0.1, 10, "turned by 30 deg around (0, 1, 0) through (0, 0, 0) mm",
    )  # fmt: skip
    assert [len(one) for one in turned] == [4] * 11


def test_places_that_differ_by_more_than_rounding_differ():
    # 2 nm of 1 mm; the tolerance is 1 pm.
    found, _ = chosen(["z == 0.500000002 mm or id == 1", "z > 0.500002 um"], cell=0.1)
    assert found[0] == {0} and len(found[1]) == 4 * 10


def springs_of(kind, sets="", inside=""):
    """Return a column of cells that consists of springs."""
    text = SCENE.replace("{{ cell", f"{{{{ kind is {kind}; cell")
    text = text.replace(
        "Young's modulus = 10 kPa; density = 1000 kg/m^3",
        "spring constant = 40 N/m; viscosity = 0.02 N*s/m; mass = 1 mg",
    )
    return compiled_scene(text.format(cell=0.1, long=1, moved=inside, sets=sets))


@pytest.mark.parametrize("kind", ["sodium chloride", "diamond"])
def test_springs_are_chosen_by_their_middles_and_lengths(kind):
    sets = """set low = springs of block where z < 0.3 mm
set rest = springs of block where z >= 0.3 mm"""
    compiled = springs_of(kind, sets)
    low, rest = (group.indices for group in compiled.groups.named())
    springs = compiled.network.springs.ends
    middle = compiled.network.position[springs].mean(axis=1)[:, 2]
    assert len(np.union1d(low, rest)) == len(low) + len(rest) == len(middle)
    # The tolerance is 1 pm, a billionth of the column.
    assert middle[low].max() < 0.3e-3 - 1e-12 and middle[rest].min() > 0.3e-3 - 1.1e-12


def test_regions_on_both_sides_of_a_plane_have_each_node_once():
    regions = "region low where z <= 0.3 mm { tissue is gel }\n"
    regions += "region high where z > 0.3 mm { tissue is gel }\ninterface is mean"
    drawing = springs_of("sodium chloride", inside=regions).groups.bodies["block"].drawing
    assert np.bincount(drawing.part).tolist() == [0, 16, 28]


SET = re.compile(r"^set (\w+) =", re.MULTILINE)


def said_of(text):
    """Return the warnings of a scene about parts that select nothing: marked text, and hint."""
    found = tissuec.check(
        f"{text}\nscript {{ at 0 s: fix [{', '.join(['block', *SET.findall(text)])}] }}\n"
    )
    return [(one.span.one_line, one.hint) for one in found if one.code == "W311"]


@every(
    ("condition", "idle"),
    {
        "z == 0.3 mm or z == 0.35 mm": "z == 0.35 mm",
        "x == 0 mm and (z == 0.3 mm or z > 2 mm)": "z > 2 mm",
        "not (z == 0.1 mm or z < -1 mm)": "z < -1 mm",
        "z == 0.3 mm or x == 0 mm and (z == 0.35 mm or y == 0 mm)": "z == 0.35 mm",
        "z == 0.3 mm or z between 0.31 mm and 0.69 mm": "",
        "z == 0.3 mm or z > 0.9 mm": "",
    }.items(),
)
def test_alternatives_that_select_nothing_are_reported(condition, idle):
    text = SCENE.format(
        cell=0.1, long=1, moved="", sets=f"set chosen = nodes of block where {condition}"
    )
    assert [marked for marked, _ in said_of(text)] == [idle] * bool(idle)


def test_the_nearest_coordinates_are_named():
    text = SCENE.format(
        cell=0.1, long=1, moved="",
        sets="set marks = nodes of block where z == 0.3 mm or z == 0.35 mm or z == 2 mm",
    )  # fmt: skip
    between, beyond = (hint for _, hint in said_of(text))
    assert between == "the nearest have z == 300 um and z == 400 um"
    assert beyond.endswith("z runs from 0 m to 1 mm")


def test_an_alternative_for_one_of_several_bodies_selects_something():
    text = SCENE.format(
        cell=1, long=10, moved="", sets="set ends = nodes of [block, other] where z == 10 mm"
        " or z == 30 mm\nbody other like block { moved by (0, 0, 20) mm }",
    )  # fmt: skip
    assert not said_of(text)


def test_alternatives_of_regions_are_reported_too():
    text = SCENE.format(
        cell=1, long=10, sets="tissue hard like gel { density = 1 g/cm^3 }",
        moved="region ends where z < 1 mm or z > 10 mm { tissue is hard }",
    )  # fmt: skip
    assert [marked for marked, _ in said_of(text)] == ["z > 10 mm"]
