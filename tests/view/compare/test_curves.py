"""Logs of two runs, by hand and of runs."""

import numpy as np
import pytest

from tests.view.compare.scenes import AMPLITUDE, OSCILLATOR
from tissuec.results.tables import Jumps
from tissuec.view.compare.over_time import compare_logs

pytestmark = pytest.mark.filterwarnings("ignore::tissuec.TissueWarning")  # idle sets


class Table:
    """A log by hand."""

    def __init__(self, time, value, columns=("value",), unit="N"):
        self.time, self.value = np.array(time, float), np.array(value, float)
        self.columns, self.unit = columns, unit
        none = np.zeros((0, len(columns)))
        self.jumps = Jumps(np.zeros(0), none, none)

    def with_jumps(self):
        return self.jumps.within(self.time, self.value)


def test_straight_lines_at_other_times_are_compared_exactly():
    a, b = np.linspace(0, 1, 11), np.linspace(0.15, 1.2, 8)
    (curve,) = compare_logs("f", Table(a, 2 * a[:, None]), Table(b, 3 * b[:, None]))
    # 3 t - 2 t = t is largest at the end of what both have.
    assert (curve.time, curve.difference) == (1.0, pytest.approx(1.0))
    assert (curve.first, curve.last, curve.interpolated) == (0.15, 1.0, True)
    assert curve.scale == pytest.approx(3.0) and curve.relative == pytest.approx(1 / 3)


def test_between_rows_a_jump_is_no_slope():
    """A force of 1 N ends at 0.5 s; both logs have rows on either side, at other times."""
    one, other = (Table(t, np.array(t)[:, None] < 0.5) for t in ([0, 0.4, 1], [0, 0.7, 1]))
    (sloping,) = compare_logs("f", one, other)
    for table in (one, other):
        table.jumps = Jumps(np.array([0.5]), np.ones((1, 1)), np.zeros((1, 1)))
    (jumping,) = compare_logs("f", one, other)
    assert (sloping.is_same, jumping.is_same) == (False, True)


def test_times_that_differ_by_rounding_are_the_same():
    time = np.linspace(0, 1, 11)
    one, other = Table(time, time[:, None]), Table(time * (1 + 1e-15), time[:, None])
    (curve,) = compare_logs("f", one, other)
    assert curve.is_same and not curve.interpolated and curve.moments == 11


def test_vectors_differ_by_the_length_of_their_difference():
    axes = ("x", "y", "z")
    one = Table([0, 1], [[0, 0, 0], [3, 0, 0]], axes)
    other = Table([0, 1], [[0, 0, 0], [0, 4, 0]], axes)
    (curve,) = compare_logs("f", one, other)
    assert (curve.difference, curve.scale, curve.time) == (5.0, 4.0, 1.0)
    assert curve.relative == 1.25


def test_columns_are_known_by_their_names():
    one = Table([0, 1], [[1, 2], [3, np.nan]], (7, 9))
    other = Table([0, 1], [[2, 1], [5, 3]], (9, 7))
    (curve,) = compare_logs("t", one, other)
    assert (curve.difference, curve.missing) == (0.0, 1)
    assert not curve.is_same
    other.columns = (8, 7)
    (curve,) = compare_logs("t", one, other)
    assert curve.is_same


def test_what_is_no_number_in_both_is_the_same():
    one = Table([0, 1], [[1.0], [np.nan]])
    (curve,) = compare_logs("t", one, one)
    assert curve.is_same and curve.scale == 1.0


@pytest.mark.parametrize(
    "other",
    [
        Table([], np.zeros((0, 1))),
        Table([5, 6], [[1], [1]]),
        Table([0], [[1]], ("y",)),
    ],
    ids=["no rows", "other times", "other columns"],
)
def test_logs_that_share_nothing_are_not_compared(other):
    assert list(compare_logs("f", Table([0, 1], [[1], [2]]), other)) == []


def test_logs_and_energies_of_runs_are_compared(compared, told):
    other = OSCILLATOR.replace("40 N/m", "44 N/m").replace("position of bob", "speed of pair")
    found = compared(OSCILLATOR, other, run=True)
    curves = {curve.name: curve for curve in found.curves.both}
    # Energies begin with ½ c A², so that they differ by ½ 4 N/m A² at least.
    assert curves["elastic energy"].difference >= 0.5 * 4.0 * AMPLITUDE**2
    assert found.curves.only_a == ("position of bob",)
    assert found.curves.only_b == ("speed of pair",)
    assert "only in b: speed of pair" in told(found)


def test_times_that_somebody_could_mean_are_not_taken_for_the_same():
    time = np.linspace(0, 1, 11)
    shifted = time + 1e-6 * (time > 0)
    (curve,) = compare_logs("f", Table(time, time[:, None]), Table(shifted, shifted[:, None]))
    assert curve.interpolated and curve.difference < 1e-9
