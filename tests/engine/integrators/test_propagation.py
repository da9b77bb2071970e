"""The published procedure: of first order, with frames, a floor, and honest about both."""

import numpy as np
import pytest

from tests.engine.running import Bench, lifted_tube, pair
from tests.engine.test_closed_forms import relaxation
from tests.hand_plan import carry_out, make_plan
from tissuec.engine.backends import BACKENDS
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.profiles import TimeProfile
from tissuec.script.procedures import PropagationChoices

OMEGA = np.sqrt(200.0)  # of a pair
FLOOR = PropagationChoices().smallest_step
WHOLE = PropagationChoices(smallest_step=1.0)  # all steps are whole frames


def swing(step, *, ratio=0.0, duration=1.0, times=(1.0,), **more):
    net = pair(damping=ratio * OMEGA)
    return Bench(net, duration, method="propagation", step=step, times=times, **more).run()


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.5])
@pytest.mark.parametrize("choices", [None, WHOLE], ids=["halving", "never halving"])
def test_propagation_is_of_first_order(ratio, choices):
    steps = 1.0 / np.array([256, 512, 1024, 2048])
    errors = []
    for step in steps:
        found = swing(step, ratio=ratio, choices=choices).position[0, 0, 0]
        errors.append(abs(found - 0.1 * (1.0 - relaxation(ratio, OMEGA, 1.0))))
    observed = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert observed == pytest.approx(INTEGRATORS["propagation"].order, abs=0.15)


def test_whole_frames_are_symplectic_euler():
    ran = swing(0.05, times=np.arange(21) * 0.05, choices=WHOLE)
    stretch, rate = 0.2, 0.0
    for position in ran.position:
        assert np.diff(position[:, 0])[0] == pytest.approx(1.0 + stretch, rel=1e-12)
        rate -= 0.05 * OMEGA**2 * stretch
        stretch += 0.05 * rate


CHOICES = {
    "table": {},
    "internal forces": {"compared_forces": "internal"},
    "forgotten force": {"former_force": "forgotten"},
    "repeated frames": {"repeated": "frame"},
    "last step": {"first_step": "last step"},
    "slow growth": {"growth": 1.25},
    "open frames": {"frame_end": "open"},
    "long steps": {"smallest_step": 0.2},
    "text": {"compared_forces": "internal", "repeated": "frame", "first_step": "last step",
             "growth": 1.25},
}  # fmt: skip
PUSHED = 3.0  # on the second mass of the pair, outwards [N]


def by_hand(frame, frames, asked):
    """Table 1 and its variants on four numbers: two places on a line and their rates.

    Returns places after each frame, shape (frame, 2), evaluations and stalls.
    """
    choices, load = PropagationChoices(**asked), np.array([0.0, PUSHED])

    def force(x):
        return 100.0 * (x[1] - x[0] - 1.0) * np.array([1.0, -1.0]) + load

    def compared(x):
        own = load if choices.compared_forces == "internal" else 0.0
        return np.abs(force(x) - own).max()

    x, v, last, calls, stalls = np.array([0.0, 1.2]), np.zeros(2), frame, 0, 0
    found = [x]
    for _ in range(frames):
        begun = former = np.inf if choices.former_force == "forgotten" else compared(x)
        start, time = (x, v), 0.0
        pace = last if choices.first_step == "last step" else frame
        while time < frame * (1.0 - 1e-12):
            size = pace if choices.frame_end == "open" else min(pace, frame - time)
            new_v = v + size * force(x)
            new_x = x + size * new_v
            calls += 1
            if compared(new_x) > former * (1.0 + 1e-13):
                if size > choices.smallest_step * frame * 1.0001:
                    pace = 0.5 * size
                    if choices.repeated == "frame":
                        (x, v), time, former = start, 0.0, begun
                    continue
                stalls += 1
            time, x, v, former = time + size, new_x, new_v, compared(new_x)
            pace *= choices.growth if choices.repeated == "step" else 1.0
        last = min(frame, pace * (choices.growth if choices.repeated == "frame" else 1.0))
        found.append(x)
    return np.array(found), calls, stalls


@pytest.mark.parametrize("name", CHOICES)
def test_frames_follow_the_table_or_what_is_chosen_instead_step_by_step(name):
    frame, frames = 0.11, 8
    expected, calls, stalls = by_hand(frame, frames, CHOICES[name])
    bench = Bench(
        pair(), frame * frames, method="propagation", step=frame,
        times=np.arange(frames + 1) * frame, choices=PropagationChoices(**CHOICES[name]),
    )  # fmt: skip
    bench.push([1], (PUSHED, 0.0, 0.0))
    ran = bench.run()
    assert ran.position[:, :, 0] == pytest.approx(expected, rel=1e-9)
    # One more evaluation begins the run.
    assert ran.engine.statistics.evaluations == calls + 1
    assert ran.engine.statistics.stalls == stalls


