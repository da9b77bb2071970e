"""The reference itself, against closed forms."""

import numpy as np
import pytest

from tests.hand_net import chain, make_net
from tests.hand_plan import event, make_plan, when
from tissuec.validate.reference import default_rtol, reference
from tissuec.validate.stepping import METHODS, ONE_STEP, ReferenceFailure

MASS, SPRING, DAMPER = 0.01, 40.0, 0.1
# The error per step of 1e-10 adds up over some hundred steps; one-step methods and BDF differ.
RTOL = 1e-10


def times_until(stop, count=41):
    return np.linspace(0.0, stop, count)


def pair(**parameters):
    """Return two masses 12 cm apart along x, on a spring of 10 cm."""
    network = {"mass": MASS, "stiffness": SPRING, "rest": 0.1} | parameters
    return make_net([[0, 0, 0], [0.12, 0, 0]], [[0, 1]], **network)


def lonely(**parameters):
    return make_net([[0, 0, 0]], np.zeros((0, 2)), mass=MASS, **parameters)


@pytest.mark.parametrize("method", METHODS)
def test_two_masses_on_a_damped_spring_follow_the_closed_form(method):
    """Elongation of the relative motion: e₀ e^(-gt) (cos wt + g/w sin wt), reduced mass m/2."""
    network, times = pair(damping=DAMPER), times_until(0.25)
    solution = reference(network, make_plan(network, 0.25), times, method=method, rtol=RTOL)
    g = DAMPER / MASS
    w = np.sqrt(2.0 * SPRING / MASS - g * g)
    exact = 0.02 * np.exp(-g * times) * (np.cos(w * times) + g / w * np.sin(w * times))
    found = solution.position[:, 1, 0] - solution.position[:, 0, 0] - 0.1
    allowed = 1e-8 if method in ONE_STEP else 1e-6
    assert np.abs(found - exact).max() < allowed * 0.02
    assert np.abs(solution.imbalance).max() < 10.0 * allowed * solution.initial


def test_error_falls_with_the_error_per_step():
    network, times = pair(damping=DAMPER), times_until(1.0, 6)
    plan = make_plan(network, 1.0)
    finest = reference(network, plan, times, rtol=1e-13).position
    errors = [
        np.abs(reference(network, plan, times, rtol=rtol).position - finest).max()
        for rtol in (1e-5, 1e-7, 1e-9)
    ]
    assert errors[0] > 10.0 * errors[1] > 100.0 * errors[2]


def test_velocity_is_that_of_the_motion():
    network, times = pair(), times_until(0.3)
    solution = reference(network, make_plan(network, 0.3), times, rtol=RTOL)
    w = np.sqrt(2.0 * SPRING / MASS)
    exact = -0.01 * w * np.sin(w * times)
    assert solution.velocity[:, 1, 0] == pytest.approx(exact, abs=1e-8 * 0.01 * w)


def test_driven_spring_breaks_when_its_tension_reaches_the_breaking_force():
    """T = c v t + d v = F, with the viscous part in it."""
    network = make_net([[0, 0, 0], [0.1, 0, 0]], [[0, 1]], mass=MASS, stiffness=SPRING,
                       damping=DAMPER, strength=2.0)  # fmt: skip
    groups = {"left": [0], "right": [1]}
    events = [
        event(0.0, "fix left", groups),
        event(0.25, "move right", groups, duration=0.5, by=(0.1, 0.0, 0.0), using="ramp"),
    ]
    solution = reference(network, make_plan(network, 1.0, events), times_until(1.0))
    speed = 0.2
    exact = 0.25 + (2.0 - DAMPER * speed) / (SPRING * speed)
    assert [entry.springs.tolist() for entry in solution.breaks] == [[0]]
    assert solution.breaks[0].time == pytest.approx(exact, abs=1e-12)
    pulled = solution.force[solution.times < exact - 1e-9, 1, 0]
    assert pulled.min() == pytest.approx(-2.0, rel=0.1)
    assert not solution.force[solution.times > exact].any()


