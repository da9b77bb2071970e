"""The loop between events, against closed forms, conservation laws and itself."""

import signal
import threading

import numpy as np
import pytest

from tests.hand_net import chain, make_net
from tests.hand_plan import carry_out, event, expect, log, make_plan, subject, value, when
from tests.whole_runs import AfterAsking, every_array
from tissuec.core.signals import SIGNALS, Terminated, asked_to_stop, exit_code
from tissuec.core.structs import replace
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.script.procedures import PropagationChoices

# Two masses 1 and 3 kg on a spring of 12 N/m: reduced mass 3/4, ω = 4.
OMEGA = 4.0


def oscillator(**parameters):
    given = {"mass": [1.0, 3.0], "stiffness": 12.0, "rest": 0.8}
    return chain(2, **(given | parameters))


def drift(recording):
    """Return the largest error of the energy balance, relative to the largest energy."""
    _, rows = recording.energy_arrays()
    kinetic, elastic, gravity, work, dissipated, switched = rows.T
    balance = kinetic + elastic + gravity - work + dissipated - switched
    return np.abs(balance - balance[0]).max() / np.abs(rows).max()


def test_two_masses_swing_and_fly_apart_when_their_spring_is_cut():
    network = oscillator()
    cut = 0.5
    plan = make_plan(
        network, 1.0, [event(cut, "cut net", {"net": [0]})], every=0.05, energy=0.05
    )
    outcome, recording = carry_out(network, plan)
    time, position, velocity, _, tension, alive = recording.frame_arrays()
    assert outcome.kind == "done"
    stretch = 0.2 * np.cos(OMEGA * np.minimum(time, cut))
    rate = -0.2 * OMEGA * np.sin(OMEGA * np.minimum(time, cut))
    length = 0.8 + stretch + rate * np.maximum(time - cut, 0.0)
    # The tolerance is a promise for positions: 1e-9 of the largest displacement, below 1 m.
    assert position[:, 1, 0] - position[:, 0, 0] == pytest.approx(length, abs=1e-9)
    assert velocity[:, 1, 0] - velocity[:, 0, 0] == pytest.approx(rate, abs=1e-8)
    assert (alive[:, 0] == (time < cut)).all()
    assert (tension[time >= cut] == 0.0).all()
    assert drift(recording) < 1e-9
    assert [(t, h.kind, list(h.springs)) for t, h in outcome.logged_events] == [
        (cut, "cut", [0])
    ]
    assert [(e.time, e.kind, e.springs, e.place) for e in recording.events] == [
        (cut, "cut", (0,), "hand.tis:1")
    ]


def test_a_driven_end_forces_the_other_as_the_closed_form_says():
    network = chain(2, mass=[1.0, 2.0], stiffness=8.0)
    groups = {"left": [0]}
    drive = event(
        0.0, "move left", groups, duration=3.0, by=(0.3, 0, 0), using="constant speed"
    )
    plan = make_plan(
        network,
        3.0,
        [drive],
        every=0.1,
        energy=0.1,
        logs=[log("force", subject("left", [0]), every=0.1)],
    )
    _, recording = carry_out(network, plan)
    time, position, *_ = recording.frame_arrays()
    # x = v t - (v / ω) sin ω t behind a support at constant speed v, with ω = 2.
    moved = 0.1 * time - 0.05 * np.sin(2.0 * time)
    assert position[:, 1, 0] - 1.0 == pytest.approx(moved, abs=1e-9)
    _, force = recording.log_arrays("force of left")
    assert force[:, 0] == pytest.approx(-8.0 * (moved - 0.1 * time), abs=1e-8)
    assert drift(recording) < 1e-8


def test_a_node_released_on_its_way_flies_on_with_the_velocity_of_its_path():
    network = make_net([(0, 0, 0)], [])
    groups = {"ball": [0]}
    events = [
        event(0.0, "move ball", groups, duration=1.0, by=(2.0, 0, 0), using="constant speed"),
        event(0.5, "release ball", groups),
    ]
    plan = make_plan(network, 1.5, events, gravity=(0, 0, -10), every=0.25, energy=0.25)
    _, recording = carry_out(network, plan)
    time, position, velocity, *_ = recording.frame_arrays()
    fall = np.maximum(time - 0.5, 0.0)
    assert position[:, 0, 0] == pytest.approx(2.0 * time)
    assert position[:, 0, 2] == pytest.approx(-5.0 * fall**2)
    assert velocity[2].tolist() == [[2.0, 0.0, 0.0]]
    assert drift(recording) < 1e-12


