"""Landing, samples, triggers, failures: what the engine does between and at the steps."""

import numpy as np
import pytest

from tests.engine.members import MEMBERS, ON_BACKENDS, affordable, brakes, those
from tests.engine.running import Bench, block, chain, lifted_tube, pair, set_pace
from tests.hand_net import make_net
from tissuec.engine.backends import BACKENDS, default_backend
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.profiles import TimeProfile


def suited_tube(method, duration=0.2, **asked):
    """Return the lifted tube, without what a member is not for."""
    # Of implicit members the one of higher order is enough; work asks many steps of order 2.
    member = INTEGRATORS[method]
    cheap = member.order > 2 or not member.implicit
    ledger = asked.pop("ledger", cheap) and brakes(method, 1.0) == 1.0
    damping = brakes(method, 0.02)
    return lifted_tube(duration, damping=damping, method=method, ledger=ledger, **asked)


@pytest.mark.parametrize("step", [None, 0.013])
@pytest.mark.parametrize("method", MEMBERS)
def test_steps_land_exactly_on_every_time_asked_for(method, step):
    bench = Bench(pair(), 1.0, method=method, step=step, tolerance=1e-4)
    for until in (0.1, 0.1 + 1e-15, 1.0 / 3.0, np.nextafter(1.0 / 3.0, 1.0), 0.7, 1.0):
        end = bench.advance(until)
        assert (end.kind, end.time, bench.state.time) == ("reached", until, until)


def test_uniform_steps_are_the_fewest_that_fit():
    bench = Bench(pair(), 1.0, method="velocity verlet", step=0.03)
    bench.advance(0.1)
    assert bench.engine.statistics.accepted == 4
    bench.advance(1.0)
    assert bench.engine.statistics.accepted == 4 + 30
    assert bench.engine.statistics.largest == pytest.approx(0.03, rel=1e-12)


@pytest.mark.parametrize(("method", "backend"), ON_BACKENDS)
def test_samples_come_once_each_in_order_whatever_the_stops(method, backend):
    times = np.sort(np.concatenate([np.linspace(0.0, 1.0, 7), [0.25, 0.31, 0.310001]]))
    tolerance = affordable(method)
    ran = Bench(
        pair(), 1.0, method=method, tolerance=tolerance, times=times, backend=backend
    ).run(0.25, 0.31)
    assert np.array_equal(ran.time, times)


def test_sample_at_an_event_shows_the_state_after_it():
    bench = Bench(pair(stretch=0.0), 1.0, tolerance=1e-6, times=[0.0, 0.5, 1.0])
    bench.advance(0.5)
    assert [batch.time.tolist() for batch in bench.batches] == [[0.0]]
    bench.state.velocity[:] = [1.0, 0.0, 0.0]
    bench.engine.restart(bench.state)
    ran = bench.run()
    assert ran.velocity[:, 0, 0] == pytest.approx([0.0, 1.0, 1.0], abs=1e-12)


def test_dense_samples_do_not_change_the_steps():
    few = Bench(pair(), 1.0, tolerance=1e-6, times=[1.0]).run()
    many = Bench(pair(), 1.0, tolerance=1e-6, times=np.linspace(0.0, 1.0, 5001)).run()
    assert many.engine.statistics.accepted == few.engine.statistics.accepted
    assert np.array_equal(many.position[-1], few.position[-1])


def test_batches_are_bounded_in_memory():
    net = block(6)
    bench = Bench(net, 1.0, tolerance=1e-3, times=np.linspace(0.0, 1.0, 6001))
    ran = bench.run()
    assert len(ran.time) == 6001
    assert max(batch.position.nbytes for batch in bench.batches) <= 16_000_000


