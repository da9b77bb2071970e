"""Lattices with finer cells in a part: how planes are spaced, and what follows from them."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tissuec.compiler.checks import check_all
from tissuec.core.errors import CompileError
from tissuec.geometry.elements import SHAPES
from tissuec.mechanics import observables
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.meshes.generators.joining import graded_line
from tissuec.meshes.generators.lattice import Lattice

MM = 1e-3


def lattice(fine_cell=0.8 * MM, start=(3, 8, 17), stop=(6, 8, 25), **more):
    fine = tuple(np.array(corner) * MM for corner in (start, stop))
    box = np.zeros(3), np.array([20.0, 17.0, 20.0]) * MM
    return Lattice("sodium chloride", 5 * MM, box, fine_cell=fine_cell, fine_box=fine, **more)


def test_steps_are_fine_where_they_should_be_and_grow_evenly():
    random = np.random.default_rng(0)
    looked = 0
    for _ in range(500):
        length = random.uniform(0.5, 100.0)
        coarse = length / random.uniform(1.0, 20.0)
        fine = coarse / random.uniform(1.0, 30.0)
        start, stop = np.sort(random.uniform(-0.2, 1.2, 2)) * length
        if stop < 0.0 or start > length:
            continue
        places = graded_line((0.0, length), (start, stop), coarse, fine)
        steps = np.diff(places)
        assert places[0] == 0.0 and places[-1] == length and (steps > 0.0).all()
        inside = (places[1:] > start + 1e-9 * length) & (places[:-1] < stop - 1e-9 * length)
        assert (steps[inside] <= fine * (1.0 + 1e-9)).all()
        assert steps.max() <= coarse * (1.0 + 1e-9)
        ratio = steps[1:] / steps[:-1]
        assert np.maximum(ratio, 1.0 / ratio).max(initial=1.0) < 1.6
        looked += 1
    assert looked > 375


def test_a_part_at_an_end_or_a_single_place_has_fine_steps():
    for part in ((20.0, 25.0), (20.0, 20.0), (-3.0, 0.0), (7.0, 7.0)):
        places = graded_line((0.0, 20.0), part, 5.0, 1.0)
        beside = np.searchsorted(places, np.clip(part[0], 0.5, 19.5))
        assert np.diff(places)[beside - 1] <= 1.0 + 1e-12
    with pytest.raises(ValueError, match="not on the line"):
        graded_line((0.0, 20.0), (21.0, 22.0), 5.0, 1.0)


def test_elements_fill_the_box_and_are_fine_in_the_part():
    mesh = lattice().build_elements()
    (hexahedra,) = mesh.elements
    corners = mesh.position[hexahedra.nodes]
    low, high = corners.min(axis=1), corners.max(axis=1)
    volume = np.prod(high - low, axis=1).sum()
    assert volume == pytest.approx(20.0 * 17.0 * 20.0 * MM**3, rel=1e-12)
    assert (len(mesh.position), len(mesh.ends)) <= lattice().element_size()
    middle = 0.5 * (low + high) / MM
    is_there = ((middle > (3, 7.9, 17)) & (middle < (6, 8.1, 20))).all(axis=1)
    assert is_there.any() and (high - low)[is_there].max() <= 0.8 * MM * (1.0 + 1e-12)
    # No node hangs: every node inside belongs to eight cells.
    inner = ((mesh.position > 1e-9) & (mesh.position < np.array([20, 17, 20]) * MM - 1e-9)).all(
        1
    )
    assert (np.bincount(hexahedra.nodes.ravel())[inner] == 8).all()


SCENE = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3
}}
body block {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to (20, 20, 20) mm; {fine} }}
  tissue is gel
}}
environment {{
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}}
simulate {{ duration = 1 ms }}
"""
NET = SCENE.replace(
    "Young's modulus = 10 kPa; Poisson's ratio = {ratio}",
    "spring constant = 10 N/m; retardation time = 1 ms",
).replace("{fine}", "{fine}; kind is sodium chloride; reach is second neighbours")
FINE = "fine cell = 1 mm; fine box from (3, 3, 19) mm to (5, 5, 20) mm"
LAYER = "fine cell = (4, 4, 0.05) mm; fine box from (0, 0, 19.9) mm to (20, 20, 20) mm"


