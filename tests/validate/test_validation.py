"""Verdicts: kept, broken, undecided, and nothing promised."""

import signal

import numpy as np
import pytest

from tests.hand_net import make_net
from tests.hand_plan import event, make_plan
from tests.validate.scenes import compiled_scene, quantity, rod, silent, validated
from tissuec.compiler.compile import Compiled
from tissuec.core.structs import replace
from tissuec.validate import validation as module
from tissuec.validate.engine_run import MOST_ROWS, observe, output_times, thinned
from tissuec.validate.reference import reference
from tissuec.validate.uncertainty import known_reference, shaken
from tissuec.validate.validation import MOST, validate

TORN = "from 0.075 s to 0.15 s: move right by (6, 0, 0) mm using constant speed"
PUSHED = "when force(right) > 0.035 N: push right with (0, 0, 0.02) N"


@pytest.mark.parametrize("tolerance", ["1e-2", "1e-4", "1e-8"])
def test_promise_of_a_small_scene_is_kept(tolerance):
    found = validated(rod(method=f"integrator is automatic; tolerance = {tolerance}"))
    assert found.verdict == "kept"
    assert not found.reasons
    assert 0.0 < quantity(found, "position").error <= float(tolerance)
    assert found.comparison.known.uncertainty[-1] <= 0.1 * float(tolerance)


@pytest.mark.parametrize("method", ["DOP853", "RK45", "Radau", "BDF", "LSODA"])
def test_every_solver_comes_to_the_same_errors(method):
    found = validated(rod(method="integrator is automatic; tolerance = 1e-2"), method=method)
    assert found.verdict == "kept"
    assert found.comparison.known.reference.method == method


def test_ruptures_and_triggers_of_both_are_matched():
    found = validated(rod(rupture="allowed", extra=f"{TORN}\n{PUSHED}"))
    assert found.verdict == "kept"
    comparison = found.comparison
    for matching in (comparison.ruptures, comparison.triggers):
        assert matching.run == matching.reference >= 1
        assert matching.in_order
        assert not matching.misses
        assert 0.0 < matching.error < 1e-5  # [s]; positions to 1e-4 of a motion over 0.1 s


def test_fixed_step_promises_nothing_and_is_told_so():
    found = validated(rod(method="integrator is velocity verlet; step = 0.1 ms"))
    assert found.verdict == "nothing promised"
    assert "fixed step has no tolerance" in found.reasons[0]
    assert quantity(found, "position").bound is None
    assert 1e-8 < quantity(found, "position").error < 1e-2


def test_run_that_diverges_is_told():
    found = validated(rod(method="integrator is velocity verlet; step = 20 ms"))
    assert found.verdict == "diverged"
    assert found.comparison is None
    assert "diverged" in found.reasons[0]


def tampered(monkeypatch, change):
    """Let every run be changed after the fact."""
    monkeypatch.setattr(module, "observe", lambda *args: change(observe(*args)))


def test_positions_that_are_wrong_by_more_than_promised_are_caught(monkeypatch):
    def shift(run):
        position = run.position.copy()
        position[17, 2, 1] += 2e-4 * np.abs(position - position[0]).max()
        return replace(run, position=position)

    tampered(monkeypatch, shift)
    found = validated(rod())
    assert found.verdict == "broken"
    worst = quantity(found, "position")
    assert (worst.node, worst.time) == (2, pytest.approx(found.run.times[17]))
    assert "the error of position is" in found.reasons[0]


def test_energy_that_is_lost_is_caught_even_where_positions_are_right(monkeypatch):
    def leak(run):
        return replace(run, imbalance=run.imbalance - 2e-4 * run.scale)

    tampered(monkeypatch, leak)
    found = validated(rod())
    assert found.verdict == "broken"
    assert quantity(found, "energy balance").error == pytest.approx(2e-4, rel=1e-2)
    assert quantity(found, "position").is_kept


@pytest.fixture(scope="module")
def torn_reference():
    """Return the reference of the rod that tears."""
    return validated(rod(rupture="allowed", extra=TORN)).comparison.known


@pytest.fixture
def torn_once(torn_reference, monkeypatch):
    """Let that rod, whose engine alone is changed, not be solved again."""
    monkeypatch.setattr(module, "known_reference", lambda *_, **__: torn_reference)


