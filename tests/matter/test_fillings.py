"""A filled surface is a solid of its tissue, wherever its faces lie among the cells."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.matter.elastic import drawn_out
from tests.matter.shapes import as_obj, surface
from tests.matter.test_tetrahedra import YOUNG, compiled
from tissuec.core.structs import replace

SIDES = np.array([32.0, 16.0, 16.0])
LATTICES = [
    "sodium chloride; reach is second neighbours",
    "caesium chloride; reach is second neighbours",
]
FILLINGS = [*LATTICES, "tetrahedra"]
AWAY = np.array([3.3, 1.7, 9.0])
TURN = Rotation.from_rotvec([0.1, 0.2, 0.05]).as_matrix()


def filled(folder, filling, cell, turn=None, digits=None):
    """Return a filled bar, placed and turned back to the axes again."""
    x, triangles = surface(SIDES, cell)
    turn = np.eye(3) if turn is None else turn
    x = x @ turn.T + AWAY
    x = x if digits is None else np.round(x, digits)
    more = f"; filling is {filling}; cell = {cell:.15g} mm"
    network, plan = compiled(folder, as_obj(x, triangles), "bar.obj", more=more)
    return replace(network, position=(network.position - AWAY / 1e3) @ turn), plan


def moduli(network, plan):
    """Return Young's modulus between plates along x, y and z, per the one asked for."""
    return np.array(
        [
            drawn_out(network, plan, axis)[0] / (np.prod(np.delete(SIDES, axis)) * 1e-6) / YOUNG
            for axis in range(3)
        ]
    )


# Springs are calibrated halfway between an even stress and an even strain; plates keep faces
# plane, but let them slide. 5 % are allowed of two cells of width, 2 % of the two finest.
@pytest.mark.parametrize("finest", [4.0, pytest.param(2.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("filling", FILLINGS)
def test_moduli_of_a_filled_bar_do_not_depend_on_the_cell(filling, finest, tmp_path):
    found = []
    for cell in (8.0, 4.0) if finest == 4.0 else (8.0, 4.0, 8.0 / 3.0, finest):
        network, plan = filled(tmp_path, filling, cell)
        assert network.mass.sum() == pytest.approx(1e-3 * 8.192, rel=1e-9)
        found.append(moduli(network, plan))
    assert np.abs(np.array(found) - 1.0).max() < 0.05
    if finest == 2.0:
        assert np.abs(np.array(found[-2:]) - 1.0).max() < 0.02


# 3.999 mm: sites stand half a cell from the faces, so that nothing is left for the nodes there
# if those inside stand for whole cells. 3.7 and 5 mm: anywhere.
@pytest.mark.parametrize("cell", [3.7, 3.999, 5.0])
@pytest.mark.parametrize("filling", FILLINGS)
def test_faces_may_lie_anywhere_among_the_cells(filling, cell, tmp_path):
    network, plan = filled(tmp_path, filling, cell)
    assert moduli(network, plan) == pytest.approx([1.0] * 3, abs=0.05)
    assert network.mass.min() > 0.0
    # A quarter of each tetrahedron at its corners has its centre, but for the least shares.
    centre = network.mass @ network.position / network.mass.sum()
    assert centre == pytest.approx(SIDES / 2e3, abs=1e-3 * 32e-3)


@pytest.mark.parametrize("filling", FILLINGS)
def test_a_filled_bar_may_be_turned(filling, tmp_path):
    network, plan = filled(tmp_path, filling, 4.0, TURN)
    found = moduli(network, plan)
    # Four cells of width, cut anywhere: 5 % between plates, as above.
    assert found == pytest.approx([1.0] * 3, abs=0.05)


@pytest.mark.parametrize("filling", LATTICES)
def test_rounding_in_a_file_does_not_change_the_filling(filling, tmp_path):
    whole, _ = filled(tmp_path, filling, 4.0)
    rounded, _ = filled(tmp_path, filling, 4.0, digits=4)
    assert len(rounded.position) == len(whole.position)
    assert np.abs(rounded.position - whole.position).max() < 1e-7
    # Delaunay's tetrahedra of a square may have either diagonal.
    assert len(rounded.springs.ends) == pytest.approx(len(whole.springs.ends), rel=0.05)
