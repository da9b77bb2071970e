"""Sections by a plane: remaining triangles, and polygons and outlines of filled bodies."""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.core.scale import scale_of, snapped
from tissuec.geometry.blade_sections import SectionPolygons, plane_section
from tissuec.model.network import Floats, Indices
from tissuec.view.player.bodies import TriangleMesh
from tissuec.view.player.film import PlayerData, position_at
from tissuec.view.section.plane import SectionPlane


class CrossSection(Struct, frozen=True, eq=False):
    """Where a plane cuts filled bodies.

    Within a tetrahedron, the share of a tissue is 1 at its nodes, 0 at others, and linear in
    between. A piece belongs to the tissue with the largest share, and borders of tissues are
    where two of them have the largest.

    Attributes:
        polygons: In turn to the left as seen from the front of the plane.
        corners: Of these [m], shape (polygon, 4, 3).
        pieces: Triangles of one tissue each, which cover the polygons [m], shape (piece, 3, 3).
        tissue: Number of the tissue of each, shape (piece,).
        borders: Outlines of bodies and of tissues [m], shape (segment, 2, 3).
    """

    polygons: SectionPolygons
    corners: Floats
    pieces: Floats
    tissue: Indices
    borders: Floats

    @property
    def triangles(self) -> tuple[Indices, Indices]:
        """Return triangles of the polygons: the polygon, and three of its four corners.

        The shapes are (triangle,) and (triangle, 3).
        """
        return _triangles(self.polygons)

    def areas(self, count: int) -> Floats:
        """Return the area of each of so many tissues [m²], shape (count,)."""
        return np.bincount(self.tissue, self.area, count).astype(float)

    @property
    def area(self) -> Floats:
        """Return the area of each piece [m²], shape (piece,)."""
        a, b, c = self.pieces.swapaxes(0, 1)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0


def cross_section(
    position: Floats, tetrahedra: Indices, tissue: Indices, count: int, plane: SectionPlane
) -> CrossSection:
    """Return where a plane cuts tetrahedra.

    Args:
        position: Of nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
        tissue: Number of the tissue of each node, shape (node,).
        count: How many tissues there are.
    """
    found = plane_section(position, tetrahedra, np.array(plane.normal), plane.offset)
    corners = found.mixed(position)
    shares = found.mixed((tissue[:, None] == np.arange(count)).astype(float))
    of, three = _triangles(found)
    rows = of[:, None]
    values = np.concatenate([corners[rows, three], shares[rows, three]], axis=2)
    pieces, numbers, contours = _pieces(values, count)
    borders = np.concatenate([_outline(found, corners), contours])
    return CrossSection(found, corners, pieces, numbers, borders)


def _triangles(polygons: SectionPolygons) -> tuple[Indices, Indices]:
    """Return the polygon of each triangle, and three of its corners; see ``CrossSection``."""
    number, ends, part = np.arange(len(polygons.cell)), polygons.ends, polygons.part
    is_quad = (ends[:, 2] != ends[:, 3]).any(axis=1) | (part[:, 2] != part[:, 3])
    is_quad &= (ends[:, 0] != ends[:, 1]).any(axis=1) | (part[:, 0] != part[:, 1])
    of = np.concatenate([number, number[is_quad]])
    corners = np.tile([0, 2, 3], (len(of), 1))
    corners[: len(number)] = np.where(
        ((ends[:, 0] == ends[:, 1]).all(axis=1) & (part[:, 0] == part[:, 1]))[:, None],
        [0, 2, 3],
        [0, 1, 2],
    )
    return of, corners


_APART = 1e-9  # of a share, by which each tissue precedes the next one: no two are alike


def _pieces(values: Floats, count: int) -> tuple[Floats, Indices, Floats]:
    """Return triangles of one tissue each, their tissues, and the borders between these.

    Args:
        values: At the corners of triangles: places [m], and shares of tissues, shape
            (triangle, 3, 3 + tissue).
        count: How many tissues there are.

    Returns:
        Pieces [m], shape (piece, 3, 3), tissues, shape (piece,), and borders [m], shape
        (segment, 2, 3).
    """
    values[..., 3:] -= _APART * np.arange(count)
    first = values[..., 3:].argmax(axis=2)
    is_pure = (first == first[:, :1]).all(axis=1)
    pieces, tissue = [values[is_pure, :, :3]], [first[is_pure, 0]]
    borders, mixed = [np.zeros((0, 2, 3))], values[~is_pure]
    for one in range(count):
        own = mixed[(mixed[..., 3 + one] > 0.0).any(axis=1)]
        for other in range(count):
            if other == one or not len(own):
                continue
            if other > one:  # each border once, where no third tissue has more
                edge = own
                for third in set(range(count)) - {one, other}:
                    edge = clipped(edge, edge[..., 3 + third] - edge[..., 3 + one])[0]
                borders.append(met(edge[..., :3], edge[..., 3 + other] - edge[..., 3 + one]))
        for other in set(range(count)) - {one}:
            own = clipped(own, own[..., 3 + other] - own[..., 3 + one])[0]
        pieces.append(own[..., :3])
        tissue.append(np.full(len(own), one))
    return np.concatenate(pieces), np.concatenate(tissue), np.concatenate(borders)


