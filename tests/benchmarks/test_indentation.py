"""A ball pressed into a block, with friction, against an independent solution by felupe."""

import numpy as np
import pytest

from benchmarks.indentation import Sole, pressed, pressed_by_library, touched


def test_a_ball_that_sticks_presses_as_in_another_library():
    depths = (1.5,)
    other = pressed_by_library(0.3, 0.3, 16, depths)
    # Cells of two thirds of the contact radius.
    assert pressed(2.0, 0.3, depths) == pytest.approx(other, rel=0.04)


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
def test_with_cells_of_half_the_contact_radius_the_force_is_within_three_per_cent(friction):
    found, other = pressed(16.0 / 12.0, friction), pressed_by_library(friction)
    assert np.abs(found / other - 1.0).max() < 0.03


def test_the_independent_contact_bears_at_most_friction_times_pressure():
    angle = np.array([0.1, 0.1, 0.1])
    place = 5.9 * np.stack([-np.cos(angle), np.sin(angle)], axis=1)
    sole = Sole(np.full(3, 2.0), 6.0 * angle - np.array([0.01, 1.0, np.nan]))
    force, arc, _ = touched(place.astype(complex), 0.0, sole, 30.0, 0.5)
    assert arc.real == pytest.approx(6.0 * angle)
    normal = np.stack([-np.cos(angle), np.sin(angle)], axis=1)
    along = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    assert (force.real * normal).sum(axis=1) == pytest.approx(np.full(3, 30.0 * 2.0 * 0.1))
    shares = (force.real * along).sum(axis=1) / (30.0 * 2.0 * 0.1)
    assert shares == pytest.approx([-0.01 * 0.1 / 0.1, -0.5, 0.0])