def test_motions_are_seen_from_within_each_stretch_also_where_their_speed_jumps():
    # A dashpot alone, to a node on a ramp: m v' = d (1 - v) while that moves, then -d v.
    net = make_net([[0, 0, 0], [1, 0, 0]], [[0, 1]], stiffness=0.0, damping=2.0)
    bench = Bench(net, 2.0, tolerance=1e-9)
    bench.move([1], [1.0, 0.0, 0.0], TimeProfile("ramp", 0.5, 1.5))
    ran = bench.run()
    speed = np.where(
        ran.time < 0.5,
        0.0,
        np.where(
            ran.time < 1.5,
            1.0 - np.exp(-2.0 * (ran.time - 0.5)),
            (1.0 - np.exp(-2.0)) * np.exp(-2.0 * (ran.time - 1.5)),
        ),
    )
    assert ran.velocity[:, 0, 0] == pytest.approx(speed, abs=1e-9)
    assert ran.engine.statistics.rejected < 10


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kind", ["ramp", "smooth", "sine", "table", "turn"])
def test_driven_nodes_are_where_their_motion_has_them(kind, backend):
    profile = {
        "ramp": TimeProfile("ramp", 0.2, 0.8),
        "smooth": TimeProfile("smooth", 0.2, 0.8),
        "turn": TimeProfile("smooth", 0.2, 0.8),
        "sine": TimeProfile("sine", 0.2, 0.8, frequency=1.3),
        "table": TimeProfile(
            "table", 0.2, 0.8, times=np.array([0.0, 0.3, 0.6]),
            values=np.array([0.0, 2.0, 1.0]), slopes=np.array([0.0, 1.0, -1.0]),
        ),
    }[kind]  # fmt: skip
    bench = Bench(pair(), 1.0, tolerance=1e-6, backend=backend, times=np.linspace(0.0, 1.0, 38))
    if kind == "turn":
        bench.turn([1], 2.0, profile, centre=(0.5, 0.1, 0.0), axis=(0.6, 0.0, 0.8))
    else:
        bench.move([1], [0.1, 0.2, -0.3], profile)
    motion = bench.state.motions["tool"]
    ran = bench.run()
    for time, position, velocity in zip(ran.time, ran.position, ran.velocity, strict=True):
        x, v = motion.at(time)
        assert position[1] == pytest.approx(x[0], abs=5e-15)
        assert velocity[1] == pytest.approx(v[0], abs=5e-14)


@pytest.mark.parametrize("method", MEMBERS)
def test_trigger_is_found_at_its_first_true_time(method):
    tolerance = affordable(method)
    bench = Bench(pair(), 1.0, method=method, tolerance=tolerance)
    end = bench.advance(1.0, lambda time, x, v: x[0, 0] > 0.15)
    exact = np.arccos(1.0 - 0.15 / 0.1) / np.sqrt(200.0)
    assert end.kind == "triggered"
    # The error of the position, 0.2 m at most, over the speed there.
    assert end.time == pytest.approx(exact, abs=tolerance * 0.2 / 1.2 + 1e-12)
    assert bench.state.position[0, 0] == pytest.approx(0.15, abs=1e-12)


def test_trigger_on_time_alone_is_met_to_rounding_and_the_run_goes_on():
    bench = Bench(pair(), 1.0, tolerance=1e-6)
    end = bench.advance(1.0, lambda time, x, v: time >= 0.4321)
    assert end.time == pytest.approx(0.4321, abs=1e-12)
    ran = bench.run()
    assert ran.end.kind == "reached"
    assert len(ran.time) == 41


def test_condition_that_holds_already_triggers_before_any_step():
    bench = Bench(pair(), 1.0, tolerance=1e-6)
    end = bench.advance(1.0, lambda time, x, v: True)
    assert (end.kind, end.time, bench.engine.statistics.accepted) == ("triggered", 0.0, 0)


def test_rupture_before_a_trigger_comes_first_and_the_other_way_round():
    for level, kind in ((-9.0, "triggered"), (9.0, "ruptured")):
        bench = Bench(pair(stretch=-0.1, strength=6.0), 1.0, tolerance=1e-6, ruptures=True)
        end = bench.advance(
            1.0, lambda time, x, v, level=level: 100.0 * (x[1, 0] - x[0, 0] - 1.0) > level
        )
        assert end.kind == kind