def state_of(cell=4, fine=FINE, ratio=0.45):
    text = SCENE.format(cell=cell, fine=fine, ratio=ratio)
    compiled = compiled_scene(text)
    return State.start(compiled.network, gravity=np.zeros(3), drag=0.0)


def test_the_mass_is_that_of_the_box():
    assert state_of().mass.sum() == pytest.approx(8e-3, rel=1e-12)


@pytest.mark.parametrize("fine", [FINE, LAYER])
def test_a_uniform_strain_is_in_equilibrium(fine):
    """The patch test, with all nodes of the surface displaced."""
    state = state_of(fine=fine, ratio=0.49)
    drawn = state.network.position
    turn = np.array([[1.1, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.05]])
    outside = ((drawn < 1e-9) | (drawn > 20e-3 - 1e-9)).any(axis=1)
    state.holders["surface"] = np.flatnonzero(outside)
    state.position[outside] = drawn[outside] @ turn.T
    settle(state, np.ones(len(drawn), dtype=bool))
    assert (~outside).sum() > 200
    np.testing.assert_allclose(state.position, drawn @ turn.T, atol=1e-10 * 20e-3)


def indented(cell, fine=""):
    """Return the number of nodes, and the force of a flat square punch on a corner [N]."""
    state = state_of(cell, fine)
    drawn = state.network.position
    state.holders["base"] = np.flatnonzero(drawn[:, 2] < 1e-6)
    punch = np.flatnonzero((drawn[:, 2] > 19.99e-3) & (drawn[:, :2] < 4.001e-3).all(axis=1))
    state.holders["punch"] = punch
    state.position[punch, 2] -= 0.4e-3
    settle(state, np.ones(len(drawn), dtype=bool))
    still = np.zeros_like(drawn)
    force = observables.force_on(state, 0.0, state.position, still, punch)
    return len(drawn), float(force[2])


def test_fine_cells_at_the_edge_of_a_punch_pay():
    """Its pressure is infinite there; 14.6 mN is what cells of 0.25 mm there tend to."""
    (few, coarse), (many, even), (graded, fine) = indented(4), indented(2), indented(4, FINE)
    assert few < graded < 0.65 * many
    errors = [found / 14.6e-3 - 1.0 for found in (coarse, even, fine)]
    assert errors[0] > 0.15 and errors[1] > 0.07 and 0.0 < errors[2] < 0.06


def lines_of(position):
    """Return where planes of nodes are along each axis [m]."""
    return [np.unique(position[:, axis]) for axis in range(3)]


def test_cells_differ_by_direction():
    box = np.zeros(3), np.array([20.0, 15.0, 20.0]) * MM
    mesh = Lattice("sodium chloride", np.array([4.0, 5.0, 1.0]) * MM, box).build_elements()
    counts = [len(line) - 1 for line in lines_of(mesh.position)]
    assert counts == [5, 3, 20]
    (hexahedra,) = mesh.elements
    corners = mesh.position[hexahedra.nodes]
    edges = np.ptp(corners, axis=1)
    np.testing.assert_allclose(edges, np.broadcast_to([4e-3, 5e-3, 1e-3], edges.shape))
    volumes = SHAPES["hexahedron"].volumes(corners)
    np.testing.assert_allclose(volumes, 20e-9, rtol=1e-12)


def test_a_layer_has_thin_cells_that_grow_away_from_it():
    state = state_of(fine=LAYER)
    across, other, along = lines_of(state.network.position)
    assert len(across) == len(other) == 6
    steps = np.diff(along)
    assert along[0] == 0.0 and steps.sum() == pytest.approx(20e-3, rel=1e-12)
    assert along[-1] == 20e-3 and along[-3] == pytest.approx(19.9e-3, rel=1e-12)
    np.testing.assert_allclose(steps[-2:], 0.05e-3, rtol=1e-9)
    ratios = steps[:-1] / steps[1:]
    assert ratios.min() > 1.0 - 1e-9 and ratios.max() < 1.6 and steps.max() < 4.0001e-3
    assert state.mass.sum() == pytest.approx(8e-3, rel=1e-12)


