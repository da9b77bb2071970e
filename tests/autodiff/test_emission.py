"""Compiled graphs: the numbers of NumPy, and the same bits in any number of lanes."""

import ctypes
import mmap
import sys
from functools import partial

import numpy as np
import pytest

from tests.autodiff.graphs import random_number
from tests.every import every
from tissuec.autodiff import Potential, cos, exp, log, maximum, minimum, sin, sqrt, where
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.calls import kernel_on
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops import items as loops
from tissuec.compiled.loops.tables import ItemTable, room_for
from tissuec.compiled.loops.tables import recorded as rows_of

CORNERS = 3
COUNTS = (0, 1, 7, 8, 9, 17)
LEARNT = {"stiffness": False, "weights": False}
NUMBERS = 3  # of an item: its stiffness, and two weights


def potential(x, v, p):
    """Return something without a meaning that uses all inputs and operations."""
    e, q = x[1] - x[0], x[2] - x[0]
    mixed = random_number([*e, *q, p.weights[0] / p.weights[1]], 7)
    rate = v[1][0] - v[0][0] + p.weights[1] * v[2][1]
    grown = exp(p.weights[0])  # known of an item, as is which side is chosen
    mixed = where(grown > 3.0, mixed, grown * mixed) ** 2
    return Potential(p.stiffness * mixed, exp(-p.stiffness) * x[0][2] ** 2 * rate**2)


ITEM = TracedItem(potential, CORNERS, {"stiffness": 1, "weights": 2})


def items(count, nodes=30):
    """Return the nodes and the numbers of some items, and a state of the nodes."""
    chance = np.random.default_rng(count)
    corners = chance.integers(nodes, size=(count, CORNERS))
    columns = chance.uniform(0.5, 2.0, size=(NUMBERS, count))
    return corners, columns, *chance.normal(size=(2, 3 * nodes))


def values_of(corners, columns, x, v):
    """Return the inputs of all items."""
    names = [str(each.operation.detail) for each in ITEM.numbers]
    found = dict(zip(names, columns, strict=True))
    for letter, vector in (("x", x), ("v", v)):
        for corner in range(CORNERS):
            for axis in range(3):
                found[f"{letter}.{corner}.{axis}"] = vector[3 * corners[:, corner] + axis]
    return found


def called(write, table, *vectors):
    """Run a loop that is given as a function of its name."""
    kernel_on(GeneratedKernel("tried", write), table, len(vectors))(0.0, *vectors)


def in_table(corners, columns, x, v):
    """Return a table, with the constants of the items behind their numbers."""
    constants = evaluate(ITEM.constants, values_of(corners, columns, x, v))
    return ItemTable.of(corners, np.vstack([columns, *constants]))


LOOPS = {
    "forces": (partial(loops.force_loop, item=ITEM), (90, 2)),
    "pull": (partial(loops.pull_loop, item=ITEM, learnt=LEARNT), (90, 90, 3 * NUMBERS * 17)),
}  # fmt: skip


def all_of(name, lanes, count):
    """Return all that a loop adds up."""
    write, sizes = LOOPS[name]
    corners, columns, x, v = items(count)
    weight = () if name == "forces" else (np.random.default_rng(1).normal(size=x.size),)
    found = [np.zeros(size) for size in sizes]
    table = in_table(corners, columns, x, v)
    called(partial(write, lanes=lanes), table, x, v, *weight, *found)
    return np.concatenate(found)


@every(("name", "count"), [(name, count) for name in LOOPS for count in COUNTS])
def test_any_number_of_lanes_gives_the_same_bits(name, count):
    eight, four, one = (all_of(name, lanes, count) for lanes in (8, 4, 1))
    assert eight.tobytes() == four.tobytes() == one.tobytes()
    assert eight.any() == (count > 0)