def test_a_node_released_at_the_end_of_its_path_starts_from_rest():
    network = make_net([(0, 0, 0)], [])
    groups = {"ball": [0]}
    events = [
        event(0.15, "move ball", groups, duration=0.3, by=(1.0, 0, 0), using="constant speed"),
        event(0.45, "release ball", groups),  # 0.15 + 0.3 is 0.44999999999999996
    ]
    plan = make_plan(network, 1.0, events, every=0.05)
    outcome, _ = carry_out(network, plan)
    assert outcome.state.position.tolist() == [[1.0, 0.0, 0.0]]
    assert [h.kind for _, h in outcome.logged_events] == ["move", "end", "release"]
    assert {t for t, _ in outcome.logged_events} == {0.15, 0.45}


def test_the_ledger_closes_through_everything_that_events_can_do():
    random = np.random.default_rng(5)
    position = random.normal(size=(7, 3))
    ends = [(a, b) for a in range(7) for b in range(a)]
    network = make_net(
        position,
        ends,
        mass=random.uniform(1, 2, 7),
        stiffness=random.uniform(5, 20, 21),
        damping=random.uniform(0, 0.5, 21),
        rest=1.5,
        strength=np.where(np.arange(21) < 10, 6.0, np.inf),
    )
    groups = {"a": [0, 1], "b": [5], "all": list(range(7)), "springs": list(range(21))}
    tools = {"forceps": "forceps"}
    events = [
        event(0.0, "fix b", groups),
        event(0.1, "grasp a", groups, tools=tools, with_="forceps"),
        event(
            0.2,
            "move forceps",
            groups,
            tools=tools,
            duration=0.5,
            by=(1, 0.5, 0),
            using="smooth profile",
        ),
        event(
            0.3,
            "turn forceps",
            groups,
            tools=tools,
            duration=0.3,
            by=1.0,
            around=(0, 0, 1),
            using="constant speed",
        ),
        event(0.35, "push all", groups, duration=0.4, with_=(0, 5, 1), using="ramp"),
        event(
            0.4,
            "cut springs",
            groups,
            along="plane",
            through=position.mean(axis=0),
            facing=(1, 0, 0),
        ),
        event(0.5, "change gravity", groups, to=(0, 0, -3)),
        event(0.55, "change spring constant", groups, of="springs", by=1.5),
        event(0.6, "change mass", groups, of="all", by=1.2),
        event(0.65, "release forceps", groups, tools=tools),
        event(0.7, "free b", groups),
        event(0.75, "change spin", groups, of="all", to=(0, 1, 0)),
    ]
    plan = make_plan(
        network, 1.0, events, gravity=(0, 0, -9.81), drag=0.1, energy=0.01, tolerance=1e-8
    )
    outcome, recording = carry_out(network, plan)
    kinds = {h.kind for _, h in outcome.logged_events}
    assert outcome.kind == "done"
    assert {"rupture", "cut", "grasp", "change"} <= kinds
    assert drift(recording) < 1e-6


def test_a_rupture_happens_at_the_time_of_the_closed_form_and_is_logged():
    # From rest at the rest length, struck with 1 m/s: stretch = sin(ω t) / ω.
    network = oscillator(rest=1.0, strength=1.5, velocity=[[0, 0, 0], [1.0, 0, 0]])
    plan = make_plan(network, 1.0, energy=0.1)
    outcome, recording = carry_out(network, plan)
    ((time, logged_event),) = outcome.logged_events
    assert logged_event.kind == "rupture"
    assert logged_event.springs == (0,)
    assert 12.0 * np.sin(OMEGA * time) / OMEGA == pytest.approx(1.5, rel=1e-8)
    assert drift(recording) < 1e-9
    end = recording.energy_arrays()[1][-1]
    # What was stored in the spring, ½ F² / c, is gone with it.
    assert end[5] == pytest.approx(-(1.5**2) / 24.0, rel=1e-7)


def test_a_trigger_fires_once_at_the_first_time_its_condition_holds():
    network = oscillator(rest=1.0, velocity=[[0, 0, 0], [1.0, 0, 0]])
    tension = value("tension", subject("net", [], [0]))
    trigger = when(
        lambda snapshot: tension(snapshot) > 1.5, event(0.125, "cut net", {"net": [0]})
    )
    plan = make_plan(
        network,
        3.0,
        triggers=[trigger],
        integrator="velocity verlet",
        tolerance=None,
        step=1e-3,
    )
    outcome, _ = carry_out(network, plan)
    (fired, trigger_row), (cut, cut_row) = outcome.logged_events
    assert (trigger_row.kind, cut_row.kind) == ("trigger", "cut")
    assert cut == pytest.approx(fired + 0.125, rel=1e-15)
    assert fired == pytest.approx(np.arcsin(0.5) / OMEGA, abs=1e-3)


