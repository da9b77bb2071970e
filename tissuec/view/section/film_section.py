"""The section of a film by a plane at a moment, and its faces as triangles."""

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.core.scale import scale_of, snapped
from tissuec.model.network import Floats
from tissuec.view.player.bodies import TriangleMesh
from tissuec.view.player.film import PlayerData, position_at
from tissuec.view.section.cross_section import CrossSection, cross_section
from tissuec.view.section.plane import SectionPlane


def section(film: PlayerData, at: float, plane: SectionPlane) -> CrossSection:
    """Return where a plane cuts the filled bodies of a film.

    Args:
        film: The film.
        at: Moment, in frames.
        plane: The plane.
    """
    place, cells = position_at(film, at)[: film.node_count], film.cells.there(at)
    return cross_section(place, cells, film.tissue, len(film.tissues), plane)


def check_plane(film: PlayerData, plane: SectionPlane, at: float | None) -> None:
    """Check that a plane meets what there is at a moment.

    Args:
        film: The film.
        plane: The plane.
        at: Moment, in frames; any moment if None.

    Raises:
        TissueError: It does not; says how far the bodies reach.
    """
    if at is None:
        check_reach(film.position[:, : film.node_count], plane, "at any time")
        return
    time = film.clock.text(film.time_at(at))
    check_reach(position_at(film, at)[: film.node_count], plane, f"at {time}")


def check_reach(position: Floats, plane: SectionPlane, when: str) -> None:
    """Check that a plane meets some nodes.

    Args:
        position: Of the nodes [m], shape (…, 3).
        plane: The plane.
        when: For the message, such as "at 80 ms".

    Raises:
        TissueError: All are on one side; says how far they reach.
    """
    height = position @ np.array(plane.normal)
    low, high = float(height.min()), float(height.max())
    if low <= plane.offset <= high:
        return
    scale = scale_of("m", [low, high, plane.offset])
    where = f"in {plane.axis}" if plane.axis else "in that direction"
    if not plane.axis:
        where += f", and the plane is at {scale.text(plane.offset)}"
    size = max(abs(low), abs(high))
    low, high = (snapped(one, size) for one in (low, high))
    ends = f"{scale.of(low):.4g} to {scale.text(high)}"
    raise TissueError(
        f"the plane {plane.text} meets nothing {when}: the bodies extend from {ends} {where}"
    )


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
