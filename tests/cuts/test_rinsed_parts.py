"""Jets on solids and walls that blades divide."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import erf

from tests.cuts.scenes import GEL, UNUSED, ahead_of, begun, cut
from tests.hand_net import Diary
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed

LATTICE = "lattice { cell = 2 mm; box from (0, 0, 0) mm to (20, 10, 4) mm }"
SHEET = (
    "sheet { corner = (0, 0, 4) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm\n"
    "  columns = 11; rows = 6 }"
)
THRUST = 4.0 * 1000.0 * (5e-6) ** 2 / (np.pi * 2e-3**2)
WIDTH = 2e-3 / np.sqrt(2.0)
ON = "at 0 s: irrigate block with 5 ml/s through nozzle"
#: Through the axis of the jet, between cells, through them, and obliquely.
BLADES = [((10, 5, 2), (1, 0, 0)), ((10.7, 5, 2), (1, 0, 0)), ((9.6, 5, 2), (1, 0.4, 0.3))]


def scene(orders, mesh=LATTICE, cuts=2, end="simulate { duration = 1 s }\n", tip="(10, 5, 20)"):
    """Return the text of a block 4 mm thick under a nozzle, or of a wall at its surface."""
    thick = "thickness = 1 mm" if mesh == SHEET else ""
    return (
        f"{GEL}body block {{ mesh is {mesh}; made of elements; tissue is gel; {thick} }}\n"
        "set base = nodes of block where x < 0.1 mm or x > 19.9 mm\n"
        "set half = nodes of block where x < 10.1 mm\n"
        f"tool nozzle {{ kind is nozzle; diameter = 2 mm; tip = {tip} mm\n"
        "  direction = (0, 0, -1) }\nenvironment { gravity = (0, 0, 0) m/s^2 }\n"
        f"script {{ {orders}\n{UNUSED * cuts} }}\n{end}"
    )


def pushes(state):
    """Return the forces of the jet on hosts [N], shape (node, 3), without the recoil."""
    (jet,) = state.jets.values()
    found = np.zeros_like(state.position)
    jet.add_forces(0.0, state.position, np.zeros_like(state.velocity), found)
    found[jet.opening] = 0.0
    return state.embedding.shared(found)


@pytest.mark.parametrize("mesh", [LATTICE, SHEET])
@pytest.mark.parametrize("blade", BLADES)
def test_a_jet_pushes_what_is_cut_but_closed(mesh, blade):
    """Where the faces of a cut touch each other, nothing gets between them."""
    state = begun(scene(ON, mesh))
    assert_allclose(pushes(state).sum(axis=0), [0.0, 0.0, -THRUST], atol=2e-3 * THRUST)
    cut(state, *blade)
    cut(state, (10, 5.3, 2), (0.1, 1, 0.2))
    found = pushes(state)
    assert_allclose(found.sum(axis=0), [0.0, 0.0, -THRUST], atol=2e-2 * THRUST)


@pytest.mark.parametrize("mesh", [LATTICE, SHEET])
@pytest.mark.parametrize("gap", [0.5e-3, 1e-3, 2e-3])
def test_what_goes_through_a_gap_pushes_nothing(mesh, gap):
    """Of a flux that is even along the gap, as exp(-2 x²/b²) across it, erf(g/(√2 b)) goes."""
    state = begun(scene(ON, mesh))
    cut(state, (10.7, 5, 2), (1, 0, 0))
    ahead = ahead_of(state, (10.7, 5, 2), (1, 0, 0))
    state.position = state.position - [[0.7e-3, 0.0, 0.0]]
    state.position[ahead, 0] += 0.5 * gap
    state.position[~ahead, 0] -= 0.5 * gap
    (jet,) = state.jets.values()
    state.position[jet.opening] = [[10e-3, 5e-3, 20e-3], [10e-3, 5e-3, 10e-3]]
    state.follow_hosts()
    expected = THRUST * (1.0 - erf(0.5 * gap * np.sqrt(2.0) / WIDTH))
    assert -pushes(state)[:, 2].sum() == pytest.approx(expected, abs=2e-2 * THRUST)


def test_a_jet_pushes_the_face_of_a_cut():
    """One half is turned up, so that its face is where the surface was."""
    state = begun(scene(ON, tip="(10, 5, 40)"))
    cut(state, (10.7, 5, 2), (1, 0, 0))
    ahead = ahead_of(state, (10.7, 5, 2), (1, 0, 0))
    centre = np.array([10.7e-3, 5e-3, 2e-3])
    arm = state.position[~ahead] - centre
    turned = np.stack([-arm[:, 2], arm[:, 1], arm[:, 0]], axis=1)
    state.position[~ahead] = np.array([10e-3, 5e-3, 4e-3]) + turned
    state.position[ahead, 0] += 0.1
    (jet,) = state.jets.values()
    state.position[jet.opening] = [[10e-3, 5e-3, 40e-3], [10e-3, 5e-3, 30e-3]]
    state.follow_hosts()
    found = pushes(state)
    # Of 4 mm across, erf(2 mm √2/b) of the jet hits the face.
    expected = THRUST * erf(2e-3 * np.sqrt(2.0) / WIDTH)
    assert -found[:, 2].sum() == pytest.approx(expected, abs=2e-2 * THRUST)
    assert abs(found[ahead]).max() < 1e-15


@pytest.mark.parametrize("target", ["block ", "half ", ""])
def test_a_jet_that_begins_after_a_cut_is_the_same(target):
    order = f"at 0 s: irrigate {target}with 5 ml/s through nozzle"
    before, after = begun(scene(order)), begun(scene(order))
    cut(before, *BLADES[2])
    after.remove(*(b for b in after.blocks.values() if b.kind == "jet"))
    cut(after, *BLADES[2])
    action = compiled_scene(scene(order)).plan.events[0].action
    action.apply(after, Diary())
    assert np.array_equal(pushes(before), pushes(after))
    assert np.abs(pushes(before)).max() > 0.0


SMALL = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"
SLIT = (
    "at 0 s: fix base\n"
    "from 1 ms to 3 ms: irrigate block with 5 ml/s through nozzle using smooth profile\n"
    "at 1.5 ms: cut block along line from (10.7, -1, 0) mm to (10.7, 6, 0) mm "
    "facing (1, 0, 0)\n"
    "at 2 ms: cut block along plane through (10, 4.3, 0) mm facing (0.1, 1, 0.1)\n"
)
LOGGED = """output { trajectory every 1 ms; force of base every 0.5 ms; energy every 1 ms }
simulate { duration = 3 ms; tolerance = 1e-3 }
"""


def test_scipy_finds_the_same_motion():
    same_motion(scene(SLIT, SMALL, 0, LOGGED), within=1e-3)


def test_a_run_that_is_resumed_gives_the_same_bytes():
    same_when_resumed(compiled_scene(scene(SLIT, SMALL, 0, LOGGED)), "force of base", 3)


def test_threads_change_no_bit(threads_in_small_nets):
    fine = LATTICE.replace("cell = 2 mm", "cell = 1 mm")
    same_on_two_threads(compiled_scene(scene(SLIT, fine, 0, LOGGED)), "force of base")
