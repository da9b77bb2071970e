"""Arrays of numbers that are evenly spread."""

import numpy as np
import pytest

from tissuec.core.arrays import evenly


@pytest.mark.parametrize("most", [2, 3, 7, 100, 101, 1000])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 101, 202])
def test_numbers_are_spread_from_first_to_last_without_repeats(count, most):
    found = evenly(count, most)
    assert len(found) == min(count, most)
    assert (np.diff(found) > 0).all()
    assert np.ptp(np.diff(found)) <= 1 if len(found) > 1 else True
    assert not count or (found[0] == 0 and found[-1] == (count - 1 if len(found) > 1 else 0))
