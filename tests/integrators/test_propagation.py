"""The published procedure: of first order, with frames, a floor, and honest about both."""

import numpy as np
import pytest

from tests.engine.running import TIERS, Bench, lifted_tube, pair
from tests.engine.test_closed_forms import relaxation
from tests.hand_plan import carry_out, make_plan
from tissuec.integrators import INTEGRATORS
from tissuec.integrators.propagation import FLOOR

OMEGA = np.sqrt(200.0)  # of a pair


@pytest.fixture(params=[FLOOR, 1.0], ids=["halving", "never halving"])
def floor(request, monkeypatch):
    """Set the floor; at 1 all steps are whole frames, as if no former force were known."""
    table = INTEGRATORS["propagation"].tableau.copy()
    table[0, 0] = request.param
    monkeypatch.setattr(INTEGRATORS["propagation"], "tableau", table)
    return request.param


def swing(step, *, ratio=0.0, duration=1.0, times=(1.0,), tier="interpreted", **more):
    net = pair(damping=ratio * OMEGA)
    return Bench(
        net, duration, method="propagation", step=step, times=times, tier=tier, **more
    ).run()


@pytest.mark.parametrize(
    ("ratio", "tier"),
    [
        *((ratio, "compiled") for ratio in (0.05, 0.5)),
        pytest.param(0.0, "compiled", marks=pytest.mark.slow),
        *(pytest.param(r, "interpreted", marks=pytest.mark.slow) for r in (0.0, 0.05, 0.5)),
    ],
)
def test_propagation_is_of_first_order(ratio, tier, floor):
    steps = 1.0 / np.array([256, 512, 1024, 2048])
    errors = []
    for step in steps:
        found = swing(step, ratio=ratio, tier=tier).position[0, 0, 0]
        errors.append(abs(found - 0.1 * (1.0 - relaxation(ratio, OMEGA, 1.0))))
    observed = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert observed == pytest.approx(INTEGRATORS["propagation"].order, abs=0.15)


def test_whole_frames_are_symplectic_euler(monkeypatch):
    monkeypatch.setattr(INTEGRATORS["propagation"], "tableau", np.ones((1, 8)))
    ran = swing(0.05, times=np.arange(21) * 0.05)
    stretch, rate = 0.2, 0.0
    for position in ran.position:
        assert np.diff(position[:, 0])[0] == pytest.approx(1.0 + stretch, rel=1e-12)
        rate -= 0.05 * OMEGA**2 * stretch
        stretch += 0.05 * rate


def test_a_frame_follows_the_table_step_by_step():
    """The table again, on two numbers: elongation and its rate."""
    frame, stretch, rate, former, stalls = 0.1, 0.2, 0.0, OMEGA**2 * 0.2, 0
    expected = [stretch]
    for _ in range(8):
        time, size = 0.0, frame
        while time < frame * (1.0 - 1e-12):
            size = min(size, frame - time)
            new_rate = rate - size * OMEGA**2 * stretch
            new_stretch = stretch + size * new_rate
            greatest = OMEGA**2 * abs(new_stretch)
            if greatest > former:
                if size > FLOOR * frame * 1.0001:
                    size *= 0.5
                    continue
                stalls += 1
            time, size = time + size, 2.0 * size
            stretch, rate, former = new_stretch, new_rate, greatest
        expected.append(stretch)
    ran = swing(frame, duration=0.8, times=np.arange(9) * frame)
    assert np.diff(ran.position[:, :, 0], axis=1)[:, 0] - 1.0 == pytest.approx(expected)
    assert ran.engine.statistics.stalls == stalls > 100


def test_frames_end_at_scripted_times_and_stalls_do_not_stop_it():
    bench = Bench(pair(), 1.0, method="propagation", step=0.15, times=[])
    for until in (0.4, 0.55, 1.0):
        assert bench.advance(until).kind == "reached"
        assert bench.situation.time == until
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


def test_both_tiers_give_the_same_motion():
    runs = [
        lifted_tube(0.05, method="propagation", step=1e-3, tier=tier, ledger=True).run()
        for tier in TIERS
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


def test_a_motion_without_bounds_is_told(monkeypatch):
    monkeypatch.setattr(INTEGRATORS["propagation"], "tableau", np.ones((1, 8)))
    assert swing(3.2 / OMEGA, duration=100.0).end.kind == "diverged"
