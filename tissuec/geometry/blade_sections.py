"""Where planes and blades meet elements: polygons in solids, lines in triangles.

A point of a blade is origin + p first + q second. Where p or q is limited, it is within 0…1.

A whole plane is n·p = d. A corner with n·p ≥ d is in front of it, as for blades. Between a
corner in front, at the height h = n·p - d, and one behind at -k, the plane meets the edge at
the part h / (h + k). One corner against three gives a triangle, two against two a
quadrilateral. Widths of polygons, and the mitres of bent walls, are derived here.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edges import Floats, Indices

LEAST_LEFT = 1e-9  # of a triangle or a line: smaller rests are rounding


class MetEdges(Struct, frozen=True, eq=False):
    """Points at which a plane meets the edges of elements, in order around their middle.

    The last point of an element is repeated if others have more points.

    Attributes:
        ends: Nodes of the edge of each among those of the element, shape (element, point, 2).
        part: How far along it, from 0 to 1, shape (element, point).
    """

    ends: Indices
    part: Floats

    def mixed(self, values: Floats) -> Floats:
        """Return vectors at the points, in their unit, shape (element, point, 3).

        Args:
            values: At the nodes of the elements, shape (element, node, 3).
        """
        row = np.arange(len(values))[:, None]
        first, second = values[row, self.ends[..., 0]], values[row, self.ends[..., 1]]
        return first + self.part[..., None] * (second - first)


def met_edges(
    corners: Floats, edges: Indices, height: Floats, normal: Floats, near: float
) -> MetEdges:
    """Return where a plane meets edges of elements which have nodes on both sides of it.

    Args:
        corners: Nodes of the elements [m], shape (element, node, 3).
        edges: Pairs of them, shape (edge, 2).
        height: Of the nodes above the plane [m], shape (element, node).
        normal: Of the plane, a unit vector, shape (3,).
        near: Height above which a node is in front, just below zero [m].
    """
    first, second = height[:, edges[:, 0]], height[:, edges[:, 1]]
    met = (first >= near) != (second >= near)
    part = np.clip(first / np.where(met, first - second, 1.0), 0.0, 1.0)
    every = MetEdges(np.broadcast_to(edges, (*met.shape, 2)), part)
    points = every.mixed(corners)
    count = met.sum(axis=1)
    middle = (points * met[..., None]).sum(axis=1) / np.maximum(count, 1)[:, None]
    across = np.eye(3)[np.argmin(np.abs(normal))]
    across = np.cross(normal, across) / np.linalg.norm(np.cross(normal, across))
    away = points - middle[:, None]
    angle = np.arctan2(away @ np.cross(normal, across), away @ across)
    order = np.argsort(np.where(met, angle, np.inf), axis=1, kind="stable")
    most = int(count.max(initial=0))
    place = np.minimum(np.arange(most), np.maximum(count - 1, 0)[:, None])
    chosen = np.take_along_axis(order, place, axis=1)
    ends = np.take_along_axis(every.ends, chosen[..., None], axis=1)
    return MetEdges(ends, np.take_along_axis(part, chosen, axis=1))


def polygon_areas(points: Floats) -> Floats:
    """Return the areas of polygons [m²], shape (polygon,).

    Args:
        points: In order [m], shape (polygon, point, 3).
    """
    away = points - points[:, :1]
    each = np.cross(away, np.roll(away, -1, axis=1))
    return 0.5 * np.linalg.norm(each.sum(axis=1), axis=1)


class SectionWidths(Struct, frozen=True, eq=False):
    """Widths of convex polygons in the plane of a blade: their extent along q, over p.

    Between the values of p at which corners and crossings with limits of q lie, a width is
    linear in p.

    Attributes:
        marks: These values, ascending, shape (polygon, mark).
        widths: At both ends of each interval between marks, shape (polygon, mark - 1, 2).
    """

    marks: Floats
    widths: Floats

    @classmethod
    def of(cls, plain: Floats, limited: tuple[bool, bool]) -> "SectionWidths":
        """Return the widths of what of polygons is within a blade.

        Args:
            plain: p and q of corners, in order, shape (polygon, corner, 2).
            limited: Whether p and q are limited.
        """
        p, q = np.moveaxis(plain, 2, 0)
        p2, q2 = np.moveaxis(np.roll(plain, -1, axis=1), 2, 0)
        marks = [p]
        for limit in (0.0, 1.0) if limited[1] else ():
            along = _divided(limit - q, q2 - q)
            marks.append(np.where((along > 0.0) & (along < 1.0), p + along * (p2 - p), p))
        mark = np.sort(np.concatenate(marks, axis=1), axis=1)
        if limited[0]:
            mark = np.clip(mark, 0.0, 1.0)
        low, way = mark[:, :-1, None], np.diff(mark, axis=1)[..., None]
        place = (low + way * [0.25, 0.75])[:, None]
        sides = (one[..., None, None] for one in (p, q, p2, q2))
        inside = _extents(place, *sides, limited=limited[1])
        first, second = np.moveaxis(inside, 2, 0)
        ends = np.stack([1.5 * first - 0.5 * second, 1.5 * second - 0.5 * first], axis=2)
        return cls(mark, np.maximum(ends, 0.0))

    @property
    def areas(self) -> Floats:
        """Return the areas of the polygons in units of the blade, shape (polygon,)."""
        return (self.widths.mean(axis=2) * np.diff(self.marks, axis=1)).sum(axis=1)


def _extents(
    place: Floats, p: Floats, q: Floats, p2: Floats, q2: Floats, *, limited: bool
) -> Floats:
    """Return how far polygons extend along q at places between their corners.

    Args:
        place: p there, shape (polygon, 1, interval, place).
        p, q, p2, q2: Ends of the sides, shape (polygon, side, 1, 1).
        limited: Whether q is limited.

    Returns:
        The extents in units of q, shape (polygon, interval, place).
    """
    there = (np.minimum(p, p2) <= place) & (place < np.maximum(p, p2))
    met = q + _divided(place - p, p2 - p) * (q2 - q)
    low = np.where(there, met, np.inf).min(axis=1)
    high = np.where(there, met, -np.inf).max(axis=1)
    if limited:
        low, high = np.maximum(low, 0.0), np.minimum(high, 1.0)
    return np.where(high > low, high - low, 0.0)


def shares_of_polygons(plain: Floats, limited: tuple[bool, bool]) -> Floats:
    """Return which part of each convex polygon is within a blade, shape (polygon,).

    Args:
        plain: p and q of corners, in order, shape (polygon, corner, 2).
        limited: Whether p and q are limited.
    """
    (p, q), (p2, q2) = np.moveaxis(plain, 2, 0), np.moveaxis(np.roll(plain, -1, axis=1), 2, 0)
    whole = 0.5 * np.abs((p * q2 - p2 * q).sum(axis=1))
    return _divided(SectionWidths.of(plain, limited).areas, whole)


def beyond(plain: Floats, limited: tuple[bool, bool], reach: float) -> tuple[Indices, Floats]:
    """Return the parts of triangles, or of lines, that are outside a blade, to rounding.

    Args:
        plain: p and q of corners, shape (triangle, 3, 2) or (line, 2, 2).
        limited: Whether p and q are limited.
        reach: Largest p, if p is limited.

    Returns:
        Of triangles or lines that fill it, the one that each is a part of, shape (n,), and the
        shares of its corners in each corner, shape (n, corner, corner).
    """
    count, size = plain.shape[:2]
    source, shares = np.arange(count), np.broadcast_to(np.eye(size), (count, size, size))
    found = [(source[:0], shares[:0])]
    for axis, least, most in ((0, 0.0, reach), (1, 0.0, 1.0)):
        if not limited[axis]:
            continue
        for sign, limit in ((-1.0, least), (1.0, most)):
            height = sign * ((shares @ plain[source][..., axis : axis + 1])[..., 0] - limit)
            sides = _halves(shares, height)
            out, (which, shares) = sides[0], sides[1]
            found.append((source[out[0]], out[1]))
            source = source[which]
    source, shares = (np.concatenate(each) for each in zip(*found, strict=True))
    kept = np.abs(np.linalg.det(shares)) > LEAST_LEFT
    return source[kept], shares[kept]


def inside_boxes(plain: Floats, low: Floats, high: Floats) -> tuple[Indices, Floats]:
    """Return the parts of triangles within ranges of p and q; see ``beyond``.

    Args:
        plain: p and q of corners, shape (triangle, 3, 2).
        low, high: Ends of the range of each triangle, shape (triangle, 2).
    """
    source, shares = np.arange(len(plain)), np.broadcast_to(np.eye(3), (len(plain), 3, 3))
    for axis in range(2):
        for sign, limits in ((1.0, low), (-1.0, high)):
            at = (shares @ plain[source][..., axis : axis + 1])[..., 0]
            height = sign * (at - limits[source, axis, None])
            which, shares = _halves(shares, height)[0]
            source = source[which]
    return source, shares


def halves(height: Floats) -> tuple[Indices, Floats, NDArray[np.bool_]]:
    """Return the parts of triangles, or of lines, on both sides of a level, to rounding.

    Args:
        height: Of their corners above it, shape (triangle, 3) or (line, 2).

    Returns:
        The one that each is a part of, shape (n,), the shares of its corners in each corner,
        shape (n, corner, corner), and whether it is above, shape (n,).
    """
    count, size = height.shape
    each = _halves(np.broadcast_to(np.eye(size), (count, size, size)), height)
    source, shares = (np.concatenate(both) for both in zip(*each, strict=True))
    kept = np.abs(np.linalg.det(shares)) > LEAST_LEFT
    is_above = np.arange(len(source)) < len(each[0][0])
    return source[kept], shares[kept], is_above[kept]


def _halves(shares: Floats, height: Floats) -> list[tuple[Indices, Floats]]:
    """Return the parts of triangles or lines at heights above 0, and the others.

    Args:
        shares: Of any corners in those of the simplices, shape (simplex, corner, n).
        height: Of these, shape (simplex, corner).

    Returns:
        The simplex that each is a part of, shape (part,), and shares, shape (part, corner, n).
    """
    size = height.shape[1]
    found: list[tuple[Indices, Floats]] = []
    for above in (height > 0.0, height <= 0.0):
        count = above.sum(axis=1)
        whole = np.flatnonzero(count == size)
        which, parts = [whole], [shares[whole]]
        if size == 2:
            own = np.flatnonzero(count == 1)
            first = above[own].argmax(axis=1)
            a, b = shares[own, first], shares[own, 1 - first]
            ha, hb = height[own, first][:, None], height[own, 1 - first][:, None]
            which.append(own)
            parts.append(np.stack([a, a + ha / (ha - hb) * (b - a)], axis=1))
        for number in (1, 2) if size == 3 else ():
            own = np.flatnonzero(count == number)
            # The corner that is alone on its side comes first.
            alone = (above[own] if number == 1 else ~above[own]).argmax(axis=1)
            order = (alone[:, None] + np.arange(3)) % 3
            a, b, c = np.take_along_axis(shares[own], order[..., None], axis=1).swapaxes(0, 1)
            ha, hb, hc = np.take_along_axis(height[own], order, axis=1)[..., None].swapaxes(
                0, 1
            )
            ab, ac = a + ha / (ha - hb) * (b - a), a + ha / (ha - hc) * (c - a)
            every = [(a, ab, ac)] if number == 1 else [(ab, b, c), (ab, c, ac)]
            which += [own] * len(every)
            parts += [np.stack(each, axis=1) for each in every]
        found.append((np.concatenate(which), np.concatenate(parts)))
    return found


def parts_of_lines(plain: Floats, limited: tuple[bool, bool]) -> Floats:
    """Return between which parts of each line it is within a blade, shape (line, 2).

    Both are the same where it is outside.

    Args:
        plain: p and q of both ends, shape (line, 2, 2).
        limited: Whether p and q are limited.
    """
    low, high = np.zeros(len(plain)), np.ones(len(plain))
    for axis in (axis for axis in range(2) if limited[axis]):
        first, way = plain[:, 0, axis], plain[:, 1, axis] - plain[:, 0, axis]
        ends = np.sort([_divided(-first, way), _divided(1.0 - first, way)], axis=0)
        inside = (first >= 0.0) & (first <= 1.0)
        ends = np.where(way == 0.0, [[0.0], [1.0]] * inside, ends)
        low, high = np.maximum(low, ends[0]), np.minimum(high, ends[1])
    return np.stack([low, np.maximum(low, high)], axis=1)


def thick_lines(points: Floats, shared: Indices, across: Floats, thickness: Floats) -> Floats:
    """Return the sections of walls as quadrilaterals around their middle lines.

    Neighbours end at the line that halves the angle between them, so that together they cover
    what a bent wall covers, once.

    Args:
        points: Ends of the lines, in the plane [m], shape (line, 2, 3).
        shared: Number of each end, the same for ends in the same place, shape (line, 2).
        across: Two unit vectors that span the plane, at right angles, shape (2, 3).
        thickness: Of the walls [m], shape (line,).

    Returns:
        Corners in order [m], shape (line, 4, 3).
    """
    way = (points[:, 1] - points[:, 0]) @ across.T
    normal = 1j * (way[:, 0] + 1j * way[:, 1])
    normal = normal / np.maximum(np.abs(normal), np.finfo(float).tiny)
    # The square of a unit complex number does not know which way round a line was drawn.
    squared = np.zeros(int(shared.max(initial=-1)) + 1, dtype=complex)
    np.add.at(squared, shared, normal[:, None] ** 2)
    middle = np.sqrt(squared[shared])
    middle = middle / np.maximum(np.abs(middle), np.finfo(float).tiny)
    cosine = (middle * normal.conj()[:, None]).real
    # No mitre is longer than twice the thickness, however sharp a fold.
    size = np.sign(cosine) * 0.5 * thickness[:, None] / np.maximum(np.abs(cosine), 0.5)
    offset: Floats = np.stack([(size * middle).real, (size * middle).imag], axis=2) @ across
    sides = points - offset, points + offset
    return np.concatenate([sides[0], sides[1][:, ::-1]], axis=1)


def _divided(one: Floats, by: Floats) -> Floats:
    """Return a quotient, 0 where it would be infinite."""
    one, by = np.broadcast_arrays(one, by)
    return np.divide(one, by, out=np.zeros(one.shape), where=by != 0.0)


class SectionPolygons(Struct, frozen=True, eq=False):
    """Triangles and quadrilaterals in a plane, in turn to the left as seen from its front.

    The last corner of a triangle is there twice.

    Attributes:
        ends: The edge on which each corner lies, lower node first, shape (polygon, 4, 2).
        part: How far along it, from 0 to 1, shape (polygon, 4).
        cell: The tetrahedron of each, shape (polygon,).
    """

    ends: Indices
    part: Floats
    cell: Indices

    def mixed(self, values: NDArray[np.floating]) -> Floats:
        """Return values at the corners, in their unit, shape (polygon, 4, …).

        Args:
            values: At nodes, shape (node, …).
        """
        first, second = np.moveaxis(values[self.ends], 2, 0)
        part = self.part.reshape(*self.part.shape, *[1] * (first.ndim - 2))
        return np.asarray(first + part * (second - first))

    def areas(self, position: Floats) -> Floats:
        """Return the areas of the polygons [m²], shape (polygon,).

        Args:
            position: Of nodes [m], shape (node, 3).
        """
        a, b, c, d = self.mixed(position).swapaxes(0, 1)
        return np.linalg.norm(np.cross(c - a, d - b), axis=1) / 2.0


def plane_section(
    position: Floats, tetrahedra: Indices, normal: Floats, offset: float
) -> SectionPolygons:
    """Return where a plane meets tetrahedra.

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
        normal: Of the plane, a unit vector, shape (3,).
        offset: Of the plane from the origin along its normal [m].
    """
    height = position @ normal - offset
    front = height[tetrahedra] >= 0.0
    count = front.sum(axis=1)
    cell = np.flatnonzero((count > 0) & (count < 4))
    # Corners in front first; the sort keeps the order within both sides.
    order = np.argsort(~front[cell], axis=1, kind="stable")
    corners, count = np.take_along_axis(tetrahedra[cell], order, axis=1), count[cell]
    a, b, c, d = corners.T
    ends = np.empty((len(cell), 4, 2), dtype=np.int64)
    for number, pairs in (
        (1, [(a, b), (a, c), (a, d), (a, d)]),
        (2, [(a, c), (a, d), (b, d), (b, c)]),
        (3, [(a, d), (b, d), (c, d), (c, d)]),
    ):
        chosen = count == number
        for k, pair in enumerate(pairs):
            ends[chosen, k] = np.stack(pair, axis=1)[chosen]
    ends.sort(axis=2)
    first, second = np.moveaxis(height[ends], 2, 0)
    part = np.asarray(first / (first - second))
    found = SectionPolygons(ends, part, cell)
    p, q, r, s = found.mixed(position).swapaxes(0, 1)
    turned = np.cross(r - p, s - q) @ normal < 0.0
    ends[turned], part[turned] = ends[turned, ::-1], part[turned, ::-1]
    return found
