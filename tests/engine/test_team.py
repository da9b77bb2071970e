"""Threads that share the loops of a run change nothing but the time that it takes."""

import gc
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.spatial import KDTree

import tissuec
from tests.hand_net import make_net
from tests.validate.scenes import compiled_scene
from tissuec.core.workers import workers
from tissuec.engine import spring_runs, threads
from tissuec.engine.engine import Engine
from tissuec.engine.execution.companion import threads_beside
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Method
from tissuec.engine.threads import PARTS, ThreadTeam, useful
from tissuec.mechanics.state import State

#: Enough nodes for five blocks of springs in runs.
SCENE = """language 1
tissue flesh {
  spring constant = 500 N/m; viscosity = 10 mN*s/m; mass = 1 g; breaking force = 1 kN
}
body block {
  mesh is lattice {
    kind is sodium chloride; cell = 1 cm; box from (0, 0, 0) cm to (16, 16, 16) cm
  }
  tissue is flesh
}
environment { gravity = (0, 0, 0) m/s^2; contact is off }
simulate { duration = 1 s }
"""
METHODS = {
    "velocity verlet": 1e-4,
    "rkn4": 1e-4,
    "dop853": 5e-4,
    "rkc2": 5e-4,
    "esdirk43": 2e-3,
}


@pytest.fixture(scope="module")
def block():
    return compiled_scene(SCENE).network


@pytest.fixture(scope="module")
def heap():
    """Return nodes in no order, which springs join to their nearest neighbours."""
    rng = np.random.default_rng(7)
    grid = 0.01 * np.mgrid[:14, :14, :14].reshape(3, -1).T
    places = rng.permutation(grid + rng.uniform(-0.002, 0.002, grid.shape))
    pairs = KDTree(places).query_pairs(0.0125, output_type="ndarray")
    return make_net(
        places,
        pairs,
        mass=1e-3,
        stiffness=rng.uniform(100.0, 500.0, len(pairs)),
        damping=0.01,
        rest=np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1),
        strength=np.full(len(pairs), 1e3),
    )


def shaken(network, name, threads, *, steps=3):
    """Return all numbers of a run from random velocities, and its engine."""
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    state.velocity[:] = np.random.default_rng(5).normal(0.0, 0.1, state.velocity.shape)
    step, found = METHODS[name], []
    method = Method(name, 1e-6, step, 1.0, ledger=True, watch_strength=True, threads=threads)
    times = step * np.arange(steps + 1)

    def record(samples):
        found.extend(np.array(column) for column in samples)

    engine = Engine(network, method, times, record)
    assert engine.advance(state, steps * step).kind == "reached"
    engine.finish(state)
    return [*found, state.position, state.velocity], engine


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize(("net", "blocks"), [("block", 2), ("block", 1), ("heap", 1)])
def test_every_number_is_the_same_to_the_last_bit(
    net, blocks, name, threads_in_small_nets, request, monkeypatch
):
    network = request.getfixturevalue(net)
    # Of a group: with few, threads share the springs in runs, too.
    monkeypatch.setattr(spring_runs, "LEAST_OF_GROUP", blocks)
    expected, engine = shaken(network, name, 1)
    assert engine.statistics.threads == 1
    for number in (2, 5):
        found, engine = shaken(network, name, number)
        assert engine.statistics.threads == number
        for one, other in zip(found, expected, strict=True):
            assert np.array_equal(one, other)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_springs_in_runs_have_tiles_for_every_part(block, threads, monkeypatch):
    monkeypatch.setattr(spring_runs, "LEAST_OF_GROUP", 1)
    inputs = KernelInputs(block, watched=False, ledger=False)
    inputs.team = ThreadTeam(threads, block.node_count)
    inputs.update(State.start(block, gravity=np.zeros(3), drag=0.0))
    runs = inputs.net(INTEGRATORS["dop853"]).runs
    groups = len(runs.group) - 1
    assert groups > 1
    assert len(runs.tiles) == min(inputs.team.parts, groups) * runs.ring


def test_two_runs_at_a_time_have_threads_of_their_own(block, threads_in_small_nets):
    expected, _ = shaken(block, "velocity verlet", 1, steps=40)
    with ThreadPoolExecutor(2) as pool:
        runs = [pool.submit(shaken, block, "velocity verlet", 2, steps=40) for _ in range(2)]
        for run in runs:
            for one, other in zip(run.result()[0], expected, strict=True):
                assert np.array_equal(one, other)


def test_a_net_of_one_group_of_blocks_has_one_thread(block, monkeypatch):
    """A second thread would have no springs to compute."""
    monkeypatch.setattr(threads, "LEAST_SPRINGS", 1)
    for blocks, expected in ((spring_runs.LEAST_OF_GROUP, 1), (1, 2)):
        monkeypatch.setattr(spring_runs, "LEAST_OF_GROUP", blocks)
        assert shaken(block, "velocity verlet", 2)[1].statistics.threads == expected


def test_threads_end_with_the_run(block, threads_in_small_nets):
    before = set(threading.enumerate())
    _, engine = shaken(block, "velocity verlet", 3)
    own = set(threading.enumerate()) - before
    assert len(own) == 2
    del engine
    gc.collect()
    for thread in own:
        thread.join(10.0)
        assert not thread.is_alive()


def test_a_scene_runs_the_same_on_any_number_of_threads(threads_in_small_nets):
    """The companion, which runs in the same threads, included."""
    scene = SCENE.replace("duration = 1 s", "duration = 10 ms").replace(
        "gravity = (0, 0, 0)", "gravity = (0, 0, -9.81)"
    )
    scene += """set floor = nodes of block where z < 1 mm
    script { at 0 s: fix floor }
    output { trajectory every 2 ms }
    """
    runs = [tissuec.run(scene, threads=count, companion="inline") for count in (1, 2)]
    assert [run.manifest["statistics"]["threads"] for run in runs] == [1, 2]
    one, other = (run.position[:] for run in runs)
    assert one.any() and np.array_equal(one, other)
    assert runs[0].promise.error == runs[1].promise.error


def test_small_nets_keep_no_thread_busy():
    assert useful(8, 2 * threads.LEAST_SPRINGS - 1) == 1
    assert useful(8, 3 * threads.LEAST_SPRINGS) == 3
    assert useful(2, 100 * threads.LEAST_SPRINGS) == 2


def test_loops_have_a_part_for_every_thread_that_is_held_up():
    for number, parts in ((1, 1), (3, 3 * PARTS)):
        team = ThreadTeam(number, 10)
        assert team.parts == team.record.found.shape[1] == len(team.record.each) == parts


@pytest.mark.parametrize(
    ("mode", "threads"), [("off", 6), ("inline", 6), ("auto", 3), ("process", 3)]
)
def test_a_companion_beside_the_run_gets_half_of_the_processors(mode, threads, monkeypatch):
    monkeypatch.setattr("tissuec.engine.execution.companion.permitted", lambda: 6)
    assert threads_beside(mode) == threads
    monkeypatch.setattr("tissuec.engine.execution.companion.permitted", lambda: 1)
    assert threads_beside(mode) == 1


def test_at_least_one_processor_is_permitted():
    assert workers.permitted() >= 1
