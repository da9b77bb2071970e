"""What is seen: a pinhole camera, fitted to the motion."""

import numpy as np
import pytest

from tests.view.player.conftest import Show, grid, without_springs
from tissuec.view.player.camera import ANGLE, MARGIN, Camera, fitted, framing
from tissuec.view.player.options import Options
from tissuec.view.player.reading import read_film
from tissuec.view.plots.projection import viewpoint

POINTS = np.random.default_rng(5).normal(size=(60, 3)) * [3.0, 1.0, 0.4] + [7.0, -2.0, 1.0]


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.3])
@pytest.mark.parametrize("angles", [(-114.0, 20.0), (30.0, -50.0), (-90.0, 90.0)])
def test_everything_is_seen_and_fills_the_picture(aspect, angles):
    seen, depth = fitted(POINTS, *angles, aspect).seen(POINTS)
    assert (depth > 0.0).all()
    # Iterated: within a part of a thousand, the margin is touched on both of two sides.
    assert np.abs(seen).max() == pytest.approx(MARGIN, rel=1e-3)
    tight = np.ptp(seen, axis=0).max() / 2.0
    assert tight == pytest.approx(MARGIN, rel=1e-2)


def test_a_point_is_seen_by_similar_triangles():
    camera = Camera(np.zeros(3), 10.0, -90.0, 0.0, 2.0)
    seen, depth = camera.seen(np.array([[1.0, 4.0, 0.5]]))
    half = np.tan(np.radians(ANGLE / 2.0))  # of the width, which is the longer side
    assert depth == pytest.approx([14.0])
    assert seen == pytest.approx(np.array([[1.0 / (14.0 * half), 2.0 * 0.5 / (14.0 * half)]]))


def test_axes_are_at_right_angles_and_z_is_upwards():
    axes = Camera(np.zeros(3), 1.0, 37.0, 25.0, 1.0).axes
    assert axes @ axes.T == pytest.approx(np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0) and axes[1, 2] > 0.0 and axes[0, 2] == 0.0


@pytest.mark.parametrize(
    ("size", "azimuth", "elevation"),
    [
        ((4.0, 1.0, 1.0), -114.0, 20.0),  # the long side across the picture
        ((1.0, 4.0, 1.0), -24.0, 20.0),
        ((4.0, 3.0, 0.1), -114.0, 40.0),  # nearly flat: from higher above
        ((4.0, 3.0, 0.0), -90.0, 90.0),  # flat: from above
        ((4.0, 0.0, 3.0), -90.0, 0.0),  # flat and upright: from the front
        ((4.0, 0.0, 0.0), -90.0, 0.0),
        ((0.0, 0.0, 0.0), -90.0, 0.0),
    ],
)
def test_the_view_fits_the_shape(size, azimuth, elevation):
    points = np.array(size) * np.random.default_rng(6).uniform(size=(50, 3))
    points[:2] = [np.zeros(3), size]
    assert viewpoint(points) == (azimuth, elevation)


def test_a_body_that_falls_is_followed(shown):
    net = without_springs(grid(4, 4))

    class Falling(Show):
        def place(self, frame):
            return self.network.position - [0.0, 0.0, 5.0 * frame**2]

    film = read_film(shown(Falling(net, frames=8)), Options())
    frame = framing(film)
    assert frame.follows
    assert frame.size < 0.3  # that of the body, which is 0.14 m, and not of its way of 245 m
    assert frame.middle[7] - frame.middle[0] == pytest.approx([0.0, 0.0, -245.0])


def test_one_point_is_seen(shown):
    net = without_springs(grid(2, 2, size=0.0))
    frame = framing(read_film(shown(Show(net, frames=1)), Options()))
    camera = fitted(frame.points, 0.0, 0.0, 1.0)
    assert camera.distance > 0.0 and np.isfinite(camera.seen(frame.points)[0]).all()
