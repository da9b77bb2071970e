"""What both ends of a step tell of its inside is exact for polynomials."""

import numpy as np
import pytest

from tissuec.engine.integrators.hermite import cubic, quintic

STEP = 0.3


@pytest.mark.parametrize("part", [0.0, 0.2, 0.5, 0.77, 1.0])
def test_positions_are_those_of_a_quintic_and_velocities_those_of_a_cubic(part):
    profile = np.polynomial.Polynomial([0.3, -1.2, 0.7, 2.0, -1.5, 0.4])
    ends = np.array([0.0, STEP])
    values = [profile.deriv(k)(ends) * STEP**k for k in range(3)]
    assert np.dot(quintic(part), np.concatenate(values)) == pytest.approx(profile(part * STEP))
    speed = profile.cutdeg(3)
    values = [speed(ends), speed.deriv()(ends) * STEP]
    assert np.dot(cubic(part), np.concatenate(values)) == pytest.approx(speed(part * STEP))