def test_a_graded_layer_bends_as_a_beam():
    """A bar of one tissue whose ends turn: cells of any thickness have the same curvature.

    With both ends bent about an arc, each cross section turns in proportion to x, which
    hexahedra represent; the moment is that of the theory of beams at ν = 0.
    """
    text = SCENE.format(cell=4, fine=LAYER, ratio=0.0).split("environment")[0]
    compiled = compiled_scene(text + "environment { gravity = (0, 0, 0) m/s^2 }\n"
                              "simulate { duration = 1 ms }")  # fmt: skip
    state = State.start(compiled.network, gravity=np.zeros(3), drag=0.0)
    x, turn = state.network.position, 1e-4
    ends = np.flatnonzero((x[:, 0] < 1e-9) | (x[:, 0] > 20e-3 - 1e-9))
    state.holders["ends"] = ends
    lever, along = x[:, 2] - 10e-3, x[:, 0] - 10e-3
    bent = np.stack([-turn * along * lever / 10e-3, 0 * lever,
                     0.5 * turn * along**2 / 10e-3], axis=1)  # fmt: skip
    state.position[ends] += bent[ends]
    settle(state, np.ones(len(x), dtype=bool))
    # E I κ²/2 L with κ = turn/10 mm.
    energy = sum(each.energy(0.0, state.position) for each in state.network.elements)
    beam = 10e3 * (20e-3) ** 4 / 12.0 * (turn / 10e-3) ** 2 / 2.0 * 20e-3
    assert energy == pytest.approx(beam, rel=1e-3)


def test_the_size_is_foretold():
    found = Lattice(
        "sodium chloride", 4 * MM, (np.zeros(3), np.full(3, 20 * MM)),
        fine_cell=np.array([4.0, 4.0, 0.05]) * MM,
        fine_box=(np.array([0.0, 0.0, 19.9]) * MM, np.full(3, 20 * MM)),
    )  # fmt: skip
    mesh = found.build_elements()
    assert (len(mesh.position), len(mesh.ends)) <= found.element_size()
    assert len(mesh.position) == found.element_size()[0]


@pytest.mark.parametrize(("thin", "is_reported"), [("0.05", False), ("0.04", False),
                                                   ("0.02", True)])  # fmt: skip
def test_cells_that_are_far_longer_than_thick_are_reported(thin, is_reported):
    fine = LAYER.replace("0.05", thin).replace("19.9", "19.96")
    compiled = compiled_scene(SCENE.format(cell=4, fine=fine, ratio=0.3))
    found = [each for each in check_all(compiled, thorough=False) if each.code == "W216"]
    assert len(found) == is_reported
    for each in found:
        # Two layers of 20 um, and the next one of 30 um.
        assert each.message == (
            "75 cells of block are up to 200 times as long as thick (4 mm and 20 um)"
        )


@pytest.mark.parametrize(
    ("fine", "said"),
    [
        ("fine cell = 1 mm", '"fine cell" and "fine box" are needed together'),
        ("fine cell = 4" + FINE[13:], '"fine cell" must be smaller than "cell"'),
        (FINE.replace("(3, 3, 19)", "(3, 3, 29)").replace("5, 20)", "5, 30)"),
         '"fine box" is outside of the "box"'),
        (FINE.replace("= 1 mm", "= (1, 5, 1) mm"),
         '"fine cell" must not be larger than "cell" along y'),
        (LAYER.replace("0.05", "1e-9"),
         '"fine cell" is too small for the "fine box": it gives too many cells'),
        (LAYER.replace("0.05", "0"), "fine cell cannot be 0 m along z"),
    ],
)  # fmt: skip
def test_what_cannot_be_finer_is_refused(fine, said):
    text = SCENE.format(cell=4, fine=fine, ratio=0.3)
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("(4, 4, 3)", '"box" is 20 mm long in z, which is not a whole number of '
         'cells ("cell" = 3 mm); 18 mm or 21 mm would fit'),
        ("(4, 4)", "cell is one number, or three for x, y and z"),
        ("(4, 4, -1)", "cell cannot be -1 mm along z"),
    ],
)  # fmt: skip
def test_what_cannot_differ_by_direction_is_refused(cell, said):
    with pytest.raises(CompileError) as caught:
        compiled_scene(SCENE.format(cell=cell, fine="", ratio=0.3))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("cell", "fine", "said"),
    [
        ("4", FINE, '"fine cell"'),
        ("(4, 4, 2)", "", 'a "cell" that differs by direction'),
    ],
)
def test_cells_of_nets_are_cubes_of_one_size(cell, fine, said):
    with pytest.raises(CompileError, match=f"{said} is for bodies made of elements"):
        compiled_scene(NET.format(cell=cell, fine=fine))