@pytest.mark.usefixtures("torn_once")
@pytest.mark.parametrize("what", ["gravity", "stiffness", "damping", "strength"])
def test_engine_that_simulates_another_scene_is_caught(monkeypatch, what):
    """Any parameter wrong by 1 % shows, also where the energies of the wrong scene balance."""

    def wrongly(network, plan, times, progress):
        if what == "gravity":
            return observe(network, replace(plan, gravity=1.01 * plan.gravity), times, progress)
        changed = network.with_arrays({what: 1.01 * network.array(what)})
        return observe(changed, plan, times, progress)

    monkeypatch.setattr(module, "observe", wrongly)
    found = validated(rod(rupture="allowed", extra=TORN))
    assert found.verdict == "broken"


@pytest.mark.usefixtures("torn_once")
def test_springs_that_break_in_one_solution_only_are_named(monkeypatch):
    def unbreakable(network, plan, times, progress):
        whole = replace(plan, breakable=False)
        return observe(network, whole, times, progress)

    monkeypatch.setattr(module, "observe", unbreakable)
    found = validated(rod(rupture="allowed", extra=TORN))
    assert found.verdict == "broken"
    misses = found.comparison.ruptures.misses
    assert len(misses) == found.comparison.ruptures.reference > 0
    assert not any(miss.in_run or miss.is_tie for miss in misses)
    assert any("breaks at" in reason and "spring" in reason for reason in found.reasons)


def test_near_tie_leaves_the_verdict_open_from_there_on(monkeypatch):
    """A breaking force that is 1 + 1e-7 of the largest tension, in the run 1 - 1e-7 of it."""
    swinging = swing(strength=np.inf)
    top = validate(swinging, method="DOP853", rtol=1e-11, progress=silent)
    peak = float(np.abs(top.comparison.known.reference.force[:, 0, 0]).max())

    def weaker(network, plan, times, progress):
        return observe(
            network.with_arrays({"strength": (1 - 2e-7) * network.springs.strength}),
            plan,
            times,
            progress,
        )

    monkeypatch.setattr(module, "observe", weaker)
    found = validate(swing((1 + 1e-7) * peak), method="DOP853", rtol=None, progress=silent)
    assert found.verdict == "undecided"
    (miss,) = found.comparison.ruptures.misses
    assert miss.is_tie
    assert any("a near tie" in reason for reason in found.reasons)
    assert found.comparison.judged < miss.time
    assert quantity(found, "position").is_kept


def swing(strength):
    """Return a mass that swings on a spring, with output at the time of largest tension."""
    network = make_net(
        [[0, 0, 0], [1, 0, 0]], [[0, 1]], mass=0.01, stiffness=40.0, strength=strength,
        velocity=[[0, 0, 0], [0.5, 0, 0]],
    )  # fmt: skip
    quarter = 0.5 * np.pi * np.sqrt(0.01 / 40.0)
    plan = make_plan(
        network, 3.0 * quarter, [event(0.0, "fix left", {"left": [0]})],
        every=quarter / 8.0, tolerance=1e-4, integrator="automatic",
    )  # fmt: skip
    return Compiled(None, network, plan, None)


def test_motion_that_amplifies_rounding_errors_is_undecided_and_told_so():
    """A straight chain, pressed together, bends aside: whereto is decided by rounding."""
    along = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    position = np.outer(np.arange(9), along)
    network = make_net(
        position, [(i, i + 1) for i in range(8)], mass=1e-3, stiffness=10.0, rest=1.5
    )
    plan = make_plan(
        network, 0.8, [event(0.0, "fix ends", {"ends": [0, 8]})], every=0.1, tolerance=1e-4
    )
    scene = Compiled(None, network, plan, None)
    found = validate(scene, method="DOP853", rtol=None, progress=silent)
    assert found.verdict == "undecided"
    assert found.comparison.known.is_sensitive
    assert found.comparison.judged < 0.8
    text = " ".join(found.reasons)
    assert "the reference itself is accurate to only" in text
    assert "amplifies rounding errors" in text


def test_coarse_reference_makes_a_verdict_undecided_not_wrong():
    method = "integrator is automatic; tolerance = 1e-8"
    found = validated(rod(method=method), method="RK23", rtol=1e-4)
    assert found.verdict == "undecided"
    assert "a smaller --rtol or another --method may be more accurate" in found.reasons


