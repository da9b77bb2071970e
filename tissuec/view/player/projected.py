"""Triangles as the camera of a picture sees them."""

from typing import NamedTuple

import numpy as np

from tissuec.model.network import Floats
from tissuec.view.section.clipping import clipped


class ProjectedTriangles(NamedTuple):
    """Triangles as the camera sees them.

    Attributes:
        corners: To the right, upwards, and to the eye [m], shape (triangle, 3, 3).
        colour: Of the corners, shape (triangle, 3, 3).
        opacity: Shape (triangle,).
    """

    corners: Floats
    colour: Floats
    opacity: Floats

    def behind(self, normal: Floats, offset: float) -> "ProjectedTriangles":
        """Return those parts that are not in front of a plane.

        Args:
            normal: Of the plane, a unit vector as the camera sees it, shape (3,).
            offset: Of the plane from the target of the camera, along the normal [m].
        """
        height = self.corners @ normal - offset
        values, of = clipped(np.concatenate([self.corners, self.colour], axis=2), height)
        return ProjectedTriangles(values[..., :3], values[..., 3:], self.opacity[of])
