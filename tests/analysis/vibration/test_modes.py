"""Natural frequencies against closed forms, and against forces that are differentiated."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_matrix

from tests.hand_net import chain, make_net, span, start
from tissuec.analysis.vibration import operator
from tissuec.analysis.vibration.modes import modes_of
from tissuec.core.structs import replace
from tissuec.forces import pooled_fields
from tissuec.forces.enclosed.volume import Enclosure
from tissuec.mechanics import observables
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.dissection import dissected
from tissuec.model import topology

ROUNDING = 1e-9  # relative, of eigenvalues no smaller than a millionth of the largest


@pytest.fixture(params=["dense", "sparse"])
def solver(request, monkeypatch):
    """Solve small nets in either way."""
    if request.param == "sparse":
        monkeypatch.setattr(operator, "DENSE", 0)
    return request.param


def everything(state):
    return np.ones(state.network.node_count, dtype=bool)


def modes(state, **given):
    return modes_of(state, everything(state), **given)


def omega(found):
    return np.array([2.0 * np.pi * mode.frequency for mode in found])


def held(network, nodes):
    state = start(network)
    state.holders["fix"] = np.array(nodes)
    return state


def test_a_chain_between_walls_has_its_known_frequencies_and_damping(solver):
    n, k, m, d = 12, 100.0, 0.1, 0.3
    state = held(chain(n + 2, stiffness=k, mass=m, damping=d), [0, n + 1])
    state.drag = 0.05
    found = modes(state, count=7, above=0.0)
    known = 2.0 * np.sqrt(k / m) * np.sin(np.arange(1, 8) * np.pi / (2 * (n + 1)))
    assert omega(found) == pytest.approx(known, rel=ROUNDING)
    ratio = [mode.damping_ratio for mode in found]
    assert ratio == pytest.approx(known * d / (2 * k) + 0.05 / m / (2 * known), rel=1e-6)
    assert {mode.kind for mode in found} == {"vibration"}


def test_two_masses_and_a_spring_vibrate_once_and_are_rigid_otherwise(solver):
    k, masses, d = 40.0, np.array([0.1, 0.3]), 0.02
    found = modes(start(chain(2, stiffness=k, mass=masses, damping=d)), count=6)
    assert [mode.kind for mode in found] == ["rigid"] * 5 + ["vibration"]
    reduced = masses.prod() / masses.sum()
    assert omega(found[5:])[0] == pytest.approx(np.sqrt(k / reduced), rel=ROUNDING)
    assert found[5].damping_ratio == pytest.approx(d / 2 / np.sqrt(k * reduced), rel=1e-6)
    assert found[5].period == pytest.approx(1.0 / found[5].frequency)


def tangled(count=9, seed=3):
    """Return a net of random nodes that are all joined, with random numbers, unstressed."""
    draw = np.random.default_rng(seed)
    position = draw.normal(size=(count, 3))
    ends = [(i, j) for i in range(count) for j in range(i)]
    sizes = draw.uniform(1.0, 3.0, len(ends))
    return make_net(position, ends, stiffness=sizes, mass=draw.uniform(1.0, 3.0, count))


def test_a_free_body_has_three_translations_and_three_rotations(solver):
    state = start(tangled())
    found = modes(state, count=8)
    assert [mode.kind for mode in found] == ["rigid"] * 6 + ["vibration"] * 2
    momentum = [np.linalg.norm(state.mass @ mode.shape) for mode in found]
    whole = np.sqrt(state.mass.sum())  # of a translation with φᵀ M φ = 1
    assert momentum == pytest.approx([whole] * 3 + [0.0] * 5, abs=1e-6)
    lengths = observables.lengths(state.network.springs.ends, state.position)
    for mode in found[:6]:
        moved = observables.lengths(
            state.network.springs.ends, state.position + 1e-6 * mode.shape
        )
        assert moved == pytest.approx(lengths, abs=1e-10)  # the square of the motion


def test_a_body_on_one_point_turns_about_it_and_a_lone_node_is_rigid(solver):
    assert [m.kind for m in modes(held(tangled(), [4]), count=5)] == ["rigid"] * 3 + [
        "vibration"
    ] * 2
    assert modes(start(make_net([[0, 0, 0], [1, 0, 0]], [])), count=2).notes == (
        "6 modes have frequency 0; --above 0 omits them",
    )
    lone = make_net([[0, 0, 0], [1, 0, 0], [5, 0, 0]], [[0, 1]])
    assert [m.kind for m in modes(start(lone), count=9)] == ["rigid"] * 8 + ["vibration"]


def grid(columns, rows, *, rest=None, mass=0.01):
    position = [[i, j, 0.0] for j in range(rows) for i in range(columns)]
    node = np.arange(columns * rows).reshape(rows, columns)
    along = np.stack([node[:, :-1], node[:, 1:]], -1).reshape(-1, 2)
    across = np.stack([node[:-1], node[1:]], -1).reshape(-1, 2)
    ends = np.concatenate([along, across])
    return make_net(position, ends, stiffness=50.0, mass=mass, rest=rest)


def test_motions_of_a_sheet_without_diagonals_are_counted_as_floppy(solver):
    net = grid(5, 4)
    found = modes(start(net), count=50)
    counts = {kind: sum(m.kind == kind for m in found) for kind in ("rigid", "mechanism")}
    fixed = np.zeros(net.node_count, dtype=bool)
    other = topology.floppy_modes(
        net.position, net.springs.ends, net.springs.stiffness, net.springs.rest, fixed
    )
    assert counts == {"rigid": other.rigid, "mechanism": other.count + other.across}
    few = modes(start(net), count=8)
    total = other.rigid + other.count + other.across
    assert few.notes == (f"{total} modes have frequency 0; --above 0 omits them",)
    assert modes(start(net), count=3, above=0.0)[0].kind == "vibration"


@pytest.mark.parametrize("rows", range(2, 7))
@pytest.mark.parametrize("columns", range(2, 9))
def test_sheets_without_diagonals_vibrate_along_their_threads(columns, rows, solver):
    """All other motions have frequency 0, and there are more of them."""
    net = grid(columns, rows)
    threads = [2.0 * np.sin(np.arange(1, n) * np.pi / (2 * n)) for n in (columns, rows)]
    relative = np.sort(
        np.concatenate((np.tile(threads[0], rows), np.tile(threads[1], columns)))
    )
    found = modes(start(net), count=4, above=0.0)
    assert omega(found) == pytest.approx(np.sqrt(50.0 / 0.01) * relative[:4], rel=ROUNDING)


def test_a_net_under_tension_vibrates_across_as_it_should(solver):
    vibrates_across(8)


def test_a_large_net_under_tension_vibrates_across_as_it_should():
    vibrates_across(40)  # 4563 unknowns


def vibrates_across(n):
    """Compare with m ω² = 4 T/l (sin² iπ/2n + sin² jπ/2n) of a square net with a fixed rim."""
    m, tension = 0.01, 50.0 * (1.0 - 0.99)
    net = grid(n + 1, n + 1, rest=0.99, mass=m)
    rim = np.flatnonzero(((net.position[:, :2] % n) == 0).any(axis=1))
    found = modes(held(net, rim), count=12)
    half = np.sin(np.arange(1, n) * np.pi / (2 * n)) ** 2
    known = np.sqrt(4.0 * tension / m * np.sort((half[:, None] + half).ravel())[:12])
    assert omega(found) == pytest.approx(known, rel=ROUNDING)
    assert found.notes == ()
    for mode in found:
        assert mode.shape[:, :2] == pytest.approx(0.0, abs=1e-6 * np.abs(mode.shape).max())


def octahedron(seed=1):
    """Return a closed surface with some springs inside, a volume, and a field of tensions."""
    draw = np.random.default_rng(seed)
    position = np.vstack([np.eye(3), -np.eye(3)]) + 0.1 * draw.normal(size=(6, 3))
    ends = [(i, j) for i in range(6) for j in range(i)]
    net = make_net(position, ends, stiffness=draw.uniform(5, 9, 15), mass=draw.uniform(1, 2, 6))
    skin = [[a, b, c] for a in (0, 3) for b in (1, 4) for c in (2, 5)]
    outward = [np.linalg.det(position[face]) > 0 for face in skin]
    faces = [f if out else f[::-1] for f, out in zip(skin, outward, strict=True)]
    corners = np.array(faces)[:, [0, 1, 2, 2]]
    state = start(net)
    rest = net.springs.rest * draw.uniform(0.9, 1.3, 15)
    state.springs = replace(state.springs, rest=rest)
    none = np.zeros(0, dtype=np.int64)
    volume = Enclosure(
        none, none, "net", np.array([1.1]), 30.0, (), span(), corners, np.array([0, 8])
    )
    state.put(volume.block)
    return state


def differentiated(state):
    """Return K [N/m] of the free nodes from differences of forces."""
    free = (3 * np.flatnonzero(~state.held)[:, None] + np.arange(3)).ravel()
    matrix, still = np.zeros((len(free),) * 2), np.zeros_like(state.position)
    for column, entry in enumerate(free):
        step = np.zeros(state.position.size)
        step[entry] = 1e-5
        forces = [
            observables.inner_forces(state, 0.0, state.position + way, still).node.ravel()
            for way in (step.reshape(-1, 3), -step.reshape(-1, 3))
        ]
        matrix[:, column] = (forces[1] - forces[0])[free] / 2e-5
    return matrix, np.repeat(state.mass, 3)[free]


@pytest.mark.parametrize("is_wide", [True, False])
def test_modes_are_those_of_the_forces_with_prestress_and_volumes(is_wide, solver, monkeypatch):
    if is_wide:
        monkeypatch.setattr(pooled_fields, "LARGE", 0)
    state = octahedron()
    state.holders["fix"] = np.array([2])
    matrix, mass = differentiated(state)
    known, shapes = eigh(matrix, np.diag(mass))
    found = modes(state, count=4)  # of 15: more than a third are left to the dense solver
    unstable = int((known < 0.0).sum())
    assert 0 < unstable < 4
    assert [mode.kind for mode in found[:unstable]] == ["unstable"] * unstable
    growth = [mode.growth for mode in found[:unstable]]
    assert growth == pytest.approx(np.sqrt(-known[:unstable]), rel=1e-6)
    assert omega(found[unstable:]) == pytest.approx(np.sqrt(known[unstable:4]), rel=1e-6)
    for mode, shape in zip(found, shapes.T, strict=False):
        same = np.vdot(shape * mass, mode.shape[~state.held])
        assert abs(same) == pytest.approx(1.0, abs=1e-5)


def test_signs_of_pivots_count_the_eigenvalues_below_a_shift(monkeypatch):
    monkeypatch.setattr(pooled_fields, "LARGE", 0)
    state = octahedron()
    balance = Balance(state, everything(state))
    made = operator.operator_of(balance, balance.bars(balance.start))
    assert made.wide.shape == (18, 1)
    values = np.linalg.eigvalsh(made.dense())
    probe = np.arange(18.0)
    for shift in 0.5 * (values[1:] + values[:-1])[np.diff(values) > 1e-3]:
        shifted = operator.Shifted(made, shift)
        assert shifted.below == (values < shift).sum()
        found = shifted.solve(probe)
        assert made(found) - shift * found == pytest.approx(probe, abs=1e-9)


def test_copies_of_a_frequency_are_all_found(monkeypatch):
    # Nine chains of their own, which differ in nothing: each frequency comes nine times in each
    # of three directions.
    monkeypatch.setattr(operator, "DENSE", 0)
    position = np.array([[i, 3 * k, 0] for k in range(9) for i in range(11)], dtype=float)
    ends = [(11 * k + i, 11 * k + i + 1) for k in range(9) for i in range(10)]
    net = make_net(position, ends, rest=0.0)  # springs of no rest length resist in all ways
    state = held(net, [11 * k + i for k in range(9) for i in (0, 10)])
    found = modes(state, count=60)
    known = 2.0 * np.sin(np.repeat([1, 2, 3], 27) * np.pi / 20)[:60]
    assert omega(found) == pytest.approx(known, rel=1e-6)
    shapes = np.array([mode.shape for mode in found]).reshape(60, -1)
    assert shapes @ shapes.T == pytest.approx(np.eye(60), abs=1e-8)


def test_an_unstable_state_is_told_by_how_fast_it_grows(solver):
    # A joint between two pressed springs, kept straight by two others of stiffness k along each
    # of y and z: m λ = 2 k - 2 P / L.
    k, load, mass = 3.0, 4.0, 0.2
    position = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1]]
    ends = [[0, 1], [1, 2], [1, 3], [1, 4], [1, 5], [1, 6]]
    rest = [1 + load / 100, 1 + load / 100, 1, 1, 1, 1]
    stiffness = [100.0, 100.0, *[k] * 4]
    net = make_net(position, ends, stiffness=stiffness, rest=rest, mass=mass)
    found = modes(held(net, [0, 2, 3, 4, 5, 6]), count=3)
    assert [mode.kind for mode in found] == ["unstable", "unstable", "vibration"]
    assert [mode.growth for mode in found[:2]] == pytest.approx(
        [np.sqrt((2 * load - 2 * k) / mass)] * 2, rel=ROUNDING
    )
    assert found[0].frequency is None and found[0].period is None
    assert found.notes == ()  # it is in balance all the same


def test_a_pressed_chain_is_unstable_in_as_many_ways_as_are_known(solver):
    # m λ² = 4 P/L sin² jπ/2(n+1) across the chain, in two directions.
    n, k, part = 12, 100.0, 0.05
    state = held(chain(n + 2, stiffness=k, rest=1.0 + part), [0, n + 1])
    found = modes(state, count=5)
    j = np.array([n, n, n - 1, n - 1, n - 2])
    known = 2.0 * np.sqrt(k * part) * np.sin(j * np.pi / (2 * (n + 1)))
    assert [mode.growth for mode in found] == pytest.approx(known, rel=ROUNDING)


def test_forces_that_do_not_balance_are_told_with_their_size():
    state = held(chain(3, stiffness=100.0, rest=0.9), [0])
    (note,) = modes(state, count=1).notes
    assert note.startswith("forces do not balance: up to 10 N on a node, where the largest")


def test_the_order_of_elimination_takes_every_node_once_and_fills_little():
    side = 12
    net = grid(side, side)
    low, high = net.springs.ends.T
    joined = csr_matrix(
        (np.ones(2 * len(low)), (np.r_[low, high], np.r_[high, low])), shape=(side**2,) * 2
    )
    order = dissected(net.position, joined).nodes
    assert sorted(order) == list(range(side**2))
    # The last to be eliminated part the net: without them it falls apart.
    whole = np.isin(net.springs.ends, order[-side:]).any(axis=1)
    inner = topology.pieces(side**2, net.springs.ends[~whole])[order[:-side]]
    assert len(np.unique(inner)) == 2


def test_frequencies_come_in_order_with_the_unstable_first():
    state = octahedron()
    found = modes(state, count=18)
    place = {"unstable": 0, "rigid": 1, "mechanism": 1, "vibration": 2}
    assert all(place[a.kind] <= place[b.kind] for a, b in pairwise(found))
    vibrations = [m.frequency for m in found if m.kind == "vibration"]
    assert vibrations == sorted(vibrations)
    assert [mode.number for mode in found] == list(range(1, 19))


def test_modes_of_frequency_0_are_counted_without_the_unstable_ones(solver):
    position = [
        [0, 0, 0],
        [1, 0, 0],
        [2, 0, 0],
        [9, 0, 0],
    ]  # a joint under pressure, and a node
    found = modes(held(make_net(position, [[0, 1], [1, 2]], rest=1.1), [0, 2]), count=4)
    assert [mode.kind for mode in found] == ["unstable"] * 2 + ["rigid"] * 2
    assert found.notes == ("3 modes have frequency 0; --above 0 omits them",)
