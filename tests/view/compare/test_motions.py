"""Two runs: motions in closed form, events, and what is promised."""

import json
import signal

import numpy as np
import pytest

import tissuec
from tests.api.scenes import PULL
from tests.view.compare.scenes import AMPLITUDE, FALLING, OSCILLATOR, TEARING, omega
from tissuec.core.data import as_data
from tissuec.view.compare.comparison import compare
from tissuec.view.compare.report import as_dict
from tissuec.view.compare.sides import of_result

pytestmark = pytest.mark.filterwarnings("ignore::tissuec.TissueWarning")  # idle sets

STIFFER = OSCILLATOR.replace("40 N/m", "44 N/m")


def every(text, milliseconds):
    """Return a scene whose frames are further apart or closer together."""
    return text.replace("trajectory every 10 ms", f"trajectory every {milliseconds:g} ms")


def apart(times):
    """Return how far the two oscillators are apart [m]."""
    return AMPLITUDE * np.abs(np.cos(omega(40.0) * times) - np.cos(omega(44.0) * times))


def test_a_run_and_itself_again_differ_in_nothing(compared, told):
    found = compared(OSCILLATOR, OSCILLATOR, run=True)
    assert found.is_same and found.motion.verdict == "agree"
    assert told(found).endswith("no differences (text, 2 nodes, 1 spring, 31 frames)")


def test_two_oscillators_part_as_their_cosines_do(compared, told):
    found = compared(OSCILLATOR, STIFFER, run=True)
    motion = found.motion
    times = np.arange(31) * 0.01
    # Both keep 1e-6 of their displacement, which is 2 mm at most.
    assert motion.distance == pytest.approx(apart(times), abs=2 * 1e-6 * 2e-3)
    assert motion.times[motion.worst] == pytest.approx(times[apart(times).argmax()])
    assert set(motion.node[1:]) == {1}
    assert motion.verdict == "differ" and motion.parting == pytest.approx(0.01)
    assert "node 2 of pair" in told(found)


def test_tolerances_tell_whether_two_runs_agree(compared):
    motion = compared(OSCILLATOR, OSCILLATOR.replace("1e-6", "1e-3"), run=True).motion
    assert motion.verdict == "agree" and not motion.is_same
    assert (motion.tolerance_a, motion.tolerance_b) == (1e-6, 1e-3)
    moved = AMPLITUDE * np.maximum.accumulate(1 - np.cos(omega(40.0) * np.arange(31) * 0.01))
    # Displacements are themselves known to the coarser tolerance.
    assert motion.allowed[1:] == pytest.approx(1.001e-3 * moved[1:], rel=2e-3)
    assert (motion.distance <= motion.allowed).all()


def test_what_is_drawn_elsewhere_is_nothing_that_a_tolerance_allows(compared):
    motion = compared(OSCILLATOR, OSCILLATOR.replace("2 11 }", "2 11.00001 }"), run=True).motion
    assert motion.verdict == "differ" and motion.parting == 0.0
    assert motion.distance[0] == pytest.approx(1e-8, rel=1e-6)


def test_between_frames_a_cubic_meets_a_parabola(compared, told):
    found = compared(FALLING, every(FALLING, 7), run=True)
    motion = found.motion
    assert motion.interpolated and len(motion.times) > 60
    # Rounding, and what both methods promise of a way of 44 cm.
    assert motion.largest < 2e-9 * 0.45
    assert motion.open.max() < 1e-8
    assert motion.verdict in ("agree", "cannot tell")
    assert motion.is_whole  # its frames end at 294 ms, but the run does not
    assert "positions were interpolated by cubics" in told(found)


@pytest.mark.parametrize("milliseconds", [5.0, 7.0, pytest.param(13.0, marks=pytest.mark.slow)])
def test_between_frames_a_cubic_is_as_far_from_a_cosine_as_its_bound_says(
    compared, milliseconds
):
    """|x - H| <= h⁴ / 384 max|d⁴x/dt⁴| (C. Hermite), which ``open`` may not be below."""
    motion = compared(OSCILLATOR, every(OSCILLATOR, milliseconds), run=True).motion
    spans = 1e-3 * np.array([10.0, milliseconds])
    bound = ((spans * omega(40.0)) ** 4 / 384 * AMPLITUDE).sum()
    promised = 2 * 1e-6 * 2e-3
    assert 0.0 < motion.largest <= bound + promised
    assert (motion.distance <= motion.open + promised).all()
    assert motion.verdict in ("agree", "cannot tell")
    assert motion.parting is None