@pytest.mark.parametrize("backend", BACKENDS)
def test_unstable_steps_are_caught_and_no_undefined_value_is_recorded(backend):
    net = chain(8, velocity=np.r_[0.0, 0.01 * (-1.0) ** np.arange(8), 0.0][:, None] * [1, 0, 0])
    bench = Bench(net, 10.0, method="velocity verlet", step=0.03, fixed=[0, 9], backend=backend)
    ran = bench.run()
    assert ran.end.kind == "diverged"
    assert ran.end.spring is not None
    assert 0.0 < ran.end.time < 10.0
    assert np.isfinite(ran.position).all()
    assert np.isfinite(ran.velocity).all()
    assert np.isfinite(ran.state.position).all()
    assert ran.state.time == ran.end.time


def test_long_flight_is_not_taken_for_divergence():
    net = pair(stretch=0.0, velocity=[1e5, 0.0, 0.0])
    ran = Bench(net, 1000.0, method="velocity verlet", step=0.1).run()
    assert ran.end.kind == "reached"
    assert ran.position[-1, 0, 0] == pytest.approx(1e8, rel=1e-9)


def test_tolerance_below_rounding_is_refused():
    end = Bench(pair(), 1.0, tolerance=1e-14).advance(1.0)
    assert end.kind == "stuck"
    assert "1e-14" in end.message


def test_infinite_force_is_reported_as_divergence_with_the_spring_named():
    net = pair()
    bench = Bench(net, 1.0, tolerance=1e-6)
    bench.state.springs = bench.state.springs.changed("stiffness", 0, np.inf)
    end = bench.advance(1.0)
    assert (end.kind, end.spring) == ("diverged", 0)


@pytest.mark.parametrize(("method", "backend"), ON_BACKENDS)
def test_same_run_gives_the_same_bytes(method, backend):
    runs = [suited_tube(method, 0.1, tolerance=1e-2, backend=backend).run() for _ in range(2)]
    assert runs[0].position.tobytes() == runs[1].position.tobytes()
    assert runs[0].velocity.tobytes() == runs[1].velocity.tobytes()
    assert runs[0].engine.statistics == runs[1].engine.statistics


@pytest.mark.parametrize("ledger", [False, True])
@pytest.mark.parametrize("method", MEMBERS)
def test_both_tiers_agree_to_rounding(method, ledger):
    # Equations of implicit steps so exactly that both backends break off after the same round.
    asked = {"step": 2e-4, "tolerance": 1e-12, "duration": 0.03, "ledger": ledger}
    interpreted, compiled = (
        suited_tube(method, backend=backend, **asked).run() for backend in BACKENDS
    )
    assert interpreted.end.kind == compiled.end.kind == "reached"
    reach = interpreted.largest_displacement[-1]
    assert np.abs(interpreted.position - compiled.position).max() < 1e-11 * reach
    assert compiled.work == pytest.approx(interpreted.work, rel=1e-9, abs=1e-15)
    assert compiled.dissipated == pytest.approx(interpreted.dissipated, rel=1e-9, abs=1e-15)


def test_methods_that_are_not_shipped_are_interpreted(monkeypatch):
    own = type("Own", (), {})
    assert default_backend(own) == "interpreted"
    assert {default_backend(INTEGRATORS[name]) for name in INTEGRATORS} == {"compiled"}