@pytest.mark.parametrize("method", ["DOP853", "Radau", "LSODA"])
@pytest.mark.parametrize("part", [0.3, 0.9, 1.0 - 1e-7])
def test_swinging_spring_breaks_on_time_even_where_it_only_just_does(method, part):
    """T = c A sin wt reaches part · c A at asin(part) / w, near the top between two steps."""
    speed = 1.0
    network = make_net(
        [[0, 0, 0], [0.1, 0, 0]], [[0, 1]], mass=MASS, stiffness=SPRING,
        velocity=[[0, 0, 0], [speed, 0, 0]],
        strength=part * speed * np.sqrt(SPRING * MASS),
    )  # fmt: skip
    plan = make_plan(network, 0.2, [event(0.0, "fix left", {"left": [0]})])
    times = times_until(0.2, 3)
    solution = reference(network, plan, times, method=method, rtol=1e-12)
    w = np.sqrt(SPRING / MASS)
    # At the top dT/dt vanishes: an error ε of T shifts the time by ε / √(2 (1 - part)) / w.
    allowed = 2e-10 / np.sqrt(2.0 * (1.0 - part)) / w
    assert solution.breaks[0].time == pytest.approx(np.arcsin(part) / w, abs=allowed)
    assert solution.strain[0] == pytest.approx(1.0, abs=1e-9)


def test_events_are_found_on_states_not_on_interpolants():
    """With large steps the interpolant of DOP853 errs by 1e-6 s here, its steps by 2e-10 s."""
    strength = 0.9 * np.sqrt(SPRING * MASS)
    network = make_net(
        [[0, 0, 0], [0.1, 0, 0]], [[0, 1]], mass=MASS, stiffness=SPRING,
        velocity=[[0, 0, 0], [1.0, 0, 0]], strength=strength,
    )  # fmt: skip
    fix = event(0.0, "fix left", {"left": [0]})
    w = np.sqrt(SPRING / MASS)
    far = when(lambda snapshot: snapshot.position[1, 0] >= 0.1 + 0.8 / w)
    solutions = [
        reference(network, make_plan(network, 0.2, [fix], triggers=triggers),
                  times_until(0.2, 2), rtol=1e-5)
        for triggers in ([], [far])
    ]  # fmt: skip
    assert solutions[0].breaks[0].time == pytest.approx(np.arcsin(0.9) / w, abs=1e-9)
    assert solutions[1].firings[0].time == pytest.approx(np.arcsin(0.8) / w, abs=1e-9)


def test_motion_that_ends_at_an_event_but_for_rounding_does_not_stall_the_steps():
    """0.1 + 0.7 is a little less than 0.8, where gravity changes and the steps land."""
    network = pair(rest=0.12, damping=DAMPER)
    move = event(0.1, "move right", {"right": [1]}, duration=0.7, by=(0.1, 0, 0), using="ramp")
    steps = []
    for change in (0.8, 0.9):
        other = event(change, "change gravity", to=(0.0, 0.0, 0.0))
        plan = make_plan(network, 1.0, [move, other])
        steps.append(reference(network, plan, times_until(1.0, 2), rtol=1e-9).effort.steps)
    assert steps[0] <= steps[1]


def test_spring_that_stays_below_its_breaking_force_does_not_break():
    network = make_net(
        [[0, 0, 0], [0.1, 0, 0]], [[0, 1]], mass=MASS, stiffness=SPRING,
        velocity=[[0, 0, 0], [1.0, 0, 0]],
        strength=(1.0 + 1e-8) * np.sqrt(SPRING * MASS),
    )  # fmt: skip
    plan = make_plan(network, 0.4, [event(0.0, "fix left", {"left": [0]})])
    solution = reference(network, plan, times_until(0.4, 3), rtol=1e-12)
    assert not solution.breaks
    assert solution.strain[0] == pytest.approx(1.0, abs=1e-3)