def test_a_change_shows_also_where_frames_differ(compared):
    motion = compared(OSCILLATOR, every(STIFFER, 7), run=True).motion
    assert motion.distance == pytest.approx(apart(motion.times), abs=float(motion.open.max()))
    assert motion.verdict == "differ" and 0.0 < motion.parting < 0.1


def test_times_that_both_have_are_compared_as_they_are(compared):
    motion = compared(OSCILLATOR, every(OSCILLATOR, 5), run=True).motion
    both = np.abs(motion.times / 0.01 - np.round(motion.times / 0.01)) < 1e-9
    assert both.sum() == 31 and len(motion.times) == 61
    assert not motion.open[both].any() and motion.open[~both].all()
    assert not motion.distance[both].any()


def test_frames_in_single_precision_are_known_as_well_as_they_are_kept(compared):
    fine = OSCILLATOR.replace("1e-6", "1e-10")
    single = fine.replace("trajectory every", "precision is single; trajectory every")
    found = compared(fine, single, run=True)
    assert 0.0 < found.motion.largest < found.motion.open.max() < 1e-8
    assert found.motion.verdict == "cannot tell"
    facts = [(fact.name, fact.a, fact.b) for fact in found.provenance]
    assert ("precision", "float64", "float32") in facts


def test_a_fixed_step_promises_nothing(compared, told):
    fixed = "integrator is velocity verlet; step = 1 ms"
    found = compared(OSCILLATOR, OSCILLATOR.replace("tolerance = 1e-6", fixed), run=True)
    assert found.motion.verdict == "nothing promised"
    assert "b has no tolerance, because its step is fixed" in told(found)


def test_what_frames_of_one_do_not_show_is_left_out_and_said(compared, told):
    part = PULL.replace("trajectory every", "trajectory of bob every")
    found = compared(PULL, part, run=True)
    assert (found.motion.nodes, found.motion.nodes_a, found.motion.nodes_b) == (1, 3, 1)
    assert not found.motion.is_whole and not found.motion.largest
    assert "1 node at 21 times, 0 s to 200 ms (a has 3 nodes, b 1)" in told(found)


def test_runs_without_common_frames_are_not_compared(compared, told):
    none = PULL.replace("trajectory every 10 ms;", "")
    assert compared(none, PULL, run=True).motion == "a has no frames"
    assert compared(PULL, none, run=True).motion == "b has no frames"
    wall = PULL.replace("trajectory every", "trajectory of wall every")
    bob = PULL.replace("trajectory every", "trajectory of bob every")
    found = compared(wall, bob, run=True)
    assert found.motion == "the frames of both have no common node"
    assert "not compared: the frames of both have no common node" in told(found)


def test_comparing_the_other_way_round_gives_the_same_numbers():
    other = PULL.replace("40 N/m", "44 N/m").replace("0.15 s", "0.16 s")
    with tissuec.run(PULL) as one, tissuec.run(other) as two:
        there = compare(of_result(one), of_result(two))
        back = compare(of_result(two), of_result(one))
        assert np.array_equal(there.motion.distance, back.motion.distance)
        assert [c.relative for c in there.changes] == [c.relative for c in back.changes]
        curves = [[c.difference for c in found.curves.both] for found in (there, back)]
        assert curves[0] == curves[1]


@pytest.mark.usefixtures("interruptible")
def test_an_unfinished_run_is_compared_as_far_as_it_got(tmp_path, told):
    def press(time):
        if time > 0.1:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        tissuec.run(PULL, out=tmp_path / "a.vtkhdf", progress=press)
    with tissuec.run(PULL) as whole, tissuec.load(tmp_path / "a.partial.vtkhdf") as begun:
        found = compare(of_result(whole), of_result(begun))
        motion = found.motion
        assert motion.verdict == "agree" and not motion.is_whole and not motion.largest
        assert motion.times[-1] < 0.2
        assert "a ends at 200 ms, b at" in told(found)
        assert "outcome: done" in told(found)


