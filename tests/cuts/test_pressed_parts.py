"""Pressure and active fibres on solids that blades divide."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.cuts.scenes import GEL, SHEET, TUBE, UNUSED, ahead_of, begun, cut
from tests.cuts.test_divided_solids import BLADES, LATTICE, ROUND
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import carried_out, same_on_two_threads, same_when_resumed
from tissuec.script.measures.snapshot import Snapshot

MUSCLE = GEL.replace("gel {", "gel { fibre modulus = 20 kPa;")
SETS = """set base = nodes of block where x < 0.01 mm
set far = nodes of block where x > 19.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
"""
AXIAL = ((10, 5.3, 5), (0, 1, 0.2))  # a blade along x


def scene(orders, mesh=LATTICE, cuts=2, end="simulate { duration = 1 s }\n"):
    body = f"body block {{ mesh is {mesh}; tissue is gel; fibres = (1, 0, 0) }}\n"
    return MUSCLE + body + SETS + f"script {{ {orders}\n{UNUSED * cuts} }}\n{end}"


def wrench(state, field, position):
    """Return the sum of forces on hosts, and of their moments."""
    found = np.zeros_like(position)
    field.add_forces(0.0, position, np.zeros_like(state.velocity), found)
    found = state.embedding.shared(found)
    return np.concatenate([found.sum(axis=0), np.cross(position, found).sum(axis=0)])


def deformed(state, seed=4):
    """Return positions after a linear map of the drawing."""
    turn = np.eye(3) + 0.3 * np.random.default_rng(seed).normal(size=(3, 3))
    return state.drawn @ turn.T


@pytest.mark.parametrize("mesh", [LATTICE, ROUND])
@pytest.mark.parametrize("blade", [*BLADES, AXIAL])
def test_a_cut_keeps_the_push_of_pressure(mesh, blade):
    """Force and moment are integrals of p n and p x × n over the same flat faces."""
    state = begun(scene("at 0 s: press far with 1 kPa", mesh))
    (field,) = state.pressures
    expected = wrench(state, field, deformed(state))
    for one in (blade, ((10.3, 4.4, 5.2), (0.1, 1, 0.3))):
        cut(state, *one)
        (field,) = state.pressures
        found = wrench(state, field, deformed(state))
        assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())
    new = begun(scene("at 0 s: press far with 1 kPa", mesh))
    cut(new, *blade)
    cut(new, (10.3, 4.4, 5.2), (0.1, 1, 0.3))
    (late,) = new.pressures
    assert_allclose(
        wrench(new, late, deformed(new)), expected, atol=1e-12 * abs(expected).max()
    )


def test_pressure_acts_where_the_blade_went_through():
    """Faces of cells that are divided are pressed; without them, their share would be lost."""
    state = begun(scene("at 0 s: press far with 1 kPa"))
    cut(state, *AXIAL)
    (field,) = state.pressures
    corners = state.position[field.faces.triples.corners]
    areas = 0.5 * np.linalg.norm(np.cross(*np.diff(corners, axis=1).swapaxes(0, 1)), axis=1)
    assert field.faces.triples.weight @ areas == pytest.approx(100e-6, rel=1e-12)
    assert (field.faces.parts >= 0).any()


def test_pressure_on_all_of_a_block_that_is_cut_leaves_the_cut_free():
    """Each half is pushed by p times the area of the section, towards the cut."""
    state = begun(scene("at 0 s: press block with 1 kPa"))
    cut(state, (11.2, 5, 5), (1, 0, 0.2))
    (field,) = state.pressures
    found = np.zeros_like(state.position)
    field.add_forces(0.0, state.position, np.zeros_like(state.velocity), found)
    found = state.embedding.shared(found)
    ahead = ahead_of(state, (11.2, 5, 5), (1, 0, 0.2))
    expected = 1e3 * 100e-6 * np.array([-1.0, 0.0, -0.2])
    assert_allclose(found[ahead].sum(axis=0), expected, atol=1e-15)
    assert_allclose(found[~ahead].sum(axis=0), -expected, atol=1e-15)


def test_a_half_under_pressure_and_weight_falls_as_its_mass_says():
    """The middle of mass moves by (p A / m + g) t² / 2.

    The pressure is so small that it changes the area by a millionth.
    """
    orders = (
        "at 0 s: { fix base; cut block along plane through (11.2, 0, 0) mm facing (1, 0, 0)\n"
        "  press far with 0.02 Pa }"
    )
    end = "simulate { duration = 10 ms; tolerance = 1e-9 }\n"
    text = scene(orders, cuts=0, end=end).replace("(0, 0, 0) m/s^2", "(0, 0, -0.01) m/s^2")
    outcome, _ = carried_out(compiled_scene(text))
    state = outcome.state
    pieces = Snapshot.of(state).pieces
    is_drawn = state.network.parents == np.arange(len(pieces))
    tip = np.argmax(state.network.position[:, 0] * is_drawn)
    weight = np.where(pieces == pieces[tip], state.inertia, 0.0)
    mass = 1000.0 * 8.8e-3 * 100e-6
    assert weight.sum() == pytest.approx(mass, rel=1e-12)
    way = weight @ (state.position - state.drawn) / mass
    expected = 0.5 * 1e-4 * np.array([-0.02 * 100e-6 / mass, 0.0, -0.01])
    assert_allclose(way, expected, atol=1e-6 * 5e-7)


@pytest.mark.parametrize("mesh", [LATTICE, ROUND])
@pytest.mark.parametrize("blade", [*BLADES, AXIAL])
def test_parts_of_muscle_store_what_the_whole_does(mesh, blade):
    """Where the body is mapped linearly, ∫ S Φ dV depends on the volume alone."""
    state = begun(scene("at 0 s: activate block with 5 kPa over 50 % to 180 %", mesh))
    place = deformed(state)
    (field,) = (b.field for b in state.present_blocks if b.kind == "activation")
    expected = field.intact(state.alive).potential(0.0, place)
    for one in (blade, ((10.3, 4.4, 5.2), (0.1, 1, 0.3))):
        cut(state, *one)
        (field,) = (b.field for b in state.present_blocks if b.kind == "activation")
        found = field.intact(state.alive).potential(0.0, deformed(state))
        assert found == pytest.approx(expected, rel=1e-12)


def test_a_muscle_that_is_cut_along_its_fibres_pulls_as_before():
    """Of the force at an end, S times the area, both halves bear their parts."""
    state = begun(scene("at 0 s: activate block with 5 kPa"))
    cut(state, *AXIAL)
    (field,) = (b.field for b in state.present_blocks if b.kind == "activation")
    found = np.zeros_like(state.position)
    field.intact(state.alive).add_forces(
        0.0, state.position, np.zeros_like(state.velocity), found
    )
    end = state.drawn[:, 0] < 1e-6
    assert found[end].sum(axis=0)[0] == pytest.approx(5e3 * 100e-6, rel=1e-9)
    inner = (state.drawn[:, 0] > 1e-6) & (state.drawn[:, 0] < 19.9e-3)
    for x in np.unique(np.round(state.drawn[inner, 0], 6)):
        there = np.abs(state.drawn[:, 0] - x) < 1e-6
        assert abs(found[there].sum(axis=0)).max() < 1e-12


SLIT = (
    "at 0 s: { fix base; press far with 200 Pa }\n"
    "from 2 ms to 6 ms: cut block along line from (11.2, -1, 0) mm to (11.2, 6, 0) mm "
    "facing (1, 0, 0) using constant speed\n"
    "at 3 ms: activate block with 500 Pa\n"
    "from 7 ms to 12 ms: press far with 100 Pa\n"
    "at 8 ms: cut block along plane through (15, 5, 0) mm facing (0.1, 1, 0.1)\n"
)
LOGGED = """output { trajectory every 1 ms; force of base every 1 ms; energy every 1 ms }
simulate { duration = 10 ms; tolerance = 1e-4 }
"""
SMALL = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"


def test_scipy_finds_the_same_motion():
    same_motion(scene(SLIT, SMALL, 0, LOGGED))


def test_a_run_that_is_resumed_gives_the_same_bytes():
    same_when_resumed(compiled_scene(scene(SLIT, SMALL, 0, LOGGED)), "force of base", 3, 7)


def test_threads_change_no_bit(threads_in_small_nets):
    mesh = "lattice { cell = 1.25 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"
    same_on_two_threads(compiled_scene(scene(SLIT, mesh, 0, LOGGED)), "force of base")


@pytest.mark.parametrize(
    ("mesh", "order"),
    [(SHEET, "press block with 1 kPa along (0, 0, 1)"),
     (SHEET, "press block with 1 kPa along (0, 0, -1)"), (TUBE, "press block with 1 kPa")],
)  # fmt: skip
def test_a_cut_keeps_the_push_of_pressure_on_a_wall(mesh, order):
    """On whichever side a wall is pressed, its parts are, too."""
    body = (
        f"body block {{ mesh is {mesh}\n made of elements; tissue is gel; thickness = 1 mm }}\n"
    )
    environment = "environment { gravity = (0, 0, 0) m/s^2 }\n"
    text = GEL + body + environment + f"script {{ at 0 s: {order}\n{UNUSED * 2} }}\n"
    state = begun(text + "simulate { duration = 1 s }\n")
    (field,) = state.pressures
    expected = wrench(state, field, deformed(state))
    for one in (((11.2, 5, 0), (1, 0.2, 0)), ((10.3, 4.4, 5.2), (0.1, 1, 0.3))):
        cut(state, *one)
        (field,) = state.pressures
        assert (field.faces.parts >= 0).any()
        found = wrench(state, field, deformed(state))
        size = 1e3 * 200e-6 if mesh == SHEET else 1e3 * 600e-6
        assert_allclose(found, expected, atol=1e-12 * size)