def test_a_trigger_that_was_seen_to_be_true_fires_whatever_rounding_says_afterwards():
    network = chain(2, velocity=(1.0, 0.0, 0.0))

    def true_on_the_way_only(snapshot):
        return snapshot.position is not snapshot.state.position and snapshot.time > 0.5

    trigger = when(true_on_the_way_only, event(0.0, "cut net", {"net": [0]}))
    outcome, _ = carry_out(network, make_plan(network, 1.0, triggers=[trigger]))
    assert [h.kind for _, h in outcome.logged_events] == ["trigger", "cut"]
    assert outcome.logged_events[0][0] == pytest.approx(0.5, abs=1e-9)


def test_triggers_that_are_true_at_the_start_fire_there_in_written_order():
    network = chain(3)
    triggers = [
        when(lambda snapshot: True, event(0.0, "cut last", {"last": [1]})),
        when(lambda snapshot: False, event(0.0, "cut last", {"last": [1]})),
        when(
            lambda snapshot: not snapshot.state.alive[1],
            event(0.0, "cut first", {"first": [0]}),
        ),
    ]
    plan = make_plan(network, 1.0, triggers=triggers)
    outcome, _ = carry_out(network, plan)
    assert [(t, h.kind, list(h.springs)) for t, h in outcome.logged_events] == [
        (0.0, "trigger", []),
        (0.0, "cut", [1]),
        (0.0, "trigger", []),
        (0.0, "cut", [0]),
    ]


def test_events_at_one_time_happen_in_written_order_after_ends_of_motions():
    network = chain(3)
    groups = {"a": [0], "b": [1]}
    events = [
        event(0.1, "move a", groups, duration=0.2, by=(0, 0, 1), using="constant speed"),
        event(0.3, "cut b", {"b": [1]}),
        event(0.1 + 0.2, "cut a", {"a": [0]}),  # 0.30000000000000004
    ]
    plan = make_plan(network, 1.0, events)
    outcome, _ = carry_out(network, plan)
    assert [h.kind for _, h in outcome.logged_events] == ["move", "end", "cut", "cut"]
    assert [list(h.springs) for _, h in outcome.logged_events] == [[], [], [1], [0]]
    assert len({t for t, _ in outcome.logged_events}) == 2


def test_samples_at_the_time_of_an_event_show_what_it_did():
    network = chain(3)
    plan = make_plan(
        network,
        1.0,
        [event(0.3, "cut net", {"net": [0, 1]})],
        logs=[log("springs", subject("net", [0, 1, 2], [0, 1]), every=0.1)],
        every=0.3,
    )
    _, recording = carry_out(network, plan)
    time, rows = recording.log_arrays("springs of net")
    assert time == pytest.approx(np.arange(11) * 0.1)
    assert rows[:, 0].tolist() == [2, 2, 2] + 8 * [0]
    assert recording.frame_arrays()[0] == pytest.approx([0, 0.3, 0.6, 0.9])
    assert recording.frame_arrays()[5][:, 0].tolist() == [True, False, False, False]


def test_expectations_are_judged_within_their_intervals_and_say_when_they_fail():
    network = chain(3)
    count = value("springs", subject("net", [0, 1, 2], [0, 1]))
    expectations = [
        expect(lambda m: count(m) == 2, 0.0, 0.3),  # ends before the cut at its end
        expect(lambda m: count(m) == 1, 0.3, 1.0),  # begins after it
        expect(lambda m: count(m) == 2, 0.3),
        expect(lambda m: count(m) == 2, 0.0, 1.0),
        expect(lambda m: count(m) < count(m.pinned[0.1]), 0.4, pinned=(0.1,)),
        expect(lambda m: count(m) == 3, 0.05, 0.06),
    ]
    events = [event(0.3, "cut net", {"net": [0]})]
    plan = make_plan(network, 1.0, events, expectations=expectations, every=0.25)
    outcome, _ = carry_out(network, plan)
    assert [(f.expectation, f.time) for f in outcome.failures] == [
        (2, 0.3),
        (3, 0.3),
        (5, 0.05),
    ]
    assert outcome.failures[0].measured == "at 0.3 s"