# --- events -----------------------------------------------------------------------------------


def test_an_order_that_comes_later_is_the_same_order(compared, told):
    found = compared(PULL, PULL.replace("0.15 s", "0.16 s"), run=True)
    (meeting,) = [one for one in found.logged_events.both if not one.is_same]
    assert (meeting.a.kind, meeting.shift) == ("cut", pytest.approx(0.01))
    assert "150 ms -> 160 ms: cut far spring" in told(found)


def test_an_order_that_is_written_anew_meets_the_former_one(compared, told):
    found = compared(PULL, PULL.replace("pull * way", "0.5 * pull * way"), run=True)
    assert "move bob by pull * way using smooth profile -> move bob by 0.5" in told(found)
    assert not found.logged_events.only_a and not found.logged_events.only_b


def test_an_order_of_one_alone_is_told(compared, told):
    found = compared(PULL, PULL.replace("  at 0.15 s: cut far spring\n", ""), run=True)
    assert [entry.kind for entry in found.logged_events.only_a] == ["cut"]
    assert "only in a: 150 ms cut far spring" in told(found)


def test_springs_that_break_at_other_times_or_not_are_told_one_by_one(compared, told):
    """The tension is 40 N/m 20 mm/s t = 0.8 N/s t, so that springs break at F / (0.8 N/s)."""
    found = compared(TEARING, TEARING.replace("1 2 40; 1 2 60", "1 2 44; 1 2 600"), run=True)
    (met,) = [one for one in found.logged_events.both if one.a.kind == "rupture"]
    assert (met.a.time, met.b.time) == (pytest.approx(0.05), pytest.approx(0.055))
    (alone,) = found.logged_events.only_a
    assert (alone.kind, alone.spring, alone.time) == ("rupture", 1, pytest.approx(0.075))
    text = told(found)
    assert "rupture: 2 springs in a, 1 in b, 1 of them in both" in text
    assert "times differ by up to 5 ms: spring 1 of row, 50 ms -> 55 ms" in text
    assert "only in a: spring 2 of row at 75 ms" in text


def test_a_spring_that_one_alone_has_breaks_in_one_alone(compared):
    more = TEARING.replace("1 2 40; 1 2 60", "1 2 40; 1 2 60; 1 2 30")
    found = compared(TEARING, more, run=True)
    (alone,) = found.logged_events.only_b
    assert alone.spring == 2 and not found.logged_events.only_a


# --- as data ----------------------------------------------------------------------------------


def test_a_scene_and_its_result_differ_in_nothing_but_what_was_set(scene):
    with tissuec.run(PULL) as run:
        assert compare(scene(PULL), of_result(run)).is_same
    with tissuec.run(PULL, stretch_time="0.05 s") as run:
        found = compare(scene(PULL), of_result(run))
        (fact,) = found.settings
        assert (fact.name, fact.b) == ("overrides", ["stretch time = 0.05 s"])
        assert found.motion is None and found.logged_events is None


def test_all_of_it_is_plain_data(compared):
    found = compared(PULL, every(PULL.replace("40 N/m", "44 N/m"), 7), run=True)
    data = json.loads(json.dumps(as_data(as_dict(found)), allow_nan=False))
    assert data["motion"]["verdict"] == "differ" and data["motion"]["interpolated"]
    assert data["parameters"][0]["dimension"] == "N/m"
    assert data["parameters"][0]["from_a"][0]["place"] == "scene:5"
    assert data["same"] is False


def test_springs_that_each_has_for_itself_are_not_the_same_however_numbered(compared):
    cut = "at 0.15 s: cut far spring"
    rest = PULL.replace("7 9 10 }", "7 9 10; 4 9 20 }").replace("x > 12 mm", "length > 15 mm")
    other = PULL.replace("{ 4 7 10; 7 9 10 }", "{ 7 9 10; 4 7 10; 4 7 10 }")
    other = other.replace("x > 12 mm", "x < 6 mm")
    found = compared(rest, other, run=True)
    (meeting,) = [one for one in found.logged_events.both if one.a.cause in cut]
    assert not meeting.is_same and not set(meeting.a.springs) & set(meeting.b.springs)
