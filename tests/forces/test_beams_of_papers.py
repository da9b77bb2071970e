"""Beams with known answers: the elastica, and beams of R. H. MacNeal and R. L. Harder.

(A proposed standard set of problems to test finite element accuracy, Finite Elements in
Analysis and Design 1:3, 1985.) Lengths are in mm, moduli in kPa and forces in mN.
"""

import numpy as np
import pytest
from scipy.integrate import solve_bvp

import tissuec
from tests.imports.organs import grid_of_hexahedra, write_vtk

TEXT = """language 1
tissue steel {{
  Young's modulus = {young} kPa; Poisson's ratio = {poisson}; density = 1000 kg/m^3
}}
body beam {{ mesh is {mesh}; tissue is steel }}
set near = nodes of beam where x < 1e-6 mm
set far = nodes of beam where x > {last} mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix near; from 0 s to 1 s: push far with {load} mN using ramp }}
simulate {{ duration = 1 s; integrator is equilibrium; step = {step} s }}
output {{ position of far every 1 s }}
"""


def moved(scene, load, **entries):
    """Return how far the end of a beam moves on average [mm], shape (3,)."""
    given = {"young": 1000.0, "poisson": 0.0, "step": 1.0} | entries
    scene.write_text(TEXT.format(load=load, **given), encoding="utf-8")
    with tissuec.run(scene, companion="off") as run:
        assert run.finished, run.message
        first, *_, last = run.logs["position of far"].value
    return 1e3 * (last - first)


def elastica(load):
    """Return the ways of the end of a clamped elastica, over its length, shape (2,).

    θ'' = -p cos θ, θ(0) = 0, θ'(1) = 0, with the dead load p = P L²/EI across it.
    """

    def slopes(_, state):
        angle, bend, *_ = state
        return np.stack([bend, -load * np.cos(angle), np.cos(angle), np.sin(angle)])

    def ends(start, end):
        return np.array([start[0], end[1], start[2], start[3]])

    s = np.linspace(0.0, 1.0, 201)
    guess = np.stack([1.2 * s, 1.2 * (1.0 - s), s, 0.7 * s])
    found = solve_bvp(slopes, ends, s, guess, tol=1e-10, max_nodes=100_000)
    assert found.success
    return found.y[2, -1] - 1.0, found.y[3, -1]


def test_a_bar_of_one_cell_across_bends_as_the_elastica(tmp_path):
    """p = 10; the thickness of 1/100 lets it shear and stretch by less than 1e-4."""
    due = 100.0 * np.array(elastica(10.0))
    load = 10.0 * 1000.0 / 12.0 / 100.0**2
    found = moved(
        tmp_path / "elastica.tis", f"(0, 0, {load})",
        mesh="lattice { cell = (1, 1, 1) mm; box from (0, 0, 0) mm to (100, 1, 1) mm }",
        last=99.999, step=0.1,
    )  # fmt: skip
    assert found[[0, 2]] == pytest.approx(due, rel=5e-3)


def straight(cells):
    """Return a mesh of the slender beam: 6 x 0.2 x 0.1."""
    cell = f"cell = ({6 / cells:.15g}, 0.2, 0.1) mm"
    return f"lattice {{ {cell}; box from (0, 0, 0) mm to (6, 0.2, 0.1) mm }}"


@pytest.mark.parametrize(("along", "due"), [((0, 0, 1), 0.4321), ((0, 1, 0), 0.1081)])
@pytest.mark.parametrize(("cells", "bound"), [(6, 0.02), (12, 0.01)])
def test_a_slender_beam_of_boxes_bends(along, due, cells, bound, tmp_path):
    """A load of 1 lb with 1e7 psi; with 1 MPa, 1e-6 mN bends it a hundredth as far in mm."""
    push = 1e-6 * np.array(along)
    found = moved(
        tmp_path / "beam.tis", f"({push[0]}, {push[1]}, {push[2]})",
        mesh=straight(cells), last=5.999, poisson=0.3,
    )  # fmt: skip
    assert found @ along == pytest.approx(due * push.max() * 1e4, rel=bound)


def twisted():
    """Return nodes and cells of a strip of 12 x 1.1 x 0.32 that turns by 90° along it."""
    x, y, z = np.linspace(0.0, 12.0, 13), np.linspace(-0.55, 0.55, 3), np.array([-0.16, 0.16])
    angle = 0.5 * np.pi * x / 12.0
    place = np.zeros((13, 3, 2, 3))
    place[..., 0] = x[:, None, None]
    place[..., 1] = np.cos(angle)[:, None, None] * y[:, None]
    place[..., 1] -= np.sin(angle)[:, None, None] * z
    place[..., 2] = np.sin(angle)[:, None, None] * y[:, None]
    place[..., 2] += np.cos(angle)[:, None, None] * z
    return grid_of_hexahedra(place)


@pytest.mark.parametrize(("along", "due"), [((0, 0, 1), 0.005424), ((0, 1, 0), 0.001754)])
def test_the_twisted_beam_bends(along, due, tmp_path):
    """A load of 1 lb with 29e6 psi: along the width of its end, and across it."""
    write_vtk(tmp_path / "twisted.vtk", *twisted())
    push = 1e-5 * np.array(along)
    found = moved(
        tmp_path / "beam.tis", f"({push[0]}, {push[1]}, {push[2]})",
        mesh='imported { file "twisted.vtk" in mm }', last=11.999, poisson=0.22,
    )  # fmt: skip
    assert found @ along == pytest.approx(due * push.max() * 29e3, rel=0.02)
