"""Affine maps: against SciPy's rotations, and against each other."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.every import every
from tissuec.geometry.affine import Affine

AXIS = np.array([1.0, -2.0, 2.0]) / 3.0
POINT = np.array([0.1, 0.2, -0.3])
PLACES = np.random.default_rng(1).normal(size=(20, 3))


def test_a_turn_is_that_of_scipy_about_its_point():
    turn = Affine.turning(0.7, AXIS, POINT)
    expected = Rotation.from_rotvec(0.7 * AXIS).apply(PLACES - POINT) + POINT
    assert turn.points(PLACES) == pytest.approx(expected, abs=1e-14)
    assert turn.scale == pytest.approx(1.0, rel=1e-14) and not turn.is_mirrored


@every("quarters", range(-4, 5))
def test_quarter_turns_are_exact(quarters):
    turn = Affine.turning(quarters * np.pi / 2.0, np.array([0.0, 0.0, 1.0]), np.zeros(3))
    assert set(turn.matrix.ravel().tolist()) <= {-1.0, 0.0, 1.0}


def test_a_reflection_leaves_its_plane_and_exchanges_its_sides():
    mirror = Affine.mirroring(POINT, AXIS)
    before, after = ((x - POINT) @ AXIS for x in (PLACES, mirror.points(PLACES)))
    assert after == pytest.approx(-before, abs=1e-14)
    assert mirror.is_mirrored and mirror.scale == pytest.approx(1.0, rel=1e-14)
    assert mirror.then(mirror).points(PLACES) == pytest.approx(PLACES, abs=1e-14)


def test_a_scaling_keeps_its_point_and_multiplies_volumes():
    scaling = Affine.scaling(np.array([1.0, 2.0, 3.0]), POINT)
    assert scaling.points(POINT) == pytest.approx(POINT, abs=1e-16)
    assert scaling.volume == pytest.approx(6.0) and scaling.scale is None
    assert Affine.scaling(np.full(3, 2.0), POINT).scale == pytest.approx(2.0, rel=1e-15)


def test_maps_follow_one_another_and_lead_back():
    first, second = Affine.turning(1.0, AXIS, POINT), Affine.scaling(np.arange(1.0, 4.0), POINT)
    both = first.then(second)
    assert both.points(PLACES) == pytest.approx(second.points(first.points(PLACES)), abs=1e-14)
    assert both.inverse().points(both.points(PLACES)) == pytest.approx(PLACES, abs=1e-14)


def test_lines_and_planes_are_those_through_the_images_of_points():
    distort = Affine.scaling(np.array([1.0, 2.0, 3.0]), POINT).then(Affine.moving(POINT))
    line = distort.points(POINT + AXIS) - distort.points(POINT)
    assert distort.direction(AXIS) == pytest.approx(line / np.linalg.norm(line))
    across = np.linalg.svd(AXIS[None])[2][1:]  # two directions within the plane
    within = distort.points(POINT + across) - distort.points(POINT)
    assert within @ distort.normal(AXIS) == pytest.approx(0.0, abs=1e-15)
