"""Arrays of numbers that differ, or are evenly spread; their medians."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tissuec.core.arrays import distinct, evenly, typical


@pytest.mark.parametrize("most", [2, 3, 7, 100, 101, 1000])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 101, 202])
def test_numbers_are_spread_from_first_to_last_without_repeats(count, most):
    found = evenly(count, most)
    assert len(found) == min(count, most)
    assert (np.diff(found) > 0).all()
    assert np.ptp(np.diff(found)) <= 1 if len(found) > 1 else True
    assert not count or (found[0] == 0 and found[-1] == (count - 1 if len(found) > 1 else 0))


@given(arrays(np.int64, st.integers(0, 40), elements=st.integers(-5, 5)))
def test_different_values_are_those_of_numpy(values):
    assert np.array_equal(distinct(values), np.unique(values))


@given(arrays(float, st.integers(1, 40), elements=st.floats(-5.0, 5.0)))
def test_typical_value_is_the_higher_median(values):
    assert typical(values) == np.quantile(values, 0.5, method="higher")
