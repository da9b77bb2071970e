"""Faces of elements of every shape that are glued, whether or not they lie in one another."""

import numpy as np
import pytest

import tissuec
from tests.glue.blocks import CROSSED, at_ends, error_of_even_motion, glued, standing
from tests.imports.organs import box_of_hexahedra, box_of_tetrahedra, write_vtk
from tests.validate.scenes import quantity, validated

CUBES = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0; density = 1000 kg/m^3 }
body host { mesh is imported { file "host.vtk" in mm }; tissue is gel; made of @HOST }
body guest { mesh is imported { file "guest.vtk" in mm; moved by (10, 0, 0) mm }
             tissue is gel; made of @GUEST }
set face = nodes of guest where x < 10.1 mm
joint tie { glue from face to host }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
WEDGES = np.array([[0, 3, 7, 1, 2, 6], [0, 7, 4, 1, 6, 5]])


def cube(path, shape, cells, bulge=None):
    """Write a cube of 10 mm, and return how its elements are written in the language.

    Args:
        bulge: The end in x where it bulges by 1 mm [mm].
    """
    make = box_of_tetrahedra if shape == "tetrahedra" else box_of_hexahedra
    position, corners = make(cells)
    if shape == "wedges":
        corners = corners[:, WEDGES].reshape(-1, 6)
    x = position / cells
    if bulge is not None:
        height = np.sin(0.1 * np.pi * x[:, 1]) * np.cos(0.2 * x[:, 2])
        x[:, 0] += height * (1.0 - 0.1 * np.abs(x[:, 0] - bulge))
    write_vtk(path, x, corners)
    return "quadratic elements" if shape == "quadratic" else "elements"


@pytest.mark.parametrize(
    ("host", "guest", "cells"),
    [
        ("hexahedra", "hexahedra", 3), ("hexahedra", "hexahedra", 1),
        ("hexahedra", "wedges", 4), ("hexahedra", "tetrahedra", 1),
        ("wedges", "hexahedra", 4), ("tetrahedra", "hexahedra", 3),
        ("tetrahedra", "tetrahedra", 3), ("tetrahedra", "quadratic", 3),
        ("quadratic", "wedges", 3), ("quadratic", "tetrahedra", 2),
    ],
)  # fmt: skip
def test_uniform_stress_passes_through_faces(host, guest, cells, tmp_path, monkeypatch):
    """Two cells across a host, by a millionth, which the law bends by less of itself.

    Weights of places alone would be wrong by 5 % to 20 % of the strain times a cell.
    """
    monkeypatch.chdir(tmp_path)
    text = CUBES.replace("@HOST", cube(tmp_path / "host.vtk", host, 2))
    state = standing(text.replace("@GUEST", cube(tmp_path / "guest.vtk", guest, cells)))
    drawn, strain = state.network.position, 1e-6
    error = error_of_even_motion(state, np.diag([strain, 0.0, 0.0]), at_ends(drawn))
    assert error < 2e-6 * strain * 5e-3
    assert state.inertia.sum() == pytest.approx(state.mass.sum(), rel=1e-12)
    mean = state.inertia @ drawn, state.mass @ drawn
    assert mean[0] == pytest.approx(mean[1], rel=1e-12)


@pytest.mark.parametrize("guest", ["hexahedra", "tetrahedra", "quadratic"])
@pytest.mark.parametrize("host", ["hexahedra", "tetrahedra", "quadratic", "wedges"])
def test_curved_faces_stay_where_they_are_drawn(host, guest, tmp_path, monkeypatch):
    """Also where the sides are up to 0.4 mm apart between the nodes; turning is exact, then."""
    monkeypatch.chdir(tmp_path)
    text = CUBES.replace("@HOST", cube(tmp_path / "host.vtk", host, 2, bulge=10))
    text = text.replace("@GUEST", cube(tmp_path / "guest.vtk", guest, 3, bulge=0))
    text = text.replace("x < 10.1 mm", "x < 11.1 mm")
    state = standing(text.replace("to host", "to host; reach = 1.2 mm"))
    found = state.position.copy()
    state.embedding.follow(found)
    assert np.abs(found - state.position).max() < 1e-15
    assert len(state.embedding.nodes) == (16 if guest == "hexahedra" else 49)
    assert (state.inertia[state.embedding.hosts] > 0.0).all()


PRESSED = (
    "at 0 s: fix left; from 0 s to 1 s: move right by (-0.4, 0, 0) mm using constant speed"
)
PRESSURE = "hydrostatic pressure of [coarse, fine]"


def test_the_pressure_beside_faces_that_cross_is_even():
    """But for the law: held ends keep the width that the middle of ν = 0 loses by 1e-4."""
    ends = [f"{each}({PRESSURE}) every 1 s" for each in ("smallest", "largest")]
    text = glued(poisson=0, script=PRESSED, output="; ".join(ends)).replace(*CROSSED)
    low, high = (log.value[-1] for log in tissuec.run(text, companion="off").logs.values())
    assert low == pytest.approx(high, rel=5e-3)


@pytest.mark.parametrize("method", ["dop853", "trbdf2"])
def test_scipy_finds_the_same_motion_of_faces_that_cross(method):
    text = glued(
        gravity="(0, 0, -9.81)", script="at 0 s: fix left", duration="5 ms",
        method=f"tolerance = 1e-5; integrator is {method}",
        output="trajectory every 1 ms; force(left) every 1 ms; force(face) every 1 ms; "
               "energy every 1 ms",
    )  # fmt: skip
    found = validated(text.replace(*CROSSED))
    for name in ("position", "energy balance", "force of left", "force of face"):
        assert quantity(found, name).error < 1e-5


def test_faces_at_a_wall_press_on_it_evenly():
    """A third of the area of its triangles is at each node of the wall."""
    wall = """body coarse { mesh is sheet {
    corner = (20, 0, 0) mm; first edge = (0, 10, 0) mm; second edge = (0, 0, 10) mm
    columns = 4; rows = 3 }; tissue is gel; thickness = 1 mm; made of elements }
"""
    text = glued(script="at 0 s: fix right").replace(*CROSSED)
    first, last = text.index("body coarse"), text.index("body fine")
    state = standing(text[:first] + wall + text[last:].replace("x < 0.1 mm", "y < 0.1 mm"))
    drawn, nodes = state.network.position, state.embedding.nodes
    share = np.zeros(len(drawn))
    inner = [(drawn[nodes, k] > 1e-6) & (drawn[nodes, k] < 10e-3 - 1e-6) for k in (1, 2)]
    share[nodes] = np.prod([np.where(each, 1.0, 0.5) for each in inner], axis=0) / 9.0
    (wall,) = state.of_kind("membranes")
    due = np.zeros(len(drawn))
    a, b, c = np.moveaxis(drawn[wall.nodes], 1, 0)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    np.add.at(due, wall.nodes, areas[:, None] / 3.0 / 1e-4)
    assert state.embedding.shared(share) == pytest.approx(due, abs=1e-12)