def _outline(polygons: SectionPolygons, corners: Floats) -> Floats:
    """Return the sides of polygons that are in the surface [m], shape (segment, 2, 3)."""
    sides = np.stack([polygons.ends, np.roll(polygons.ends, -1, axis=1)], axis=2)
    nodes = np.sort(sides.reshape(-1, 4), axis=1)
    # The edges of a tetrahedron at both ends of a side have three nodes: those of a face.
    twice = (nodes[:, 1:] == nodes[:, :-1]).argmax(axis=1)
    faces = np.where(np.arange(3) >= twice[:, None], nodes[:, 1:], nodes[:, :-1])
    place = np.flatnonzero((np.diff(faces, axis=1) > 0).all(axis=1))  # others have no length
    _, first, count = np.unique(faces[place], axis=0, return_index=True, return_counts=True)
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
    return ends[place[first[count == 1]]]


def clipped(values: Floats, height: Floats) -> tuple[Floats, Indices]:
    """Return the parts of triangles that are not in front of a plane.

    Args:
        values: At their corners, places and whatever changes evenly between these, in any
            units, shape (triangle, 3, value).
        height: Of the corners in front of the plane [m], shape (triangle, 3).

    Returns:
        Values of shape (part, 3, value), and the triangle of each part, shape (part,).
    """
    front = height > 0.0
    count = front.sum(axis=1)
    whole = np.flatnonzero(count == 0)
    parts, of = [values[whole]], [whole]
    for many in (1, 2):
        chosen = np.flatnonzero(count == many)
        # The corner that is alone on its side first.
        alone = front[chosen] if many == 1 else ~front[chosen]
        turn = (alone.argmax(axis=1)[:, None] + np.arange(3)) % 3
        rows = chosen[:, None]
        (a, b, c), (p, q, r) = values[rows, turn].swapaxes(0, 1), height[rows, turn].T
        ab = a + (p / (p - q))[:, None] * (b - a)
        ac = a + (p / (p - r))[:, None] * (c - a)
        pieces = [(ab, b, c), (ab, c, ac)] if many == 1 else [(a, ab, ac)]
        for piece in pieces:
            parts.append(np.stack(piece, axis=1))
            of.append(chosen)
    return np.concatenate(parts), np.concatenate(of)


def met(values: Floats, height: Floats) -> Floats:
    """Return where a plane meets triangles, shape (segment, 2, value).

    Args:
        values: At their corners, in any units, shape (triangle, 3, value).
        height: Of the corners in front of the plane [m], shape (triangle, 3).
    """
    front = height > 0.0
    rows = np.flatnonzero(front.any(axis=1) & ~front.all(axis=1))
    alone = np.where(front[rows].sum(axis=1)[:, None] == 1, front[rows], ~front[rows])
    turn = (alone.argmax(axis=1)[:, None] + np.arange(3)) % 3
    rows = rows[:, None]
    (a, b, c), (p, q, r) = values[rows, turn].swapaxes(0, 1), height[rows, turn].T
    first, second = (a + (p / (p - h))[:, None] * (to - a) for to, h in ((b, q), (c, r)))
    return np.stack([first, second], axis=1)


def section(film: PlayerData, at: float, plane: SectionPlane) -> CrossSection:
    """Return where a plane cuts the filled bodies of a film.

    Args:
        at: Moment, in frames.
    """
    place, cells = position_at(film, at)[: film.node_count], film.cells.there(at)
    return cross_section(place, cells, film.tissue, len(film.tissues), plane)


def check_plane(film: PlayerData, plane: SectionPlane, at: float | None) -> None:
    """Check that a plane meets what there is at a moment.

    Args:
        at: Moment, in frames; any moment if None.

    Raises:
        TissueError: It does not; says how far the bodies reach.
    """
    if at is None:
        check_reach(film.position[:, film.matter], plane, "at any time")
        return
    time = film.clock.text(film.time_at(at))
    check_reach(position_at(film, at)[film.matter], plane, f"at {time}")


def check_reach(position: Floats, plane: SectionPlane, when: str) -> None:
    """Check that a plane meets some nodes.

    Args:
        position: Of the nodes [m], shape (…, 3).
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
        values: At nodes, in any unit, shape (node, …).
    """
    of, corners = cut.triangles
    return cut.polygons.mixed(values)[of[:, None], corners]


def rims(cut: CrossSection, plane: SectionPlane, width: float, nearer: float) -> TriangleMesh:
    """Return strips along the outlines of a section.

    Args:
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