def test_uncertainty_of_a_reference_covers_its_error():
    """Also where close output times, and not errors, rule the steps."""
    scene = compiled_scene(rod())
    close = np.linspace(0.0, 0.15, 61)
    finest = reference(scene.network, scene.plan, close, rtol=1e-12)
    for every in (20, 1):
        known = known_reference(
            scene.network, scene.plan, close[::every], method="RK45", rtol=1e-5, progress=silent
        )
        apart = np.abs(known.reference.position - finest.position[::every]).max()
        error = apart / finest.displacement[-1]
        assert 0.0 < error <= known.uncertainty[-1] < 1e4 * error


def test_symmetry_does_not_hide_how_sensitive_a_motion_is():
    """A chain that is pressed together and bent by a billionth: it bends on at a known side."""
    number = np.arange(9.0)
    bend = 1e-9 * np.sin(number)
    network = make_net(
        np.stack([number, bend, 0.5 * bend], axis=-1),
        [(i, i + 1) for i in range(8)],
        mass=1e-3,
        stiffness=10.0,
        rest=1.5,
    )
    plan = make_plan(network, 2.0, [event(0.0, "fix ends", {"ends": [0, 8]})], tolerance=1e-4)
    known = known_reference(
        network, plan, np.linspace(0.0, 2.0, 11), method="DOP853", rtol=1e-12, progress=silent
    )
    assert known.uncertainty[-1] > 1e-3


def test_shaken_network_differs_by_rounding_only():
    network = compiled_scene(rod()).network
    other = shaken(network)
    assert (other.mass != network.mass).any()
    assert (other.springs.rest != network.springs.rest).any()
    assert other.mass == pytest.approx(network.mass, rel=1e-15)
    assert other.springs.rest == pytest.approx(network.springs.rest, rel=1e-15)


def test_reference_is_made_finer_until_it_can_judge():
    method = "integrator is automatic; tolerance = 1e-7"
    found = validated(rod(method=method), method="RK45")
    assert found.verdict == "kept"
    assert found.comparison.known.reference.rtol < 1e-10


def test_forces_are_told_with_what_positions_within_the_promise_can_do():
    found = validated(rod())
    force = quantity(found, "force of right")
    # Σ c of one spring at the right end, times tolerance and largest displacement.
    reach = 40.0 * 1e-4 * found.comparison.known.reference.displacement[-1]
    assert force.expected == pytest.approx(reach / force.scale)
    assert force.error < force.expected
    assert force.bound is None


def test_every_output_time_is_compared_unless_there_are_too_many():
    scene = compiled_scene(rod())
    assert output_times(scene.network, scene.plan) == pytest.approx(0.005 * np.arange(31))
    many = np.linspace(0.0, 1.0, 100_001)
    some = thinned(many, 10)
    assert len(some) <= MOST_ROWS
    assert (some[0], some[-1]) == (0.0, 1.0)
    assert np.isin(some, many).all()


def test_scene_without_output_is_compared_all_the_same():
    text = rod().partition("output")[0]
    found = validated(text)
    assert found.verdict == "kept"
    assert len(found.run.times) > 50


def test_long_lists_of_differences_are_cut_short(monkeypatch):
    whole = swing(0.01)
    nodes = np.repeat([[0.0, 0, 0], [1.0, 0, 0]], 8, axis=0)
    nodes[:, 1] = np.tile(np.arange(8), 2)
    network = make_net(
        nodes, [(i, i + 8) for i in range(8)], mass=0.01, stiffness=40.0,
        strength=np.linspace(0.01, 0.02, 8), velocity=nodes[:, :1] * [[0.5, 0.0, 0.0]],
    )  # fmt: skip
    scene = Compiled(None, network, whole.plan, None)

    def unbreakable(network, plan, times, progress):
        return observe(network, replace(plan, breakable=False), times, progress)

    monkeypatch.setattr(module, "observe", unbreakable)
    found = validate(scene, method="DOP853", rtol=None, progress=silent)
    assert len(found.comparison.ruptures.misses) == 8
    assert sum("breaks at" in reason for reason in found.reasons) == MOST
    assert f"and {8 - MOST} more such differences" in found.reasons


def test_ctrl_c_during_the_run_ends_it(monkeypatch):
    from tissuec.validate import engine_run

    class Interrupted:
        kind = "interrupted"
        signal = signal.SIGINT

    monkeypatch.setattr(engine_run, "run", lambda *args, **options: Interrupted())
    with pytest.raises(KeyboardInterrupt):
        validated(rod())