@pytest.mark.parametrize(("method", "backend"), ON_BACKENDS)
def test_run_resumed_from_any_checkpoint_gives_the_same_bytes(method, backend):
    asked = {"tolerance": 1e-2, "backend": backend}
    whole = suited_tube(method, **asked)
    kept = whole.keep_checkpoints(4)  # which is emptied every few steps
    complete = whole.run(0.17)
    assert len(kept) > 5
    for count, time, position, velocity, state in kept[1 : -1 : max(1, len(kept) // 4)]:
        later = suited_tube(method, **asked)
        later.restore(time, position, velocity, state)
        rest = later.run(*([0.17] if time < 0.17 else []))
        before = sum(len(batch.time) for batch in whole.batches[:count])
        assert rest.position.tobytes() == complete.position[before:].tobytes()
        assert rest.work.tobytes() == complete.work[before:].tobytes()
        assert rest.engine.statistics == complete.engine.statistics


def test_pause_is_offered_between_steps_also_while_a_condition_is_watched(monkeypatch):
    set_pace(monkeypatch, "interpreted", 100 * 4)
    bench = Bench(pair(), 0.01, method="velocity verlet", step=1e-5, backend="interpreted")
    asked = []

    def pause(time):
        asked.append(time)
        return len(asked) == 2

    end = bench.engine.advance(bench.state, 0.01, lambda time, x, v: False, pause)
    assert (end.kind, end.time) == ("paused", asked[-1])
    assert 0.0 < asked[0] < asked[1] < 0.01
    assert bench.engine.checkpoint() is not None
    assert bench.advance(0.01).kind == "reached"


def test_condition_that_holds_for_a_part_of_a_period_is_seen_at_the_first_one():
    bench = Bench(pair(), 10.0, tolerance=1e-3)
    end = bench.advance(10.0, lambda time, position, velocity: position[0, 0] > 0.19)
    # x = 0.1 (1 - cos ωt) with ω = √200
    assert end.kind == "triggered"
    assert end.time == pytest.approx(np.arccos(-0.9) / np.sqrt(200.0), rel=1e-3)


@pytest.mark.parametrize("backend", BACKENDS)
def test_fixed_steps_that_lead_nowhere_are_told(backend):
    net = make_net(
        np.zeros((2, 3)), [[0, 1]], rest=1.0, stiffness=1e4, velocity=[[1, 0, 0], [0, 0, 0]]
    )
    ran = Bench(net, 100.0, method="velocity verlet", step=1.0, backend=backend).run()
    assert ran.end.kind == "diverged"
    assert np.isfinite(ran.position).all()


@pytest.mark.parametrize("method", those(implicit=True))
@pytest.mark.parametrize("size", [0.3, 3.0, 1e3])
def test_absurd_implicit_steps_are_told_and_nothing_undefined_is_recorded(method, size):
    # A net that tumbles: far ahead, the equations of a step have many solutions, or none near.
    net = block(stiffness=50.0, damping=1e-3, shrink=0.9, spin=(30.0, 70.0, 10.0))
    bench = Bench(net, 20 * size, method=method, step=size, ruptures=True)
    end = bench.advance(bench.duration)
    assert end.kind in ("stuck", "reached")
    if end.kind == "stuck":
        assert "did not converge" in end.message
        assert end.spring is not None
    for batch in bench.batches:
        assert np.isfinite(batch.position).all()
        assert np.isfinite(batch.velocity).all()
    assert np.isfinite(bench.state.position).all()
    assert bench.state.time == end.time


@pytest.mark.parametrize("method", those(implicit=True))
def test_fixed_implicit_steps_that_cannot_be_solved_are_stuck(method, monkeypatch):
    # Newton's method must not begin: a round more than none is needed for what is not linear.
    monkeypatch.setattr("tissuec.engine.integrators.dirk.ITERATIONS", 1)
    net = block(shrink=0.9, spin=(30.0, 70.0, 10.0))
    bench = Bench(net, 1.0, method=method, step=0.01, tolerance=1e-9)
    end = bench.advance(1.0)
    assert (end.kind, end.time) == ("stuck", 0.0)
    assert "use a smaller step" in end.message
    adaptive = Bench(net, 1.0, method=method, tolerance=1e-4)
    assert adaptive.advance(0.01).kind in ("reached", "stuck")
