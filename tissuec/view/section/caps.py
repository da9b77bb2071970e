"""The cut faces of filled bodies as triangles, and their outlines as strips."""

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats
from tissuec.view.player.bodies import TriangleMesh
from tissuec.view.section.cross_section import CrossSection
from tissuec.view.section.plane import SectionPlane


def cap(cut: CrossSection, plane: SectionPlane) -> TriangleMesh:
    """Return the triangles of a section, facing as the plane does."""
    of, corners = cut.triangles
    place = cut.corners[of[:, None], corners]
    return TriangleMesh(place, np.broadcast_to(np.array(plane.normal), place.shape))


def at_cap(cut: CrossSection, values: NDArray[np.floating]) -> Floats:
    """Return values at the corners of the triangles of a section, shape (triangle, 3, …).

    Args:
        cut: The section.
        values: At nodes, in any unit, shape (node, …).
    """
    of, corners = cut.triangles
    return cut.polygons.mixed(values)[of[:, None], corners]


def rims(cut: CrossSection, plane: SectionPlane, width: float, nearer: float) -> TriangleMesh:
    """Return strips along the outlines of a section.

    Args:
        cut: The section.
        plane: Its plane.
        width: Of the strips [m].
        nearer: How far in front of the plane they lie [m].
    """
    normal = np.array(plane.normal)
    ends = cut.borders + nearer * normal
    way = ends[:, 1] - ends[:, 0]
    way = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-300)
    half = 0.5 * width * np.cross(normal, way)
    a, b = ends[:, 0] - half, ends[:, 0] + half
    c, d = ends[:, 1] - half, ends[:, 1] + half
    place = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    return TriangleMesh(place, np.broadcast_to(normal, place.shape))
