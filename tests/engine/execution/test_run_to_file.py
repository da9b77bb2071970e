"""Result files of runs hold what was computed, also after an interruption."""

import numpy as np
import pytest

from tests.hand_net import make_net
from tests.hand_plan import carry_out, event, expect, log, make_plan, subject, value, when
from tissuec.engine.execution.recorder import Recorder, wishes
from tissuec.engine.execution.run import run
from tissuec.results.frames import MOST_EVENTS
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter


@pytest.fixture
def scene():
    random = np.random.default_rng(2)
    ends = [(a, b) for a in range(6) for b in range(a)]
    network = make_net(random.normal(size=(6, 3)), ends, stiffness=50.0, damping=0.2, rest=1.4)
    groups = {"a": [0, 1], "springs": list(range(15))}
    here = value("position", subject("a", [0, 1]))
    events = [
        event(0.1, "move a", groups, duration=0.6, by=(1, 0, 0), using="smooth profile"),
        event(0.5, "cut springs", {"springs": [2, 9]}),
    ]
    plan = make_plan(
        network,
        1.0,
        events,
        every=0.02,
        energy=0.05,
        triggers=[when(lambda m: here(m) > 0.9, event(0.2, "cut springs", {"springs": [7]}))],
        logs=[log("force", subject("a", [0, 1]), every=0.01), log("energy drift", every=0.1)],
        expectations=[expect(lambda m: here(m) > m.pinned[0.1].time, 0.9, pinned=(0.1,))],
    )
    return network, plan


def write(path, network, plan, **options):
    with ResultWriter(path, network, wishes(network, plan), {}, "scene") as writer:
        outcome = run(network, plan, Recorder(network, plan, writer), **options)
        return writer.close(outcome.message, outcome.kind == "done")


def rows_of(path):
    """Return everything in a file that depends on the profile of the run."""
    with Trajectory(path) as file:
        vectors = [file.position[:], file.velocity[:], file.force[:]]
        logs = [
            part
            for log in (*file.logs.values(), file.energies)
            for part in (log.time, log.value, *log.jumps)
        ]
        springs = [
            part for frame in range(len(file.times)) for part in file.spring_force(frame)
        ]
        beside, count = file.sides, len(file.sides)
        sides = [beside.times, beside.position[:], beside.velocity[:]]
        sides += [one[:] for one in beside.fields.values()]
        sides += [beside.alive(n) for n in range(count)]
        return [file.times, *vectors, *logs, *springs, *sides], file.events


def test_a_file_holds_what_a_recording_in_memory_holds(scene, tmp_path):
    network, plan = scene
    path = write(tmp_path / "run.vtkhdf", network, plan)
    outcome, memory = carry_out(network, plan)
    time, position, velocity, force, tension, alive = memory.frame_arrays()
    with Trajectory(path) as file:
        assert file.finished
        assert file.outcome == outcome.message
        assert np.array_equal(file.times, time)
        for stored, computed in (
            (file.position, position),
            (file.velocity, velocity),
            (file.force, force),
        ):
            assert np.array_equal(stored[:], computed)
        for frame in range(len(time)):
            pulled, springs = file.spring_force(frame)
            assert springs.tolist() == np.flatnonzero(alive[frame]).tolist()
            assert np.array_equal(pulled, tension[frame, springs])
        assert np.array_equal(file.logs["force of a"].value, memory.log_arrays("force of a")[1])
        assert file.logs["force of a"].columns == ("x", "y", "z")
        assert file.logs["force of a"].unit == "N"
        assert file.energies is not None
        assert np.array_equal(file.energies.value, memory.energy_arrays()[1])
        for name, log in (*file.logs.items(), ("energies", file.energies)):
            if not name.startswith("energy drift"):  # it jumps by rounding errors alone
                assert len(log.jumps.time) >= (3 if name == "force of a" else 2)
            elif not len(log.jumps.time):
                with pytest.raises(KeyError):
                    memory.jump_arrays(name)
                continue
            for stored, computed in zip(log.jumps, memory.jump_arrays(name), strict=True):
                assert np.array_equal(stored, computed)
        assert file.events == tuple(memory.events)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_a_file_resumed_after_an_interruption_is_that_of_an_undisturbed_run(
    scene, tmp_path, count
):
    network, plan = scene
    asked = iter(range(1000))
    whole = write(tmp_path / "whole.vtkhdf", network, plan)
    partial = write(
        tmp_path / "run.vtkhdf", network, plan, interrupt=lambda: next(asked) >= count
    )
    with Trajectory(partial) as file:
        assert not file.finished
        assert "can be resumed" in file.outcome
        checkpoint = file.checkpoint()
    with ResultWriter.resume(partial, checkpoint) as writer:
        recorder = Recorder(network, plan, writer)
        outcome = run(network, plan, recorder, resume=checkpoint.state)
        path = writer.close(outcome.message, outcome.kind == "done")
    rows, events = rows_of(whole)
    resumed, resumed_events = rows_of(path)
    assert events == resumed_events
    for one, other in zip(rows, resumed, strict=True):
        assert np.array_equal(one, other)


def test_a_file_holds_the_net_on_both_sides_of_each_event(scene, tmp_path):
    network, plan = scene
    with Trajectory(write(tmp_path / "run.vtkhdf", network, plan)) as file:
        sides = file.sides
        happened = sorted({event.time for event in file.events if event.time > 0.0})
        assert sides.times[::2].tolist() == sides.times[1::2].tolist() == happened
        # Nodes do not jump; those that are moved from now on are set to their path.
        assert sides.position[::2] == pytest.approx(sides.position[1::2], abs=1e-12)
        cut = 2 * happened.index(0.5)
        assert np.flatnonzero(sides.alive(cut) & ~sides.alive(cut + 1)).tolist() == [2, 9]
        tension, force = sides.fields["tension"], sides.fields["force"]
        assert tension[cut][[2, 9]].all() and not tension[cut + 1][[2, 9]].any()
        for side in (cut, cut + 1):  # what pulls at the nodes is what the springs bear
            way = np.diff(sides.position[side][network.springs.ends], axis=1)[:, 0]
            pull = way * (tension[side] / np.linalg.norm(way, axis=1))[:, None]
            total = np.zeros_like(force[side])
            np.add.at(total, network.springs.ends[:, 0], pull)
            np.add.at(total, network.springs.ends[:, 1], -pull)
            assert force[side] == pytest.approx(total, abs=1e-12 * np.abs(pull).max())


def test_a_file_holds_no_more_than_the_first_sides(scene, tmp_path):
    network, plan = scene
    many = [
        event(0.01 + 0.005 * n, f"{verb} a", {"a": [0]})
        for n, verb in enumerate(50 * ("fix", "free"))
    ]
    plan = make_plan(network, 1.0, many, every=0.1)
    with Trajectory(write(tmp_path / "run.vtkhdf", network, plan)) as file:
        assert len(file.sides) == 2 * MOST_EVENTS and len(file.times) == 11


def test_a_run_without_events_or_frames_writes_no_sides(scene, tmp_path):
    network, _ = scene
    events = [event(0.5, "cut springs", {"springs": [2, 9]})]
    for stem, plan in (
        ("still", make_plan(network, 1.0, every=0.1)),
        ("logs", make_plan(network, 1.0, events, logs=[log("energy drift", every=0.1)])),
    ):
        with Trajectory(write(tmp_path / f"{stem}.vtkhdf", network, plan)) as file:
            assert len(file.sides) == 0 and "tissuec/sides" not in file._file
