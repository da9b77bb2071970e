"""How much too stiff cells make solids in bending and torsion, and who is warned of it."""

import math
import re
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import tissuec
from tests.matter.elastic import moved, stiffness
from tests.matter.shapes import as_vtk, tetrahedra

SIDE, LENGTH = 16.0, 64.0  # of bars [mm]
YOUNG, SHEAR = 10e3, 4e3
SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms{more} }}
body bar {{ made of springs; mesh is {mesh}; tissue is gel{inside} }}
{sets}
environment {{ gravity = (0, 0, 0) m/s^2 }}
{script}
simulate {{ duration = 1 ms }}
"""
#: Of a square of side 1 (S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, § 94).
SQUARE = (1 - 192 / math.pi**5 * sum(math.tanh(n * math.pi / 2) / n**5 for n in (1, 3, 5))) / 3


def lattice(kind, cell, sides=(LENGTH, SIDE, SIDE)):
    to = ", ".join(map(str, sides))
    return (
        f"lattice {{ kind is {kind}; reach is second neighbours; cell = {cell} mm; "
        f"box from (0, 0, 0) mm to ({to}) mm }}"
    )


def text(mesh, more="", inside="", sets="", script=""):
    return SCENE.format(mesh=mesh, more=more, inside=inside, sets=sets, script=script)


def ratios(scene):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tissuec.TissueWarning)
        (found,) = tissuec.properties(scene, frequencies=0)
    return found.coarseness


def imported(folder, x, cells):
    (folder / "bar.vtk").write_text(as_vtk(x, cells))
    scene = folder / "bar.tis"
    scene.write_text(text('imported { file "bar.vtk" in mm }'))
    return scene


def turned_ends(network):
    """Return bending and torsion of a bar along x over beam theory, by statics of their own."""
    x, matrix = network.position, stiffness(network)
    side, length = 1e-3 * SIDE, 1e-3 * LENGTH
    low, high = (np.flatnonzero(np.isclose(x[:, 0], end)) for end in (0.0, length))
    y, z = (x[:, 1:] - side / 2).T
    held = {3 * node: 0.0 for node in low} | {3 * node: z[node] for node in high}
    _, force = moved(matrix, held)
    bending = force[high, 0] @ z[high] / (YOUNG * side**4 / 12 / length)
    held = {3 * node + k: 0.0 for node in low for k in (1, 2)}
    held |= {3 * node + 1: -z[node] for node in high} | {3 * n + 2: y[n] for n in high}
    _, force = moved(matrix, held)
    moment = y[high] @ force[high, 2] - z[high] @ force[high, 1]
    return bending, moment / (SHEAR * SQUARE * side**4 / length)


# Free ends of a bar give way to the forces on their nodes, the more the fewer there are; ends
# that are turned as a whole do not.
@pytest.mark.parametrize(
    ("kind", "cells", "bending", "torsion"),
    [
        ("sodium chloride", 2, 0.001, 0.05),
        ("sodium chloride", 4, 0.001, 0.01),
        ("sodium chloride", 6, 0.001, 0.005),
        ("caesium chloride", 3, 0.01, 0.02),
    ],
)
def test_ratios_are_those_of_bars_whose_ends_are_turned(kind, cells, bending, torsion):
    scene = text(lattice(kind, SIDE / cells))
    found = ratios(scene)
    expected = turned_ends(tissuec.compile(scene).network)
    assert found.bending == pytest.approx(expected[0], rel=bending)
    assert found.torsion == pytest.approx(expected[1], rel=torsion)


def test_ends_matter_less_the_longer_the_bar():
    found = [
        ratios(text(lattice("sodium chloride", 8.0, (length, SIDE, SIDE)))).torsion
        for length in (64.0, 128.0, 256.0)
    ]
    limit = 1.778  # of turned ends
    first, second, third = (limit - one for one in found)
    assert third < 0.025
    assert (second / first, third / second) == pytest.approx((0.5, 0.5), abs=0.05)


@pytest.mark.parametrize("cell", [8.0, 4.0])
def test_ratios_of_tetrahedra_are_those_of_bars_whose_ends_are_turned(cell, tmp_path):
    scene = imported(tmp_path, *tetrahedra((LENGTH, SIDE, SIDE), cell, 0.15))
    found = ratios(scene)
    expected = turned_ends(tissuec.compile(scene).network)
    assert (found.bending, found.torsion) == pytest.approx(expected, rel=0.05)


def test_ratios_tend_to_1_with_the_square_of_the_cells():
    coarse, fine = (ratios(text(lattice("sodium chloride", SIDE / n))) for n in (3, 6))
    for one, other in ((coarse.bending, fine.bending), (coarse.torsion, fine.torsion)):
        assert math.log2((one - 1.0) / (other - 1.0)) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("ratio", [0.35, 0.49])
def test_cells_that_keep_their_volume_do_not_lock(ratio):
    found = ratios(text(lattice("sodium chloride", 4.0), f"; Poisson's ratio = {ratio}"))
    assert 1.02 < found.bending < 1.06  # springs alone: 1.058
    assert found.torsion == pytest.approx(1.216, abs=0.002)  # it keeps volumes


def test_the_page_shows_bending_and_torsion_of_turned_ends(repository):
    """Also for two cells, of which a sentence below the table tells."""
    page = (repository / "docs" / "choosing.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| ([46]) \| 1\.000 \| (\S+) \| (\S+) \|$", page, re.MULTILINE)
    sentence = r"two cells across, bending is (\S+) times.*?about (\S+) times"
    two = re.search(sentence, page, re.DOTALL)
    for cells, *numbers in (*shown, ("2", *two.groups())):
        network = tissuec.compile(text(lattice("sodium chloride", SIDE / int(cells)))).network
        places = len(numbers[0].partition(".")[2])
        expected = turned_ends(network)
        assert expected == pytest.approx(tuple(map(float, numbers)), abs=10.0**-places)
    assert len(shown) == 2


def test_axes_are_those_of_the_body(tmp_path):
    x, cells = tetrahedra((LENGTH, 1.5 * SIDE, SIDE), 8.0, 0.15)
    straight = ratios(imported(tmp_path, x, cells))
    turned = ratios(
        imported(
            tmp_path, x @ Rotation.from_euler("xyz", (30, 40, 50), True).as_matrix(), cells
        )
    )
    assert turned.bending == pytest.approx(straight.bending, rel=0.01)
    assert turned.torsion == pytest.approx(straight.torsion, rel=0.01)


def test_fibres_count_as_moduli_of_the_body(monkeypatch):
    monkeypatch.setitem(globals(), "YOUNG", 100e3)
    fibres = "; fibre modulus = 100 kPa", "; fibres = (1, 0, 0)"
    scene = text(lattice("sodium chloride", 4.0), *fibres)
    found, expected = ratios(scene), turned_ends(tissuec.compile(scene).network)
    assert found.bending == pytest.approx(expected[0], rel=0.001)
    assert found.torsion == pytest.approx(expected[1], rel=0.01)


def test_bodies_of_several_tissues_and_walls_are_not_compared():
    regions = "; region half where z > 8 mm { tissue is stiff }; interface is mean"
    stiff = "}\ntissue stiff like gel { Young's modulus = 20 kPa"
    (found,) = tissuec.properties(text(lattice("sodium chloride", 4.0), stiff, regions))
    assert found.coarseness is None
    assert "bending and torsion are not compared in several tissues" in found.notes


FIX = "script {{ at 0 s: fix {0} }}"
LEFT, BASE = (
    "set left = nodes of bar where x < 0.1 mm",
    "set base = nodes of bar where z < 0.1 mm",
)


@pytest.mark.parametrize(
    ("mesh", "sets", "script", "warns"),
    [
        (lattice("sodium chloride", 8.0), LEFT, FIX.format("left"), True),
        (lattice("sodium chloride", 8.0), "", "", True),
        (lattice("caesium chloride", 8.0), LEFT, FIX.format("left"), True),
        (lattice("sodium chloride", 4.0), LEFT, FIX.format("left"), False),  # fine enough
        (lattice("sodium chloride", 8.0), BASE, FIX.format("base"), False),  # cannot bend
        (lattice("sodium chloride", 8.0, (32, 16, 16)), LEFT, FIX.format("left"), False),
    ],
)
def test_check_warns_of_long_bodies_of_few_cells(mesh, sets, script, warns):
    scene = text(mesh, sets=sets, script=script)
    found = [one for one in tissuec.check(scene) if one.code == "W210"]
    assert bool(found) is warns


def test_the_warning_gives_both_ratios_and_the_cells_to_use():
    scene = text(lattice("sodium chloride", 8.0))
    (found,) = (one for one in tissuec.check(scene) if one.code == "W210")
    assert "about 2 cells across" in found.message
    assert "1.22 times as stiff in bending and 1.7 times in torsion" in found.message
    assert "4 mm or less" in str(found.hint)
    better = text(lattice("sodium chloride", 4.0))
    assert not any(one.code == "W210" for one in tissuec.check(better))


def bar_of_elements(cell):
    return f"""language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body bar {{
  made of elements; tissue is gel
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to (60, 10, 10) mm }}
}}
set left = nodes of bar where x < 0.1 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ at 0 s: fix left }}
simulate {{ duration = 1 ms }}
"""


def test_one_element_across_is_enough_to_bend():
    assert not any(one.code == "W210" for one in tissuec.check(bar_of_elements(10)))