def test_nothing_is_recorded_that_nobody_asked_for():
    network = chain(3)
    recording = MemoryRecording()
    recorder = Recorder(network, make_plan(network, 1.0), recording)
    assert len(recorder.times) == 0
    assert run(network, recorder.plan, recorder).kind == "done"
    with pytest.raises(KeyError):
        recording.frame_arrays()


def test_the_energy_drift_of_a_whole_run_can_be_expected():
    network = oscillator()
    energy_drift = value("energy drift")
    plan = make_plan(
        network,
        1.0,
        every=0.1,
        expectations=[
            expect(lambda m: energy_drift(m) < 1e-8, 0.0, 1.0),
            expect(lambda m: energy_drift(m) > 1.0, 0.5),
        ],
    )
    outcome, _ = carry_out(network, plan)
    assert [f.expectation for f in outcome.failures] == [1]


# --- going on ---


def eventful(duration=2.0, **options):
    """A net with a motion, a timed hold, a push, a trigger, a rupture and a pinned snapshot."""
    random = np.random.default_rng(2)
    ends = [(a, b) for a in range(6) for b in range(a)]
    network = make_net(
        random.normal(size=(6, 3)),
        ends,
        stiffness=50.0,
        damping=0.2,
        rest=1.4,
        strength=np.where(np.arange(15) < 3, 60.0, np.inf),
    )
    groups = {"a": [0, 1], "b": [2], "springs": list(range(15))}
    events = [
        event(0.1, "move a", groups, duration=1.5, by=(1, 0, 0), using="smooth profile"),
        event(
            0.2,
            "turn a",
            groups,
            duration=1.0,
            by=0.5,
            around=(1, 2, 3),
            using="smooth profile",
        ),
        event(0.3, "hold b", groups, duration=0.9),
        event(0.4, "push a", groups, duration=1.0, with_=(0, 1, 0), using="ramp"),
        event(1.0, "change viscosity", groups, of="springs", by=2.0),
    ]
    here = value("position", subject("a", [0, 1]))
    trigger = when(lambda m: here(m) > 0.9, event(0.3, "cut springs", {"springs": [7]}))
    plan = make_plan(
        network,
        duration,
        events,
        gravity=(0, 0, -2),
        triggers=[trigger],
        every=0.01,
        energy=0.05,
        logs=[log("force", subject("a", [0, 1]), every=0.003)],
        expectations=[
            expect(lambda m: here(m) < here(m.pinned[0.25]), 1.9, pinned=(0.25,)),
            expect(lambda m: False, 0.7),
        ],
        **options,
    )
    return network, plan


METHODS = {
    "automatic": {},
    "velocity verlet": {"integrator": "velocity verlet", "tolerance": None, "step": 1e-3},
    "propagation": {"integrator": "propagation", "tolerance": None, "step": 1e-2},
    "propagation that goes on": {
        "integrator": "propagation",
        "tolerance": None,
        "step": 1e-2,
        "choices": PropagationChoices(first_step="last step", growth=1.25),
    },
}


@pytest.fixture(scope="module", params=METHODS)
def uninterrupted(request):
    """Network and plan, and the outcome and the recording of the whole run."""
    network, plan = eventful(**METHODS[request.param])
    return network, plan, *carry_out(network, plan)


@pytest.mark.parametrize(
    "count",
    [pytest.param(1, marks=pytest.mark.slow), 3, pytest.param(6, marks=pytest.mark.slow)],
)
def test_a_run_that_is_interrupted_and_resumed_gives_the_same_bytes(uninterrupted, count):
    network, plan, whole, undisturbed = uninterrupted
    first, before = carry_out(network, plan, interrupt=AfterAsking(count))
    assert first.kind == "interrupted"
    assert "can be resumed" in first.message
    assert 0.0 <= first.state.time < 2.0
    assert {h.kind for _, h in whole.logged_events} >= {"rupture", "trigger", "end", "cut"}
    recording = MemoryRecording()
    second = run(network, plan, Recorder(network, plan, recording), resume=before.state)
    assert second.kind == "done"
    for one, other in zip(
        every_array("force of a", undisturbed),
        every_array("force of a", before, recording),
        strict=True,
    ):
        assert np.array_equal(one, other)
    assert undisturbed.events == before.events + recording.events
    assert whole.failures == second.failures
    assert len(second.failures) == 1
    assert whole.logged_events[-1][0] == second.logged_events[-1][0]
    assert len(whole.logged_events) == len(second.logged_events)