def test_springs_of_equal_tension_break_together_and_others_later():
    """Four equal springs hold a plate of one node that is pulled away; one is stronger."""
    corners = [[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    network = make_net(
        [[1, 0, 0], *corners], [[0, 1], [0, 2], [3, 0], [4, 0]], stiffness=SPRING,
        strength=[5.0, 5.0, 5.0, 6.0],
    )  # fmt: skip
    groups = {"corners": [1, 2, 3, 4], "hook": [0]}
    events = [
        event(0.0, "fix corners", groups),
        event(0.0, "move hook", groups, duration=1.0, by=(1.0, 0.0, 0.0), using="ramp"),
    ]
    solution = reference(network, make_plan(network, 1.0, events), times_until(1.0, 3))
    assert [entry.springs.tolist() for entry in solution.breaks] == [[0, 1, 2], [3]]
    for entry, strength in zip(solution.breaks, (5.0, 6.0), strict=True):
        length = np.sqrt(2.0) + strength / SPRING
        assert entry.time == pytest.approx(np.sqrt(length**2 - 1.0) - 1.0, abs=1e-12)


def test_springs_above_a_lowered_breaking_force_break_at_once():
    network = pair(strength=5.0)
    groups = {"both": [0, 1], "all": [0]}
    events = [
        event(0.0, "fix both", groups),
        event(0.1, "change breaking force", groups, of="all", to=0.5),
    ]
    solution = reference(network, make_plan(network, 0.2, events), times_until(0.2))
    assert [(entry.time, entry.springs.tolist()) for entry in solution.breaks] == [(0.1, [0])]
    # What a sample shows at the time of an event is the state after it.
    assert solution.force[solution.times < 0.1, 1, 0] == pytest.approx(-0.8)
    assert not solution.force[solution.times >= 0.1].any()


def test_forced_node_follows_the_closed_form():
    """m a = F sin Ωt gives x = F / (m Ω²) (Ωt - sin Ωt)."""
    from tissuec.model.profiles import TimeProfile

    network, times, angular = lonely(), times_until(1.0), 2.0 * np.pi * 3.0
    sine = (TimeProfile("sine", 0.0, np.inf, frequency=3.0),)
    push = event(0.0, "push it", {"it": [0]}, using=sine, **{"with": (0.5, 0.0, 0.0)})
    solution = reference(network, make_plan(network, 1.0, [push]), times, rtol=RTOL)
    exact = 0.5 / (MASS * angular**2) * (angular * times - np.sin(angular * times))
    assert solution.position[:, 0, 0] == pytest.approx(exact, abs=1e-9 * exact[-1])
    kinetic, work = solution.energies[:, 0], solution.energies[:, 3]
    assert work == pytest.approx(kinetic, abs=1e-9 * kinetic.max())


def test_node_in_a_viscous_medium_slows_down_exponentially():
    network, times = lonely(velocity=[[1.0, 0, 0]]), times_until(1.0)
    solution = reference(network, make_plan(network, 1.0, drag=0.05), times, rtol=RTOL)
    exact = np.exp(-0.05 / MASS * times)
    assert solution.velocity[:, 0, 0] == pytest.approx(exact, abs=1e-8)
    assert solution.energies[-1, 4] == pytest.approx(0.5 * MASS * (1 - exact[-1] ** 2))


def test_released_node_flies_on_with_the_velocity_of_its_path():
    network, groups = lonely(), {"it": [0]}
    events = [
        event(0.0, "move it", groups, duration=1.0, by=(2.0, 0.0, 0.0), using="ramp"),
        event(0.4, "release it", groups),
    ]
    solution = reference(network, make_plan(network, 1.0, events), times_until(1.0))
    assert solution.position[:, 0, 0] == pytest.approx(2.0 * solution.times, abs=1e-12)
    assert {k: v.tolist() for k, v in solution.holders[0].items()} == {"it": [0]}
    assert not solution.holders[-1]


def test_driven_node_follows_its_path_and_does_the_work_that_is_stored():
    network, groups = pair(rest=0.12, damping=DAMPER), {"left": [0], "right": [1]}
    events = [
        event(0.0, "fix left", groups),
        event(0.1, "move right", groups, duration=0.3, by=(0.05, 0.0, 0.0), using="smooth"),
    ]
    solution = reference(network, make_plan(network, 0.5, events), times_until(0.5), rtol=RTOL)
    p = np.clip((solution.times - 0.1) / 0.3, 0.0, 1.0)
    path = 0.12 + 0.05 * (10 * p**3 - 15 * p**4 + 6 * p**5)
    assert solution.position[:, 1, 0] == pytest.approx(path, abs=1e-15)
    # ∫ d v² dt over a smooth profile of length s in time T is 10/7 d s² / T.
    lost = 10.0 / 7.0 * DAMPER * 0.05**2 / 0.3
    assert solution.energies[-1, 4] == pytest.approx(lost, rel=1e-8)
    assert solution.energies[-1, 3] == pytest.approx(0.5 * SPRING * 0.05**2 + lost, rel=1e-8)


def test_cut_chain_goes_on_in_two_pieces():
    """A mass swings on a spring until the cut, and flies straight on after it."""
    network = make_net(
        [[0, 0, 0], [0.12, 0, 0]], [[0, 1]], mass=MASS, stiffness=SPRING, rest=0.1
    )  # fmt: skip
    groups = {"left": [0], "all": [0]}
    events = [event(0.0, "fix left", groups), event(0.07, "cut all", groups)]
    solution = reference(network, make_plan(network, 0.2, events), times_until(0.2), rtol=RTOL)
    w = np.sqrt(SPRING / MASS)
    before = 0.1 + 0.02 * np.cos(w * np.minimum(solution.times, 0.07))
    flown = -0.02 * w * np.sin(w * 0.07) * np.maximum(solution.times - 0.07, 0.0)
    assert solution.position[:, 1, 0] == pytest.approx(before + flown, abs=1e-10)
    stored = 0.5 * SPRING * (0.02 * np.cos(w * 0.07)) ** 2
    assert solution.energies[-1, 5] == pytest.approx(-stored, rel=1e-8)
    assert np.abs(solution.imbalance).max() < 1e-10


@pytest.mark.parametrize("method", METHODS)
def test_trigger_fires_when_its_condition_becomes_true(method):
    """A mass falls 1 m in √(2 / g); gravity is switched off then and it goes on evenly."""
    network = lonely()
    off = event(0.0, "change gravity", to=(0.0, 0.0, 0.0))
    trigger = when(lambda snapshot: snapshot.position[0, 2] <= -1.0, off)
    plan = make_plan(network, 1.0, gravity=(0.0, 0.0, -9.81), triggers=[trigger])
    solution = reference(network, plan, times_until(1.0, 6), method=method, rtol=1e-11)
    fall = np.sqrt(2.0 / 9.81)
    assert [firing.trigger for firing in solution.firings] == [0]
    # One-step methods land on the time; the others look at their interpolant.
    allowed = 1e-12 if method in ONE_STEP else 1e-7
    assert solution.firings[0].time == pytest.approx(fall, abs=allowed)
    assert solution.position[-1, 0, 2] == pytest.approx(-1.0 - 9.81 * fall * (1 - fall))


def test_trigger_that_is_true_at_the_start_fires_at_once():
    network = lonely()
    off = event(0.0, "change gravity", to=(0.0, 0.0, 0.0))
    later = event(0.3, "change gravity", to=(0.0, 0.0, -1.0))
    plan = make_plan(
        network, 1.0, gravity=(0, 0, -9.81), triggers=[when(lambda snapshot: True, off, later)]
    )
    solution = reference(network, plan, times_until(1.0))
    assert [firing.time for firing in solution.firings] == [0.0]
    assert solution.position[-1, 0, 2] == pytest.approx(-0.5 * 0.7**2)


def test_changed_gravity_bends_the_fall_from_then_on():
    network = lonely()
    change = event(0.3, "change gravity", to=(0.0, 0.0, -2.0))
    plan = make_plan(network, 1.0, [change], gravity=(0.0, 0.0, -9.81))
    solution = reference(network, plan, times_until(1.0))
    late = np.maximum(solution.times - 0.3, 0.0)
    early = np.minimum(solution.times, 0.3)
    exact = -0.5 * 9.81 * early**2 - 9.81 * 0.3 * late - late**2
    assert solution.position[:, 0, 2] == pytest.approx(exact, abs=1e-12)
    assert np.abs(solution.imbalance).max() < 1e-12


def test_chain_with_fixed_ends_swings_in_its_eigenmode():
    """ω_j = 2 √(c/m) sin(jπ / 2(N+1)), along the chain, for small amplitudes exactly linear."""
    count, mode = 9, 3
    network = chain(count + 2, mass=MASS, stiffness=SPRING)
    shape = np.sin(mode * np.pi * np.arange(count + 2) / (count + 1))
    start = make_net(
        network.position, network.springs.ends, mass=MASS, stiffness=SPRING,
        velocity=0.1 * shape[:, None] * np.array([1.0, 0.0, 0.0]),
    )  # fmt: skip
    plan = make_plan(start, 1.0, [event(0.0, "fix ends", {"ends": [0, count + 1]})])
    solution = reference(start, plan, times_until(1.0), rtol=RTOL)
    omega = 2.0 * np.sqrt(SPRING / MASS) * np.sin(mode * np.pi / (2 * (count + 1)))
    exact = 0.1 / omega * np.sin(omega * solution.times)[:, None] * shape
    moved = solution.position[:, :, 0] - network.position[:, 0]
    assert moved == pytest.approx(exact, abs=1e-8 * 0.1 / omega)


def test_implicit_methods_finish_stiff_damping_in_few_steps():
    """Rate 2 d / m = 2e6 per second: explicit steps would have to be below a microsecond."""
    network, times = pair(damping=1e4), times_until(1.0, 3)
    plan = make_plan(network, 1.0)
    for method in ("Radau", "BDF"):
        solution = reference(network, plan, times, method=method, rtol=1e-8)
        elongation = solution.position[:, 1, 0] - solution.position[:, 0, 0] - 0.1
        exact = 0.02 * np.exp(-SPRING / 1e4 * times)
        assert elongation == pytest.approx(exact, rel=1e-5)
        assert solution.effort.steps < 200


def test_reference_is_the_same_for_any_choice_of_times():
    network = pair(damping=DAMPER)
    plan = make_plan(network, 0.5)
    few = reference(network, plan, times_until(0.5, 3), rtol=RTOL)
    many = reference(network, plan, times_until(0.5, 101), rtol=RTOL)
    assert many.position[::50] == pytest.approx(few.position, abs=1e-10)


def test_default_error_per_step_is_far_below_the_promise():
    network = pair()
    assert default_rtol(make_plan(network, 1.0, tolerance=1e-4)) == pytest.approx(1e-7)
    assert default_rtol(make_plan(network, 1.0, tolerance=1e-12)) == 1e-13
    assert default_rtol(make_plan(network, 1.0, tolerance=None, step=1e-3)) < 1e-6


def test_solver_that_cannot_go_on_says_where():
    network = lonely()
    push = event(0.2, "push it", {"it": [0]}, **{"with": (np.nan, 0.0, 0.0)})
    with pytest.raises(ReferenceFailure, match=r"SciPy's DOP853 failed at 0\.2 s"):
        reference(network, make_plan(network, 1.0, [push]), times_until(1.0))


def test_full_matrices_that_would_fill_the_memory_are_refused():
    network = make_net(np.zeros((3000, 3)), np.zeros((0, 2)))
    with pytest.raises(ReferenceFailure, match="LSODA keeps a full matrix"):
        reference(network, make_plan(network, 1.0), times_until(1.0, 2), method="LSODA")
