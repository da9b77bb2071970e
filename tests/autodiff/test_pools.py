"""Items whose groups weigh them by sums and by the greatest of their parts."""

from functools import partial

import numpy as np
import pytest

from tissuec.autodiff import dot, maximum, norm, where
from tissuec.autodiff.pools import Factors, Shares, TracedPool
from tissuec.compiled.calls import kernel_on
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops.pools import force_kernel, pull_kernel, push_kernel
from tissuec.compiled.loops.tables import ItemTable, PoolTable, room_for

ITEMS, GROUPS, NODES = 61, 7, 12
LENGTH, STEP = 1.5, 1e-6
RANDOM = np.random.default_rng(3)
CORNERS = np.stack([RANDOM.permutation(NODES)[:2] for _ in range(ITEMS)])
OWNER = np.sort(np.append(np.arange(GROUPS), RANDOM.integers(GROUPS, size=ITEMS - GROUPS)))
BRAKE, STIFFNESS = RANDOM.uniform(0.5, 2.0, GROUPS), RANDOM.uniform(0.5, 2.0, ITEMS)
X, V = RANDOM.normal(size=(2, NODES, 3))


def parts(x, v, p):
    """Return those of a rope: its energy, the greatest one of which counts, and its power."""
    way = x[1] - x[0]
    length = norm(way)
    longer = maximum(length - LENGTH, 0.0)
    energy = 0.5 * p.stiffness * longer**2
    power = p.stiffness * longer * dot(way, v[1] - v[0]) / length
    bends = where(longer > 0.0, 1.0, 0.0)
    return Shares([energy], [energy, energy, power], frozenset((1,)), longer, bends)


def factors(sums, seen, p):
    total, most, power = sums
    return Factors(
        [1.0 + total + 3.0 * most + p.brake * power],
        lost=total * power,
        bends=total * 0.0 + 2.0,
    )


POOL = TracedPool(parts, factors, 2, {"stiffness": 1}, {"brake": 1}, ("stiffness",))
NUMBERS = {"brake": False}


def expected(x, v, brake, stiffness):
    """Return forces, the power that is lost, and the bends, by the definition."""
    way, speed = (each[CORNERS[:, 1]] - each[CORNERS[:, 0]] for each in (x, v))
    length = np.linalg.norm(way, axis=1)
    longer = np.maximum(length - LENGTH, 0.0)
    energy, pull = 0.5 * stiffness * longer**2, (stiffness * longer / length)[:, None] * way
    total, power = (
        np.bincount(OWNER, each, GROUPS) for each in (energy, (pull * speed).sum(axis=1))
    )
    most = np.maximum.reduceat(energy, np.flatnonzero(np.diff(OWNER, prepend=-1)))
    pull *= (1.0 + total + 3.0 * most + brake * power)[OWNER, None]
    forces = np.zeros_like(x)
    np.add.at(forces, CORNERS[:, 0], pull)
    np.subtract.at(forces, CORNERS[:, 1], pull)
    return forces.ravel(), total @ power, np.count_nonzero(longer) + 2 * GROUPS


def table(brake=BRAKE, stiffness=STIFFNESS):
    none = np.zeros(ITEMS, dtype=int)
    own = GROUPS + np.arange(ITEMS)[:, None]
    items = ItemTable.of(np.column_stack([CORNERS, none, OWNER]), stiffness[None], own)
    groups = np.column_stack([np.arange(GROUPS), none[:GROUPS]])
    begins = np.searchsorted(OWNER, np.arange(GROUPS + 1))
    terms, room = np.zeros((13, 0)), room_for(len(POOL.rows), ITEMS).ravel()
    nothing = ItemTable(0, none[:0], terms.ravel())
    return PoolTable(
        nothing, nothing, 0, items, ItemTable.of(groups, brake[None]), begins, items.places,
        room, np.array([0, 99, 0]),
    )  # fmt: skip


def run(write, record, *vectors):
    kernel_on(GeneratedKernel("pooled", write), record, len(vectors))(0.0, *vectors)


def forces(*records, lanes=8):
    found, power = np.zeros(3 * NODES), np.zeros(2)
    for record in records:
        write = partial(force_kernel, item=POOL.item, pool=POOL, lanes=lanes)
        run(write, record, X.ravel(), V.ravel(), found, power)
    return found, power


def test_forces_powers_and_bends_are_those_of_the_definition():
    record = table()
    found, power = forces(record)
    by_hand, lost, bends = expected(X, V, BRAKE, STIFFNESS)
    # Sums of some terms of either sign.
    assert found == pytest.approx(by_hand, abs=1e-14 * np.abs(by_hand).max())
    assert power == pytest.approx([0.0, lost], rel=1e-13)
    assert record.bends.tolist() == [bends, bends, bends]


def test_parts_and_lanes_have_the_same_bits():
    whole, power = forces(table())
    for count in (2, 3, 20):
        groups = table().in_parts(count)
        assert [len(each) for each in groups] == [count, 1]
        found = forces(*(record for group in groups for record in group))
        assert np.array_equal(found[0], whole) and np.array_equal(found[1], power)
    found = forces(table(), lanes=1)
    assert np.array_equal(found[0], whole) and np.array_equal(found[1], power)


def test_both_directions_are_those_of_differences():
    ways = RANDOM.normal(size=(2, 3 * NODES, 3))
    numbers = RANDOM.normal(size=(GROUPS + ITEMS, 3))
    found, room = np.zeros(9 * NODES), np.zeros(3)
    moved = (np.ascontiguousarray(each).ravel() for each in (*ways, numbers))
    push = partial(push_kernel, pool=POOL, learnt=NUMBERS)
    run(push, table(), X.ravel(), V.ravel(), *moved, found, room)
    found = found.reshape(-1, 3)
    for m in range(3):
        dx, dv = (each[:, m].reshape(-1, 3) for each in ways)
        brake, stiffness = np.split(numbers[:, m], [GROUPS])
        ahead, behind = (
            expected(X + h * dx, V + h * dv, BRAKE + h * brake, STIFFNESS + h * stiffness)[0]
            for h in (STEP, -STEP)
        )
        slope = (ahead - behind) / (2.0 * STEP)
        # Rounding over the step, and its square.
        assert found[:, m] == pytest.approx(slope, abs=1e-8 * np.abs(slope).max())
    weight = RANDOM.normal(size=3 * NODES)
    by_x, by_v = np.zeros((2, 3 * NODES))
    by = np.zeros(GROUPS + ITEMS)
    pull = partial(pull_kernel, pool=POOL, learnt=NUMBERS)
    run(pull, table(), X.ravel(), V.ravel(), weight, by_x, by_v, by)
    assert by_x @ ways[0] + by_v @ ways[1] + by @ numbers == pytest.approx(
        weight @ found, rel=1e-12
    )
