"""Springs in runs pull like springs one by one, whatever the net."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from tests.engine.running import Bench, block
from tissuec.engine import spring_runs
from tissuec.engine.spring_runs import FAR, packed, places_of
from tissuec.engine.threads import BLOCK_NODES, ThreadTeam, chunks_of
from tissuec.forces import accelerations
from tissuec.forces.springs import runs_kernel as kernel
from tissuec.forces.springs import springs_kernel
from tissuec.kernels.records import Operations

EPS = np.finfo(float).eps
SPRING = ("stiffness", "damping", "rest", "near", "near_crush")


def lattice(sides, rng):
    """Return the springs of a lattice with first and some second neighbours, some left out."""
    number = np.arange(np.prod(sides)).reshape(sides)
    pairs = []
    for step in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (0, 1, 1)):
        low = number[tuple(slice(0, n - d) for n, d in zip(sides, step, strict=True))]
        high = number[tuple(slice(d, n) for n, d in zip(sides, step, strict=True))]
        pairs.append(np.stack([low.ravel(), high.ravel()], axis=1))
    pairs = np.concatenate(pairs)
    return pairs[rng.uniform(size=len(pairs)) > 0.1], number.size


def any_net(nodes, count, rng):
    """Return springs between any nodes, some of them twice."""
    low = rng.integers(0, nodes - 1, count)
    return np.stack([low, rng.integers(low + 1, nodes)], axis=1), nodes


def nets():
    rng = np.random.default_rng(8)
    yield "lattice", lattice((7, 5, 4), rng)
    yield "blocks", lattice((30, 20, 9), rng)
    yield "long", lattice((2, 2, 1500), rng)
    yield "any", any_net(40, 300, rng)
    yield "one", (np.array([[0, 5]]), 6)
    yield "none", (np.zeros((0, 2), dtype=np.int64), 3)


NETS = dict(nets())
LARGE = ("blocks", "long")
#: How springs are alike: not at all, in what they pull with, and in their lengths as well.
ALIKE = ((False, False), (True, False), (True, True))


def cases():
    """Yield net, ledger, parts and alikeness: all with all, but each once in large nets."""
    for name in NETS:
        for number, alike in enumerate(ALIKE):
            for ledger, parts in product((False, True), (1, 3)):
                if name not in LARGE or (ledger + 2 * (parts > 1) + number) % 4 == 0:
                    yield name, ledger, parts, *alike


@pytest.mark.parametrize(("name", "ledger", "parts", "alike", "regular"), list(cases()))
def test_forces_losses_and_nearness_are_those_of_springs_one_by_one(
    name, ledger, parts, alike, regular, monkeypatch
):
    def share(team, function, arguments):
        for part in reversed(range(parts)):  # which part comes first does not matter
            function(part, parts, *arguments)

    monkeypatch.setattr(kernel, "share", share)
    monkeypatch.setattr(spring_runs, "LEAST_OF_GROUP", 1 if parts > 1 else 1000)
    monkeypatch.setattr(spring_runs, "MANY", 0)
    pairs, nodes = NETS[name]
    rng = np.random.default_rng(len(pairs))
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    low, high = pairs.T
    values = {each: rng.uniform(0.5, 2.0, len(low)) for each in SPRING}
    if alike:
        values["stiffness"][:], values["damping"][:] = 1.5, 0.7
    if regular:
        values["rest"][:] = 1.3 * (1.0 + EPS * rng.integers(-1000, 1000, len(low)))
    dead = rng.uniform(size=len(low)) < 0.1
    values["stiffness"][dead] = values["damping"][dead] = 0.0
    net = SimpleNamespace(
        first=np.searchsorted(low, np.arange(nodes + 1)).astype(np.uint64),
        other=(3 * high).astype(np.uint32),
        runs=packed(places_of(low, high), nodes, parts, **values),
        chunks=chunks_of(low, high, nodes),
        law=np.zeros(len(low), dtype=np.int32),
        ledger=ledger,
        inelastic=False,
        team=ThreadTeam(2, nodes).record,
        **values,
    )
    x, v = rng.normal(size=3 * nodes), rng.normal(size=3 * nodes)
    for far in (1e9, 1.0):  # from which tension on springs are watched
        for each in ("near", "near_crush"):
            values[each][:] = far
        net.runs = packed(places_of(low, high), nodes, parts, **values)
        assert net.runs.alike is (alike or len(low) < 2)
        if len(low) > 1:
            assert (len(net.runs.steps) > 0) is regular is (len(net.runs.rest) == 0)
        found, expected, powers = np.ones(3 * nodes), np.ones(3 * nodes), np.zeros((2, 2))
        near = kernel.springs_in_runs(x, v, found, powers[0], net)
        assert near == springs_kernel.springs(x, v, expected, powers[1], net)
        scale = np.abs(expected).max()
        assert found == pytest.approx(expected, abs=1e-13 * scale)
        if ledger:
            assert powers[0] == pytest.approx(powers[1], rel=1e-12)


@pytest.mark.parametrize("alike", [False, True])
def test_what_vector_instructions_read_begins_at_lines_of_the_cache(alike):
    places, count = places_of(*NETS["blocks"][0].T), len(NETS["blocks"][0])
    values = {each: np.linspace(1.0, 1.0 if alike else 2.0, count) for each in SPRING}
    kept = [packed(places, 10_000, 1, **values) for _ in range(5)]  # at different places
    for runs in kept:
        assert runs.alike is alike
        for each in (*SPRING, "tiles"):
            assert getattr(runs, each).ctypes.data % 64 == 0


def lengths_of(places, rest, stiffness=None):
    """Return the lengths in runs that the kernel reads, by their places."""
    values = {"rest": rest, "stiffness": np.ones_like(rest) if stiffness is None else stiffness}
    runs = packed(places, 10_000, 1, **values)
    if not len(runs.steps):
        return runs, runs.rest
    written = np.zeros(places.size)
    for at, count, base in zip(runs.at, runs.length, runs.base, strict=True):
        whole, number = np.uint64(at), np.uint64(count)
        kernel.write_lengths(whole, number, base, runs.steps, written[at : at + count])
    return runs, written


@pytest.mark.parametrize("size", [1e-3, 1.0, 1.0 - EPS, 4.0, 0.0])
def test_lengths_in_steps_are_exact(size, monkeypatch):
    """Also where they step over a power of two."""
    places, count = places_of(*NETS["blocks"][0].T), len(NETS["blocks"][0])
    rng = np.random.default_rng(2)
    rest = size * (1.0 + EPS * rng.integers(-9000, 9000, count))
    stiffness = np.where(rng.uniform(size=count) < 0.2, 0.0, 1.0)
    runs, whole = lengths_of(places, rest, stiffness)
    assert not len(runs.steps)  # as few as these stay in the cache
    monkeypatch.setattr(spring_runs, "MANY", 0)
    runs, written = lengths_of(places, rest, stiffness)
    assert len(runs.steps) == places.size and not len(runs.rest)
    assert np.array_equal(written, whole)


def test_lengths_that_differ_by_more_than_roundings_are_kept_whole(monkeypatch):
    monkeypatch.setattr(spring_runs, "MANY", 0)
    places, count = places_of(*NETS["blocks"][0].T), len(NETS["blocks"][0])
    rest = np.ones(count)
    assert len(lengths_of(places, rest)[0].steps)
    rest[count // 2] += 70_000 * EPS
    assert not len(lengths_of(places, rest)[0].steps)


@pytest.mark.parametrize("method", ["velocity verlet", "dop853"])
def test_a_run_is_the_same_to_the_last_bit_however_lengths_are_kept(method, monkeypatch):
    whole, steps = [], []
    for many, found in ((10**9, whole), (0, steps)):
        monkeypatch.setattr(spring_runs, "MANY", many)
        bench = Bench(block(9, spin=(3.0, 2.0, 1.0), damping=1e-3), 0.05, method=method)
        found.append(bench.run().position)
        runs = bench.engine.stepper.inputs.net(bench.engine.stepper.integrator).runs
        found.append(len(runs.steps))
    assert np.array_equal(whole[0], steps[0])
    assert steps[1] > 0 and whole[1] == 0


def test_lattices_lie_in_runs_and_other_nets_do_not():
    rng = np.random.default_rng(3)
    for (pairs, _), worthwhile in ((NETS["blocks"], True), (any_net(900, 4000, rng), False)):
        assert places_of(*pairs.T).is_worthwhile is worthwhile


def test_every_spring_has_a_place_of_its_own():
    for pairs, _ in NETS.values():
        places = places_of(*pairs.T)
        assert len(np.unique(places.place)) == len(pairs)
        assert places.size == places.length.sum()
        node = np.concatenate(
            [np.arange(n) + low for n, low in zip(places.length, places.first, strict=True)]
            or [np.zeros(0)]
        )
        assert np.array_equal(node[places.place], pairs[:, 0])


@pytest.mark.parametrize("name", NETS)
def test_runs_stay_in_tiles_and_springs_of_distant_nodes_have_none_in_common(name):
    pairs, nodes = NETS[name]
    places = places_of(*pairs.T)
    for of in (places.first, places.first + places.offset):
        # Those that fill up the length may lie behind the last node of a tile, in a row of it.
        assert (of % kernel.TILE + places.length <= kernel.ROW).all()
    assert (places.length % kernel.LANES == 0).all()
    far = places.offset >= FAR
    assert (places.length[far] <= places.offset[far]).all()
    ones = {each: np.ones(len(pairs)) for each in ("stiffness", "rest")}
    runs = packed(places, nodes, 1, **ones)
    apart = np.abs(runs.high - runs.low) >= runs.length
    assert apart[far].all()
    assert (apart | (places.offset < places.length)).all()


def test_every_other_block_has_no_node_in_common_with_the_next():
    pairs, _ = NETS["blocks"]
    places = places_of(*pairs.T)
    assert len(places.block) > 4 and places.block[-1] == len(places.first)
    ends = [
        (places.first[runs].min(), (places.first + places.offset + places.length)[runs].max())
        for runs in map(slice, places.block[:-1], places.block[1:])
    ]
    for (_, last), (first, _) in zip(ends, ends[2:], strict=False):
        assert last <= first
    assert max(last - first for first, last in ends) <= 2 * BLOCK_NODES


def test_a_long_spring_makes_one_block_of_all():
    pairs, nodes = NETS["blocks"]
    low, high = np.vstack([pairs, [[0, nodes - 1]]]).T
    assert len(places_of(low, high).block) == 2


def test_no_name_is_that_of_an_operation():
    """Where kernels run as plain Python, operations of a net are bound by their names."""
    own = {
        name
        for name, each in vars(kernel).items()
        if getattr(each, "__module__", "") == kernel.__name__
    }
    assert not own & {*Operations._fields, *dir(accelerations), *dir(springs_kernel)}