def test_checkpoints_on_the_way_change_nothing(monkeypatch):
    network, plan = eventful()
    _, undisturbed = carry_out(network, plan)
    monkeypatch.setattr("tissuec.engine.execution.run.CHECKPOINT_EVERY", 0.0)
    outcome, recording = carry_out(network, plan)
    assert outcome.kind == "done"
    assert recording.state is not None
    for one, other in zip(
        every_array("force of a", undisturbed),
        every_array("force of a", recording),
        strict=True,
    ):
        assert np.array_equal(one, other)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_signal_interrupts_at_the_end_of_a_step_with_a_checkpoint(number):
    network, plan = eventful()
    told = []
    before = [signal.getsignal(one) for one in SIGNALS]

    def press_once(time):
        if time > 0.2 and not told:
            told.append(time)
            signal.raise_signal(number)

    outcome, recording = carry_out(network, plan, progress=press_once)
    assert threading.current_thread() is threading.main_thread()
    assert (outcome.kind, outcome.signal) == ("interrupted", number)
    assert ("by SIG" in outcome.message) == (number != signal.SIGINT)
    assert recording.state is not None
    assert [signal.getsignal(one) for one in SIGNALS] == before


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_second_signal_ends_a_run_at_once(number):
    network, plan = eventful()

    def press(time):
        signal.raise_signal(number)
        signal.raise_signal(number)

    with pytest.raises(KeyboardInterrupt) as raised:
        carry_out(network, plan, progress=press)
    assert exit_code(getattr(raised.value, "signal", None)) == 128 + number


@pytest.mark.usefixtures("interruptible")
def test_a_signal_that_comes_while_a_file_is_closed_counts_when_that_is_done():
    done = []
    with pytest.raises(Terminated), asked_to_stop() as stop:  # noqa: PT012
        with asked_to_stop(stop) as inner:
            assert not inner()
        signal.raise_signal(signal.SIGTERM)
        done.append("closed")
    assert done == ["closed"]


@pytest.mark.usefixtures("interruptible")
def test_a_signal_that_somebody_else_handles_or_ignores_is_left_alone():
    network, plan = eventful()
    taken = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: taken.append(number))
    try:
        outcome, _ = carry_out(
            network, plan, progress=lambda time: signal.raise_signal(signal.SIGTERM)
        )
    finally:
        signal.signal(signal.SIGTERM, before)
    assert outcome.kind == "done"
    assert taken


def test_progress_is_told_in_order_and_up_to_the_end():
    network, plan = eventful()
    told = []
    carry_out(network, plan, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 2.0
    assert len(told) > 5


# --- failures ---


def test_a_run_that_diverges_names_spring_nodes_time_and_line():
    network = oscillator(stiffness=1e6)
    plan = make_plan(
        network, 1.0, integrator="velocity verlet", tolerance=None, step=0.01, every=0.1
    )
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "diverged"
    assert "spring 500 of net between the nodes 100 and 101" in outcome.message
    assert "hand.tis:1" in outcome.message
    assert f"{outcome.state.time * 1e3:.6g} ms" in outcome.message
    assert np.isfinite(outcome.state.position).all()


def test_expectations_that_a_run_does_not_come_to_are_neither_kept_nor_broken():
    network = oscillator(stiffness=1e6)
    method = {"integrator": "velocity verlet", "tolerance": None, "step": 0.01}
    expectations = [
        expect(lambda m: True, 0.0),
        expect(lambda m: False, 0.0, 1.0),
        expect(lambda m: True, 0.0, 1.0),
        expect(lambda m: True, 1.0),
    ]
    plan = make_plan(network, 1.0, every=0.1, expectations=expectations, **method)
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "diverged" and outcome.state.time < 1.0
    assert [f.expectation for f in outcome.failures] == [1]
    assert outcome.unreached == (2, 3)


def test_a_run_to_its_end_comes_to_every_expectation():
    network, plan = eventful()
    times = [(0.0, None), (2.0, None), (0.0, 2.0), (0.5, 1.0), (1.0, 2.0)]
    plan = replace(plan, expectations=tuple(expect(lambda m: True, *t) for t in times))
    outcome, _ = carry_out(network, plan)
    assert (outcome.kind, outcome.unreached) == ("done", ())


def test_a_net_of_nothing_but_free_nodes_falls():
    network = make_net([(0, 0, 0), (1, 0, 0)], [])
    plan = make_plan(network, 1.0, gravity=(0, 0, -10), every=0.5, energy=0.5)
    outcome, recording = carry_out(network, plan)
    assert outcome.state.position[:, 2] == pytest.approx([-5.0, -5.0])
    assert drift(recording) < 1e-12
