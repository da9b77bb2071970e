"""A wall of tissue resists stretching by E t, on every mesh."""

import numpy as np
import pytest
from scipy.sparse import eye
from scipy.sparse.linalg import spsolve

from tests.matter.elastic import drawn_out, scene, stiffness

YOUNG, DENSITY, THICKNESS = 5e3, 1060.0, 1e-3
TISSUE = f"Young's modulus = {YOUNG} Pa; density = {DENSITY} kg/m^3; retardation time = 2 ms"


def wall(mesh):
    return scene(TISSUE, f"mesh is {mesh}; thickness = {THICKNESS} m")


def sheet(columns, rows, diagonals="both"):
    return wall(
        "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; "
        "second edge = (0, 20, 0) mm; "
        f"columns = {columns}; rows = {rows}; diagonals is {diagonals} }}"
    )


@pytest.mark.parametrize(("columns", "rows"), [(5, 3), (9, 5), (13, 5)])
def test_a_sheet_is_as_stiff_as_its_thickness_says(columns, rows):
    network, plan = sheet(columns, rows)
    for axis, width in ((0, 0.02), (1, 0.04)):
        force, u = drawn_out(network, plan, axis)
        assert force == pytest.approx(YOUNG * THICKNESS * width, rel=1e-5)
        other = 1 - axis
        ratio = -np.polyfit(network.position[:, other], u[:, other], 1)[0]
        assert ratio == pytest.approx(1.0 / 3.0, rel=1e-5)
    assert network.mass.sum() == pytest.approx(DENSITY * 0.04 * 0.02 * THICKNESS)


def test_a_tube_is_as_stiff_as_its_wall():
    for rings, sides in ((9, 6), (17, 12)):
        network, plan = wall(
            "tube { axis from (0, 0, 0) mm to (80, 0, 0) mm; radius = 10 mm; "
            f"rings = {rings}; sides = {sides}; diagonals is both }}"
        )
        around = 2.0 * sides * 0.01 * np.sin(np.pi / sides)  # a polygon
        force, _ = drawn_out(network, plan, 0)
        assert force == pytest.approx(YOUNG * THICKNESS * around, rel=1e-5)
        assert network.mass.sum() == pytest.approx(DENSITY * THICKNESS * around * 0.08)


@pytest.mark.parametrize(("times", "error"), [(2, 0.04), (3, 0.01)])
def test_a_sphere_under_pressure_follows_laplace(times, error):
    # A shell of radius R widens by u under p = 2 E t u / ((1 - ν) R²). The polyhedron has
    # 1.9 % and 0.5 % less area.
    network, plan = wall(
        f"sphere {{ centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = {times} }}"
    )
    x = network.position
    a, b, c = x[network.skin].swapaxes(0, 1)
    load = np.zeros_like(x)
    for corner in network.skin.T:
        np.add.at(load, corner, np.cross(b - a, c - a) / 6.0)
    matrix = stiffness(network, plan)
    matrix = matrix + 1e-9 * matrix.diagonal().max() * eye(x.size)
    u = spsolve(matrix.tocsc(), load.ravel()).reshape(-1, 3)
    widened = np.einsum("ni,ni->n", u, x).mean() / 0.01
    assert widened == pytest.approx(0.01**2 / (3.0 * YOUNG * THICKNESS), rel=error)


def test_a_thread_is_a_bar_of_its_thickness():
    for pieces in (4, 16):
        network, _ = scene(
            TISSUE,
            "mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; "
            f"pieces = {pieces} }}",
        )
        part = network.threads["piece"].pieces
        section = np.pi * 1e-6
        assert 1.0 / (1.0 / network.stiffness[part]).sum() == pytest.approx(
            YOUNG * section / 0.04
        )
        assert network.mass.sum() == pytest.approx(DENSITY * section * 0.04)
