"""Rasterised triangles with a depth buffer."""

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled.calls import Shipped
from tissuec.kernels.rasterizing import fill
from tissuec.model.network import Floats

FINER = 2  # pixels of the raster to a pixel of the picture, either way
_FILL = Shipped(fill, "raster")


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
            corners: Place from the left and from the bottom [px], and the inverse of the
                distance from the eye, which is linear on the picture, shape (triangle, corner,
                3).
            colour: Of the corners, 0 to 1, shape (triangle, corner, 3).
            opacity: 0 to 1, shape (triangle,).
            hides: Whether they hide what lies behind and is drawn later.
        """
        given = corners * [FINER, FINER, 1.0], colour, opacity
        arrays = (np.ascontiguousarray(each, dtype=float) for each in given)
        _FILL(*arrays, self._picture, self._nearness, int(hides))

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture, from the top, dimensionless, shape (height, width, 3)."""
        height, width = (side // FINER for side in self._nearness.shape)
        parts = self._picture.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3))
        return np.rint(255.0 * np.clip(parts[::-1], 0.0, 1.0)).astype(np.uint8)
