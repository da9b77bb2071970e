"""Triangles to pixels, the nearer ones in front: as a loop for Numba."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tissuec.network import Floats

FINER = 2  # pixels of the raster to a pixel of the picture, either way


@njit(nogil=True)
def _fill(
    corners: Any, colour: Any, opacity: Any, picture: Any, nearness: Any, writes: bool
) -> None:
    """Draw triangles in turn; see ``Raster.draw``."""
    height, width = nearness.shape
    for t in range(corners.shape[0]):
        ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
        bx, by, bz = corners[t, 1, 0], corners[t, 1, 1], corners[t, 1, 2]
        cx, cy, cz = corners[t, 2, 0], corners[t, 2, 1], corners[t, 2, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        # Pixels have their middles at halves.
        left = max(0, int(np.ceil(min(ax, bx, cx) - 0.5)))
        right = min(width - 1, int(np.floor(max(ax, bx, cx) - 0.5)))
        low = max(0, int(np.ceil(min(ay, by, cy) - 0.5)))
        high = min(height - 1, int(np.floor(max(ay, by, cy) - 0.5)))
        for row in range(low, high + 1):
            y = row + 0.5
            for column in range(left, right + 1):
                x = column + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
                w = 1.0 - u - v
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                near = u * az + v * bz + w * cz
                if near <= nearness[row, column]:
                    continue
                if writes:
                    nearness[row, column] = near
                alpha = opacity[t]
                for k in range(3):
                    new = u * colour[t, 0, k] + v * colour[t, 1, k] + w * colour[t, 2, k]
                    old = picture[row, column, k]
                    picture[row, column, k] = old + alpha * (new - old)


class Raster:
    """A picture that is being drawn.

    Args:
        size: Width and height [px].
        paper: Colour behind everything, shape (3,).
    """

    def __init__(self, size: tuple[int, int], paper: Floats):
        width, height = size
        self._picture = np.empty((height * FINER, width * FINER, 3), dtype=np.float32)
        self._picture[:] = paper
        self._nearness = np.zeros(self._picture.shape[:2])

    def draw(self, corners: Floats, colour: Floats, opacity: Floats, *, hides: bool) -> None:
        """Draw triangles.

        Args:
            corners: Pixels from the left and from the bottom, and the inverse of the distance
                from the eye, which is linear on the picture, shape (triangle, corner, 3).
            colour: Of the corners, shape (triangle, corner, 3).
            opacity: Shape (triangle,).
            hides: Whether they hide what lies behind and is drawn later.
        """
        fine = corners * [FINER, FINER, 1.0]
        _fill(fine, colour, opacity, self._picture, self._nearness, hides)

    def pixels(self) -> NDArray[np.uint8]:
        """Return what was drawn, from the top, shape (height, width, 3)."""
        height, width = (side // FINER for side in self._nearness.shape)
        parts = self._picture.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3))
        return np.rint(255.0 * np.clip(parts[::-1], 0.0, 1.0)).astype(np.uint8)