def test_each_choice_of_the_procedure_makes_another_motion():
    ends = [by_hand(0.11, 8, asked)[0][-1, 0] for asked in CHOICES.values()]
    assert len(np.unique(np.round(ends, 6))) == len(CHOICES)


def test_weight_loads_and_drag_are_no_internal_forces():
    """A falling pair has none at all: nothing rises, and nothing is repeated."""
    asked = {"gravity": (0.0, 0.0, -9.81), "drag": 0.7, "step": 0.1, "times": [0.8]}
    bench = Bench(
        pair(stretch=0.0), 0.8, method="propagation",
        choices=PropagationChoices(compared_forces="internal"), **asked,
    )  # fmt: skip
    bench.push([0, 1], (0.0, 4.0, 0.0), TimeProfile("ramp", 0.0, 0.8))
    statistics = bench.run().engine.statistics
    assert statistics.evaluations == statistics.accepted + 1


def test_frames_end_at_scripted_times_and_stalls_do_not_stop_it():
    bench = Bench(pair(), 1.0, method="propagation", step=0.15, times=[])
    for until in (0.4, 0.55, 1.0):
        assert bench.advance(until).kind == "reached"
        assert bench.state.time == until
    statistics = bench.engine.statistics
    assert statistics.accepted == 3 + 1 + 3  # frames of 0.133, 0.15 and 0.15 s
    assert statistics.largest <= 0.15 * (1.0 + 1e-12)
    assert statistics.stalls > 0


def test_a_force_that_stays_the_same_halves_nothing():
    bench = Bench(pair(stiffness=0.0), 1.0, method="propagation", step=0.01, times=[1.0])
    bench.push([1], (3.0, 0.0, 0.0))
    statistics = bench.run().engine.statistics
    assert statistics.stalls == 0
    assert statistics.evaluations == statistics.accepted + 1


def test_even_an_overdamped_net_stalls_while_dashpots_take_over():
    """The net force falls through zero and rises to a peak before it fades."""
    statistics = swing(0.01, ratio=3.0).engine.statistics
    assert 0 < statistics.stalls < statistics.evaluations


@pytest.mark.parametrize("name", ["table", "text"])
def test_both_tiers_give_the_same_motion(name):
    asked = {"step": 1e-3, "ledger": True, "choices": PropagationChoices(**CHOICES[name])}
    runs = [
        lifted_tube(0.05, method="propagation", backend=backend, **asked).run()
        for backend in BACKENDS
    ]
    one, other = (run.engine.statistics for run in runs)
    assert (one.accepted, one.stalls) == (other.accepted, other.stalls)
    assert np.abs(runs[0].position - runs[1].position).max() < 1e-12
    assert runs[0].work == pytest.approx(runs[1].work, rel=1e-9, abs=1e-15)


def test_energy_of_small_steps_is_booked_and_that_of_large_ones_is_told():
    network = pair()
    notes = {}
    for step in (1e-4, 0.226):
        plan = make_plan(
            network, 10.0 * step, integrator="propagation", tolerance=None, step=step
        )
        outcome, _ = carry_out(network, plan)
        notes[step] = " ".join(outcome.notes)
        assert f"{outcome.statistics.stalls} steps" in notes[step] or not notes[step]
    assert "energy" not in notes[1e-4]
    assert "to the energy of the net" in notes[0.226]
    assert "stalled" in notes[0.226]


def test_work_is_booked_along_with_the_steps():
    bench = Bench(pair(damping=1.0), 0.1, method="propagation", step=1e-4, ledger=True)
    bench.push([1], (3.0, 0.0, 0.0))
    ran = bench.run()
    stretch = np.diff(ran.position[:, :, 0], axis=1)[:, 0] - 1.0
    energy = 50.0 * stretch**2 + 0.5 * (ran.velocity[:, :, 0] ** 2).sum(axis=1)
    assert ran.work == pytest.approx(3.0 * (ran.position[:, 1, 0] - 1.2), abs=1e-3)
    assert energy - energy[0] == pytest.approx(ran.work - ran.dissipated, abs=5e-3)


def test_a_motion_without_bounds_is_told():
    assert swing(3.2 / OMEGA, duration=100.0, choices=WHOLE).end.kind == "diverged"
