"""Conditions on the way: looking at many steps together changes nothing."""

import numpy as np
import pytest

from tests.engine.running import Bench, lifted_tube, pair
from tissuec.core.structs import replace
from tissuec.engine import watching

NODE = 100  # of the waist, which is lifted by 3 mm
METHODS = {
    "velocity verlet": 3e-2,
    "rkn4": 1e-3,
    "dop853": 1e-3,
    "srkn11": 1e-3,
    "esdirk43": 1e-3,
}


def height(position):
    return position[..., NODE, 2] - position[..., 0, 2]


def lifted(method, *, threshold, surveyed, more=False, spacing=0.0, seen=None):
    """Return a run that stops where a node passes a height, and goes on, and what was asked.

    Args:
        seen: Takes the times of all surveys.
    """
    bench = lifted_tube(0.3, method=method, tolerance=METHODS[method], ledger=True)
    bench.engine.method = replace(bench.engine.method, spacing=spacing)
    start = height(bench.state.position)
    asked, ends = [], []

    def watch(time, position, velocity):
        asked.append(time)
        return height(position) - start > threshold

    def survey(time, position, velocity):
        if seen is not None:
            seen.extend(time.tolist())
        return more or bool((height(position) - start > threshold).any())

    while not ends or ends[-1].kind == "triggered":
        condition = None if ends else watch
        vectorised = survey if surveyed and not ends else None
        ends.append(bench.engine.advance(bench.state, 0.3, condition, None, vectorised))
    bench.engine.finish(bench.state)
    return bench.ran(ends[0]), [(end.kind, end.time) for end in ends], asked


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("threshold", [1e-3, 1.0], ids=["passed", "never passed"])
def test_looking_at_many_steps_together_changes_nothing(method, threshold):
    one, ends, asked = lifted(method, threshold=threshold, surveyed=False)
    other, same, fewer = lifted(method, threshold=threshold, surveyed=True)
    assert ends == same
    assert ends[0][0] == ("triggered" if threshold < 1.0 else "reached")
    assert len(fewer) < 0.5 * len(asked)
    for part in ("time", "position", "velocity", "work", "dissipated", "error"):
        assert np.array_equal(getattr(one, part), getattr(other, part))
    assert one.engine.statistics == other.engine.statistics


def test_what_may_hold_and_does_not_is_looked_at_closely_and_left():
    one, ends, asked = lifted("dop853", threshold=1.0, surveyed=False)
    other, same, closely = lifted("dop853", threshold=1.0, surveyed=True, more=True)
    assert ends == same
    assert np.array_equal(one.position, other.position)
    assert closely == asked


def test_nets_of_many_nodes_are_looked_at_step_by_step(monkeypatch):
    monkeypatch.setattr(watching, "GLANCED", 1000)
    _, _, asked = lifted("dop853", threshold=1.0, surveyed=False)
    _, _, each = lifted("dop853", threshold=1.0, surveyed=True)
    assert each == asked


@pytest.mark.parametrize("method", ["rkn4", "velocity verlet"])
def test_looking_into_some_of_many_short_steps_changes_nothing(method):
    every_time, some = [], []
    one, ends, _ = lifted(method, threshold=1e-3, surveyed=True, seen=every_time)
    steps = one.engine.statistics.accepted
    spacing = 10.0 * 0.3 / steps  # of ten steps
    other, same, _ = lifted(method, threshold=1e-3, surveyed=True, spacing=spacing, seen=some)
    assert ends == same and ends[0][0] == "triggered"
    assert np.array_equal(one.position, other.position)
    # Once for ten steps, and four times for each of those before the condition holds.
    assert len(some) < 0.5 * len(every_time)
    # A stretch without a state ends with the first step after the distance; in steps that are
    # not twice as long, only the end is looked into.
    longest = one.engine.statistics.largest
    assert (np.diff(np.sort(some)) < 2.0 * spacing + longest).all()


@pytest.mark.parametrize(("spacing", "looks"), [(0.0, 4), (0.4, 2), (0.6, 1), (1.5, 0.5)])
def test_looks_into_steps_are_as_dense_as_was_asked(spacing, looks):
    every_time = []
    step = 0.3 / 2048
    bench = lifted_tube(0.3, method="velocity verlet", step=step)
    bench.engine.method = replace(bench.engine.method, spacing=spacing * step)

    def survey(time, position, velocity):
        every_time.extend(time.tolist())
        return False

    bench.engine.advance(bench.state, 0.3, lambda *_: False, None, survey)
    # Calls begin with a state, and stretches end with one.
    assert len(every_time) == pytest.approx(2048 * looks, rel=0.02)
    assert every_time[-1] == 0.3


def swinging(*, since, spacing, until=1.0, strength=np.inf):
    """Return why a swinging pair stops, and when, if a condition holds from some time on.

    Args:
        since: That time [s].
        until: When it stops otherwise [s].
    """
    net = pair(stretch=-0.1, strength=strength)
    bench = Bench(net, 1.0, method="rkn4", tolerance=1e-8, ruptures=True)
    bench.engine.method = replace(bench.engine.method, spacing=spacing)

    def watch(time, position, velocity):
        return time > since

    def survey(time, position, velocity):
        return bool((time > since).any())

    end = bench.engine.advance(bench.state, until, watch, None, survey)
    return end.kind, end.time


@pytest.mark.parametrize("spacing", [0.0, 0.1])
def test_a_condition_that_holds_at_the_end_of_a_stretch_is_seen_there(spacing):
    since = 0.5 * (1.0 - 1e-6)  # within the last step
    assert swinging(since=since, spacing=spacing, until=0.5) == (
        "triggered",
        pytest.approx(since, rel=1e-6),
    )


def test_a_condition_just_before_a_rupture_is_seen_in_a_step_without_states():
    rupture = swinging(since=1.0, spacing=0.0, strength=6.0)
    assert rupture[0] == "ruptured"
    # Of half a step, a hundredth of the distance between two states.
    before = rupture[1] * (1.0 - 1e-4)
    for spacing in (0.0, 0.1):
        assert swinging(since=1.0, spacing=spacing, strength=6.0) == rupture
        kind, time = swinging(since=before, spacing=spacing, strength=6.0)
        assert kind == "triggered"
        assert time == pytest.approx(before, rel=1e-6)
