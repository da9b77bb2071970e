"""Times of samples and of actions, where rounding makes one time look like two."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.hand_net import chain, event_action, start
from tests.hand_plan import carry_out, event, log, make_plan, subject
from tissuec.engine.execution import recorder as recording_module
from tissuec.engine.execution.event_queue import ActionQueue, join_times, rows_at, rows_within
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder, wishes
from tissuec.engine.method import Samples
from tissuec.script.measures.snapshot import EnergyBalance
from tissuec.script.plan import RELAXATION, ScheduledAction

NEAR = 1e-12


def test_times_that_differ_by_rounding_are_one_time():
    joined = join_times(np.array([0.3, 0.1 + 0.2, 0.5, 0.2]), np.zeros(0), NEAR)
    assert joined.tolist() == [0.2, 0.3, 0.5]


def test_a_time_near_an_event_is_the_time_of_the_event():
    joined = join_times(np.array([0.3, 0.6]), np.array([0.1 + 0.2, 0.5]), NEAR)
    assert joined.tolist() == [0.1 + 0.2, 0.6]


@given(st.lists(st.tuples(st.integers(0, 50), st.sampled_from([0, -1, 1])), max_size=30))
def test_every_wanted_time_is_found_again_and_no_other(wanted):
    # Times on a grid of 0.01 s, each up to one unit of rounding off.
    times = np.array(
        [np.nextafter(k * 0.01, k * 0.01 + d) if d else k * 0.01 for k, d in wanted]
    )
    grid = np.arange(0, 51, 5) * 0.01
    joined = join_times(np.concatenate([times, grid]), np.array([0.25, 0.1 + 0.2]), NEAR)
    assert (np.diff(joined) > NEAR).all()
    chosen = rows_at(joined, times, NEAR)
    assert np.round(joined[chosen] / 0.01).tolist() == sorted({k for k, _ in wanted})


def test_intervals_include_their_ends_whatever_rounding_does():
    times = np.array([0.1, 0.2, 0.30000000000000004, 0.4])
    assert rows_within(times, 0.2, 0.3, NEAR).tolist() == [False, True, True, False]


def test_rows_for_nothing_are_none():
    assert not len(join_times(np.zeros(0), np.array([0.1]), NEAR))
    assert not rows_at(np.array([1.0]), np.zeros(0), NEAR).any()


def test_an_agenda_keeps_time_then_ends_before_script_then_written_order():
    queue = ActionQueue(NEAR, written=[0.3, 0.3, 0.7])
    actions = {
        name: event_action(name) for name in ("first", "second", "later", "end", "extra")
    }
    queue.follow([ScheduledAction(0.7, actions["later"])], 0.0)
    queue.follow(
        [ScheduledAction(0.3, actions["first"]), ScheduledAction(0.3, actions["second"])], 0.0
    )
    queue.add(0.1 + 0.2, actions["end"])
    assert queue.next == 0.3
    carried_out = []
    for action in queue.due(0.3):
        carried_out.append(action)
        if action is actions["first"]:
            queue.add(0.3, actions["extra"])
    assert carried_out == [actions[name] for name in ("end", "first", "extra", "second")]
    queue.land(np.array([0.5, 0.1]))
    assert queue.next == 0.1
    assert list(queue.due(0.5)) == []
    assert queue.next == 0.7
    assert list(queue.due(1.0)) == [actions["later"]]
    assert queue.next == np.inf


def test_what_a_result_file_must_have_room_for_follows_from_the_plan():
    network = chain(3)
    plan = make_plan(
        network,
        1.0,
        energy=0.1,
        every=0.1,
        logs=[
            log("tension", subject("net", [], [0, 1]), every=0.1),
            log("gap", subject("net", [0, 1]), every=0.1),
        ],
    )
    wanted = wishes(network, plan)
    assert wanted.nodes.tolist() == [0, 1, 2]
    assert wanted.lines.tolist() == [0, 1]
    assert wanted.energies
    assert not wanted.single
    assert [(c.name, c.columns, c.unit) for c in wanted.logs] == [
        ("tension of net", ("spring 500", "spring 501"), "N"),
        ("gap of net", ("value",), "m"),
    ]
    assert wanted.logs[1].description.startswith("The smallest distance")


def test_a_recorder_asks_only_for_times_that_somebody_wants():
    network = chain(2)
    plan = make_plan(
        network, 1.0, every=0.5, logs=[log("speed", subject("net", [0]), every=0.4)]
    )
    times = Recorder(network, plan, MemoryRecording()).times
    assert times == pytest.approx([0.0, 0.4, 0.5, 0.8, 1.0])


def test_the_balance_is_judged_by_the_largest_energy_of_all_batches_so_far():
    network = chain(1, mass=2.0)
    plan = make_plan(network, 1.0, logs=[log("energy drift", every=0.5)])
    recording = MemoryRecording()
    recorder = Recorder(network, plan, recording)
    recorder.enter(start(network), np.zeros(0, dtype=bool), EnergyBalance())
    none = np.zeros(1)
    for time, speed in ((0.0, 1.0), (0.5, 10.0), (1.0, 1.0)):
        velocity = np.array([[[speed, 0.0, 0.0]]])
        recorder.record(Samples(np.array([time]), np.zeros((1, 1, 3)), velocity, *[none] * 4))
    # All of the energy, 1, 100 and 1 J, is unaccounted for.
    drifts = recording.log_arrays("energy drift of ")[1]
    assert drifts[:, 0].tolist() == [1.0, 1.0, 0.01]


def cut_at(time, **given):
    """Carry out a run of 1 kg on a spring of 9 N/m, stretched by 0.2 m, that is cut at a time.

    The force on the support is -1.8 N cos(3 t), and nothing afterwards.
    """
    network = chain(2, stiffness=9.0, rest=0.8)
    groups = {"left": [0], "net": [0]}
    events = [event(0.0, "fix left", groups), event(time, "cut net", groups)]
    _, recording = carry_out(network, make_plan(network, 1.0, events, every=0.25, **given))
    return recording


def watched(every=0.1):
    return {
        "energy": every,
        "logs": [
            log("force", subject("left", [0]), every=every),
            log("position", subject("right", [1]), every=every),
        ],
    }


@pytest.mark.parametrize("time", [0.37, 0.4, 1.0])
def test_an_event_that_changes_a_log_leaves_its_times_and_is_kept_beside_them(time):
    recording = cut_at(time, **watched())
    times, force = recording.log_arrays("force of left")
    grid = np.linspace(0.0, 1.0, 11)
    assert times == pytest.approx(grid)
    is_whole = grid < time - 1e-9
    # The tolerance of a run promises positions to 1e-9 of displacements below 1 m.
    assert force[is_whole, 0] == pytest.approx(-1.8 * np.cos(3.0 * grid[is_whole]), abs=9e-9)
    assert not force[~is_whole].any()
    times, before, after = recording.jump_arrays("force of left")
    assert times.tolist() == [time]
    assert before[0] == pytest.approx([-1.8 * np.cos(3.0 * time), 0.0, 0.0], abs=9e-9)
    assert after.tolist() == [[0.0, 0.0, 0.0]]


def test_energies_jump_by_what_the_event_is_booked_with():
    times, before, after = cut_at(0.37, **watched()).jump_arrays("energies")
    assert times.tolist() == [0.37]
    kinetic, elastic, _, work, dissipated, switched = (after - before)[0].tolist()
    assert (kinetic, work, dissipated) == (0.0, 0.0, 0.0)
    # Energies are sums over springs, which two modules group in their own ways.
    assert [elastic, switched] == pytest.approx([-before[0, 1]] * 2, rel=1e-14)
    assert before[0, 1] == pytest.approx(0.18 * np.cos(3.0 * 0.37) ** 2, abs=1e-8)


def test_what_an_event_leaves_as_it_is_does_not_jump():
    with pytest.raises(KeyError):
        cut_at(0.37, **watched()).jump_arrays("position of right")


def test_two_changes_at_one_time_are_one_jump():
    network = chain(2, stiffness=9.0, rest=0.8)
    groups = {"left": [0], "net": [0]}
    events = [
        event(0.0, "fix left", groups),
        event(0.5, "change spring constant", groups, of="net", to=18.0),
        event(0.5, "cut net", groups),
    ]
    _, recording = carry_out(network, make_plan(network, 1.0, events, **watched()))
    times, _, after = recording.jump_arrays("force of left")
    assert times.tolist() == [0.5]
    assert not after.any()


def test_a_net_without_inertia_jumps_to_where_it_is_relaxed_again():
    """Two springs in a row are stretched by 0.6 m; the first one is halved in stiffness."""
    network = chain(3, stiffness=9.0, rest=0.7)
    groups = {"ends": [0, 2], "first": [0]}
    events = [
        event(0.0, "fix ends", groups),
        event(0.37, "change spring constant", groups, of="first", to=4.5),
    ]
    given = watched() | {"integrator": RELAXATION, "step": 0.05, "every": 0.25}
    _, recording = carry_out(network, make_plan(network, 1.0, events, **given))
    times, before, after = recording.jump_arrays("force of left")
    assert times.tolist() == [0.37]
    assert before[0, 0] == pytest.approx(-0.6 * 4.5)
    assert after[0, 0] == pytest.approx(-0.6 * 3.0)
    assert np.array_equal(after[0], recording.log_arrays("force of left")[1][4])


def test_jumps_of_wide_logs_are_not_kept(monkeypatch):
    monkeypatch.setattr(recording_module, "MOST_JUMPING", 2)
    with pytest.raises(KeyError):
        cut_at(0.37, **watched()).jump_arrays("force of left")


@pytest.mark.parametrize("integrator", ["dop853", "esdirk43", RELAXATION])
def test_jumps_leave_the_motion_as_it_is(integrator):
    options = {"integrator": integrator, "step": 0.05 if integrator == RELAXATION else None}
    plain, kept = (cut_at(0.37, **given, **options).frame_arrays() for given in ({}, watched()))
    for one, other in zip(plain, kept, strict=True):
        assert np.array_equal(one, other)


def test_a_rupture_jumps_from_the_force_that_the_spring_bears():
    """The mass flies off at 0.6 m/s: a force of 1.8 N sin(3 t) reaches 0.9 N at pi / 18 s."""
    network = chain(2, stiffness=9.0, strength=0.9, velocity=(0.6, 0.0, 0.0))
    events = [event(0.0, "fix left", {"left": [0]})]
    _, recording = carry_out(network, make_plan(network, 1.0, events, **watched()))
    times, before, after = recording.jump_arrays("force of left")
    assert times == pytest.approx([np.pi / 18.0], abs=1e-8)
    assert before[0, 0] == pytest.approx(-0.9, abs=1e-9)
    assert not after.any()


def test_settling_jumps_to_the_equilibrium():
    network = chain(2, stiffness=9.0, rest=0.8)
    groups = {"left": [0], "right": [1]}
    events = [event(0.0, "fix left", groups), event(0.37, "settle right", groups)]
    _, recording = carry_out(network, make_plan(network, 1.0, events, **watched()))
    times, before, after = recording.jump_arrays("position of right")
    assert times.tolist() == [0.37]
    assert before[0, 0] == pytest.approx(0.8 + 0.2 * np.cos(3.0 * 0.37), abs=1e-8)
    assert after[0, 0] == pytest.approx(0.8, abs=1e-8)