@every("count", COUNTS)
def test_forces_and_powers_are_those_of_numpy(count):
    corners, _, x, _ = state = items(count)
    *forces, power = evaluate([*ITEM.forces, ITEM.power], values_of(*state))
    total, lost = np.zeros((x.size // 3, 3)), np.sum(power)
    for corner in range(CORNERS):
        np.add.at(total, corners[:, corner], np.array(forces[3 * corner :][:3]).T)
    found = all_of("forces", 8, count)
    scale = np.abs(forces).max(initial=0.0)
    # Fused operations round less often.
    assert found[:90] == pytest.approx(total.ravel(), abs=1e-13 * scale)
    assert found[90:] == pytest.approx([0.0, lost], rel=1e-13)


@every("count", COUNTS)
def test_pulls_and_pushes_are_transposes(count):
    state, changes = items(count), 11
    table, chance = in_table(*state), np.random.default_rng(2)
    _, _, x, v = state
    sizes = x.size, x.size, NUMBERS * count
    weight, moved = (
        chance.normal(size=x.size),
        [chance.normal(size=(n, changes)) for n in sizes],
    )
    by, df = [np.zeros(n) for n in sizes], np.zeros((x.size, changes))
    called(partial(loops.pull_loop, item=ITEM, learnt=LEARNT), table, x, v, weight, *by)
    push = partial(loops.push_loop, item=ITEM, learnt=LEARNT)
    given = [each.ravel() for each in (*moved, df)]
    called(push, table, x, v, *given, np.zeros(changes))
    one = sum(slope @ change for slope, change in zip(by, moved, strict=True))
    other = weight @ given[-1].reshape(df.shape)
    assert one == pytest.approx(other, abs=1e-12 * max(1.0, np.abs(one).max()))


# --- single operations ------------------------------------------------------------------------

PAIR = TracedItem(lambda x, v, p: p.a, 1, {"a": 1, "b": 1})
A, B = PAIR.numbers
FUNCTIONS = {
    "exp": exp(A), "log": log(A), "sin": sin(A), "cos": cos(A), "pow": A**B, "sqrt": sqrt(A),
    "sum": A + B, "product": A * B, "quotient": A / B, "fused": A * B + A, "less": B - A * B,
    "maximum": maximum(A, B), "minimum": minimum(A, B), "where": where(A > B, A, -B),
}  # fmt: skip
SPECIAL = np.array([
    0.0, -0.0, 1.0, -1.0, 0.5, 2.0, -3.0, 3.0, np.pi, 1e-8, -1e-8, 5e-324, -5e-324, 2.0**-1022,
    1e-310, 707.9, 708.1, -708.1, 709.9, 710.1, -745.2, -746.5, 2.0**20, 2.0**20 + 0.5, -1e9,
    1e300, -1e300, np.inf, -np.inf, np.nan, 1.0 + 2.0**-52, 1.0 - 2.0**-53,
])  # fmt: skip
ROWS = np.array(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1)
#: What NumPy's and our own exp, sin, … may differ by, relative to the result.
LAST_PLACE = 4e-16


def recorded(lanes):
    """Return the results of all functions of all pairs of special numbers."""
    count, none = ROWS.shape[1], np.zeros(3)
    outputs, room = list(FUNCTIONS.values()), room_for(len(FUNCTIONS), count)
    write = partial(loops.record_loop, item=PAIR, outputs=outputs, constants=[], lanes=lanes)
    table = ItemTable.of(np.zeros((count, 1), dtype=int), ROWS)
    called(write, table, none, none, room.reshape(-1))
    return rows_of(room, count)


def test_functions_of_special_numbers_have_the_same_bits_in_lanes():
    one, eight = recorded(1), recorded(8)
    assert np.array_equal(np.isnan(one), np.isnan(eight))
    same = one.view(np.int64) == eight.view(np.int64)
    assert (same | np.isnan(one)).all()


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:overflow")
def test_functions_of_special_numbers_are_those_of_numpy():
    (a, b), found = ROWS, recorded(8)
    expected = evaluate(list(FUNCTIONS.values()), {"p.a.0": a, "p.b.0": b})
    #: Where we say less than C, or round otherwise.
    apart = {
        "pow": (a == -np.inf) | (np.abs(a) == 1.0) & ~np.isfinite(b),
        "sin": np.abs(a) > 2.0**20,  # reduced by a rounded 2 π
        "cos": np.abs(a) > 2.0**20,
        # Rounded once, so that products may be beyond all numbers.
        **dict.fromkeys(("fused", "less"), ~np.isfinite(a * b)),
    }
    for name, own, due in zip(FUNCTIONS, found.T, expected, strict=True):
        units = 40.0 if name == "pow" else 1.0  # in the last place; see ``mathematics``
        near = np.abs(own - due) <= units * (LAST_PLACE * np.abs(due) + 5e-324)
        equal = near | (own == due) | np.isnan(own) & np.isnan(due)
        wrong = ~equal & ~apart.get(name, np.zeros(len(a), dtype=bool))
        assert not wrong.any(), (name, ROWS[:, wrong].T, own[wrong], due[wrong])


# --- memory -----------------------------------------------------------------------------------


def at_the_end_of_memory(values):
    """Return a copy behind which nothing can be read or written."""
    libc, page = ctypes.CDLL(None), mmap.PAGESIZE
    size = -(-values.nbytes // page) * page
    memory = mmap.mmap(-1, size + page)
    start = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    assert libc.mprotect(ctypes.c_void_p(start + size), page, 0) == 0
    found = np.frombuffer(memory, dtype=float)[(size - values.nbytes) // 8 : size // 8]
    found[:] = values
    return found


@pytest.mark.skipif(sys.platform == "win32", reason="pages are protected as on POSIX")
@every(("name", "lanes"), [(name, lanes) for name in LOOPS for lanes in (1, 4, 8)])
def test_nothing_behind_vectors_is_read_or_written(name, lanes):
    write, sizes = LOOPS[name]
    corners, columns, x, v = items(9)
    corners[-1] = 29  # the last node
    table, vectors = in_table(corners, columns, x, v), [x, v]
    if name != "forces":
        vectors.append(v)
    vectors += [np.zeros(min(size, NUMBERS * 9 if size > 90 else size)) for size in sizes]
    called(partial(write, lanes=lanes), table, *map(at_the_end_of_memory, vectors))


def test_what_is_added_up_leaves_other_nodes_as_they_are():
    corners, columns, x, v = items(9)
    corners = 2 * (corners // 2)  # even nodes
    table, forces, power = in_table(corners, columns, x, v), np.full(90, np.nan), np.zeros(2)
    forces.reshape(-1, 3)[::2] = 0.0
    x.reshape(-1, 3)[1::2] = v.reshape(-1, 3)[1::2] = np.nan
    called(LOOPS["forces"][0], table, x, v, forces, power)
    assert np.isfinite(forces.reshape(-1, 3)[::2]).all() and np.isfinite(power).all()
    assert np.isnan(forces.reshape(-1, 3)[1::2]).all()
