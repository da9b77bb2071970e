"""Sizes of steps of symplectic methods."""

import numpy as np
import pytest

from tissuec.engine.integrators.constant_steps import AFTER_CHANGE, propose


def sizes(error, steps):
    """Return the sizes of steps whose error ratio is a function of size and number."""
    h, memory, wait, found = 1.0, 0.0, 0, []
    for number in range(steps):
        found.append(h)
        h, memory, wait = propose(h, error(h, number), memory, wait)
    return np.array(found)


def test_sizes_double_at_the_start_until_the_error_is_near_to_what_is_allowed():
    found = sizes(lambda h, number: 1e-4 * h**2, 3 * AFTER_CHANGE)
    assert found[:6].tolist() == [1, 2, 4, 8, 16, 32]
    assert 0.25 <= 1e-4 * found[-1] ** 2 <= 0.6 * 1.01


def test_later_a_size_is_kept_for_some_steps_and_grows_by_the_largest_error_in_them():
    # The error falls to a quarter of what is allowed, but not in all steps.
    found = sizes(lambda h, number: 0.5 if number < 2 or number == 5 else 0.2 * h**2, 60)
    assert np.flatnonzero(np.diff(found)).tolist() == [2 * (AFTER_CHANGE + 1)]
    assert found[-1] == pytest.approx(np.sqrt(0.6 / 0.2))


def test_a_size_is_kept_while_errors_are_neither_large_nor_small():
    assert (sizes(lambda h, number: 0.4, 100) == 1.0).all()
