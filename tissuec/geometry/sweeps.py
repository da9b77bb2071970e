"""Line segments that pass through triangles, also while both move.

Between two states, all points move on straight lines. Whether a segment goes through a triangle
can only change where one of its ends passes through the triangle, or where it passes an edge of
it. In both cases the volume that four points span changes its sign: those of the triangle and
the end, or both ends and those of the edge. Where it is zero, the point must be within the
triangle, or both segments must cross (X. Provot, Graphics Interface 1997, 177).
"""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot
from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.geometry.nearest import TRIANGLE, places

HALVINGS = 20  # of the way, to find where a volume is zero
INSIDE = 1e-6  # of a triangle or a segment: margin outside that counts, so that no gaps open
MOST_PAIRS = 1 << 20  # examined together


class SweptSurface(NamedTuple):
    """Triangles and their edges.

    Attributes:
        triangles: Corners, shape (triangle, 3).
        edges: Those of the triangles.
    """

    triangles: Indices
    edges: Edges

    @classmethod
    def of(cls, triangles: Indices) -> "SweptSurface":
        """Return the surface of triangles, given by corners of shape (triangle, 3)."""
        return cls(triangles, Edges.among(triangles))


class Passage(Struct, frozen=True):
    """A place where a line passes through a surface, in a state or between two.

    Attributes:
        piece: Number of the segment of the line.
        share: Place on it, from 0 to 1.
        triangle: Number of the triangle.
        way: Part of the way between both states, from 0 to 1; 1 in the second one.
    """

    piece: int
    share: float
    triangle: int
    way: float = 1.0


def near(before: Floats, now: Floats, pieces: Indices, triangles: Indices) -> Indices:
    """Return pairs of a segment and a triangle whose boxes meet, shape (pair, 2).

    Boxes are those around both states.

    Args:
        before, now: Positions of nodes [m], shape (node, 3).
        pieces: Nodes at the ends of segments, shape (piece, 2).
        triangles: Corners, shape (triangle, 3).
    """
    low, high = _boxes(before, now, pieces)
    least, most = _boxes(before, now, triangles)
    # Of a large surface, most triangles are far away from all of a line.
    own = np.flatnonzero(((low.min(axis=0) <= most) & (least <= high.max(axis=0))).all(axis=1))
    least, most = least[own], most[own]
    found = [np.zeros((0, 2), dtype=np.int64)]
    rows = max(1, MOST_PAIRS // max(1, len(own)))
    for first in range(0, len(pieces), rows):
        part = slice(first, first + rows)
        meet = np.ones((len(low[part]), len(own)), dtype=bool)
        for axis in range(3):
            meet &= low[part, axis, None] <= most[:, axis]
            meet &= least[:, axis] <= high[part, axis, None]
        piece, triangle = np.nonzero(meet)
        found.append(np.stack([piece + first, own[triangle]], axis=1))
    return np.concatenate(found)


def sweeps(
    before: Floats, now: Floats, pieces: Indices, surface: SweptSurface, pairs: Indices
) -> list[Passage]:
    """Return where segments pass the boundary of triangles between two states, in order.

    Args:
        before, now: Positions of nodes [m], shape (node, 3).
        pieces: Nodes at the ends of segments, shape (piece, 2).
        surface: The triangles.
        pairs: Segments and triangles that are near, shape (pair, 2).
    """
    ways = np.stack([before, now])
    found = [
        *_ends_through(ways, pieces, surface, pairs),
        *_past_edges(ways, pieces, surface, pairs),
    ]
    return sorted(found, key=lambda one: one.way)


def _ends_through(
    ways: Floats, pieces: Indices, surface: SweptSurface, pairs: Indices
) -> list[Passage]:
    """Return where ends of segments pass through triangles."""
    end = np.repeat([0, 1], len(pairs))
    piece, triangle = np.tile(pairs.T, 2)
    node = pieces[piece, end]
    key = node * len(surface.triangles) + triangle
    _, first = np.unique(key, return_index=True)
    node, triangle, piece, end = node[first], triangle[first], piece[first], end[first]
    corners = np.concatenate([surface.triangles[triangle], node[:, None]], axis=1)
    row, way, place = _flat(ways, corners)
    a, b, c, x = place.swapaxes(0, 1)
    normal = cross(b - a, c - a)
    square = dot(normal, normal)
    shares = np.stack(
        [dot(cross(q - p, x - p), normal) for p, q in ((a, b), (b, c), (c, a))], axis=1
    )
    inside = (shares >= -INSIDE * square[:, None]).all(axis=1) & (square > 0.0)
    return [
        Passage(int(piece[n]), float(end[n]), int(triangle[n]), when)
        for n, when in zip(row[inside].tolist(), way[inside].tolist(), strict=True)
    ]


def _past_edges(
    ways: Floats, pieces: Indices, surface: SweptSurface, pairs: Indices
) -> list[Passage]:
    """Return where segments pass edges of triangles."""
    piece, triangle = np.repeat(pairs, 3, axis=0).T
    edge = surface.edges.of[pairs[:, 1]].ravel()
    key = piece * len(surface.edges.ends) + edge
    _, first = np.unique(key, return_index=True)
    piece, triangle, edge = piece[first], triangle[first], edge[first]
    corners = np.concatenate([pieces[piece], surface.edges.ends[edge]], axis=1)
    row, way, place = _flat(ways, corners)
    a, b, c, d = place.swapaxes(0, 1)
    along, beside = b - a, d - c
    normal = cross(along, beside)
    square = dot(normal, normal)
    flat = np.where(square > 0.0, square, 1.0)
    share = dot(cross(c - a, beside), normal) / flat
    other = dot(cross(c - a, along), normal) / flat
    meet = square > 0.0
    for s in (share, other):
        meet &= (s >= -INSIDE) & (s <= 1.0 + INSIDE)
    rows = (array[meet].tolist() for array in (row, np.clip(share, 0.0, 1.0), way))
    return [
        Passage(int(piece[n]), s, int(triangle[n]), when)
        for n, s, when in zip(*rows, strict=True)
    ]


def _flat(ways: Floats, corners: Indices) -> tuple[Indices, Floats, Floats]:
    """Return which four points change the sign of their volume, and where it is zero.

    Args:
        ways: Both states of all nodes [m], shape (2, node, 3).
        corners: Nodes, shape (row, 4).

    Returns:
        Rows and parts of the way, shape (found,), and positions [m], shape (found, 4, 3).
    """
    volume = [_volumes(state[corners]) for state in ways]
    row = np.flatnonzero(volume[0] * volume[1] < 0.0)
    start, stop = (state[corners[row]] for state in ways)
    is_positive = volume[0][row] > 0.0
    low, high = np.zeros(len(row)), np.ones(len(row))
    for _ in range(HALVINGS if len(row) else 0):
        middle = 0.5 * (low + high)
        there = start + middle[:, None, None] * (stop - start)
        is_before = (_volumes(there) > 0.0) == is_positive
        low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
    way = 0.5 * (low + high)
    return row, way, start + way[:, None, None] * (stop - start)


def _volumes(points: Floats) -> Floats:
    """Return six times the signed volumes of tetrahedra [m³], from shape (row, 4, 3)."""
    a, b, c, d = points.swapaxes(0, 1)
    return dot(cross(b - a, c - a), d - a)


def boxes(points: Floats) -> tuple[Floats, Floats]:
    """Return the lower and upper corners of boxes around points [m], each of shape (row, 3).

    This is five times as fast as minima along an axis.

    Args:
        points: Of each box [m], shape (row, point, 3).
    """
    low = high = points[:, 0]
    for k in range(1, points.shape[1]):
        low, high = np.minimum(low, points[:, k]), np.maximum(high, points[:, k])
    return low, high


def _boxes(before: Floats, now: Floats, nodes: Indices) -> tuple[Floats, Floats]:
    """Return the lower and upper corners of the boxes around nodes in both states.

    Each has the shape (row, 3).
    """
    low, _ = boxes(np.minimum(before, now)[nodes])
    _, high = boxes(np.maximum(before, now)[nodes])
    return low, high


def side_of(point: Floats, position: Floats, triangles: Indices) -> tuple[bool, int]:
    """Return whether a point is in front of a surface, and the nearest corner of it.

    Where several triangles are equally near, such as at an edge, the one that is seen least
    obliquely decides.

    Args:
        point: [m], shape (3,).
        position: Of nodes [m], shape (node, 3).
        triangles: Corners, shape (triangle, 3).
    """
    corners, count = position[triangles], len(triangles)
    kinds = np.full(count, TRIANGLE)
    found = places(np.broadcast_to(point, (count, 3)), kinds, corners, np.zeros(count))
    distance = -found.depth
    nearest = np.flatnonzero(distance <= distance.min() * (1.0 + 1e-9))
    a, b, c = corners[nearest].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    above = dot(normal, point - a)
    best = int(np.abs(above).argmax())
    nodes = triangles[nearest[best]]
    node = int(nodes[np.linalg.norm(position[nodes] - point, axis=1).argmin()])
    return bool(above[best] > 0.0), node


def through(now: Floats, pieces: Indices, triangles: Indices, pairs: Indices) -> list[Passage]:
    """Return where segments go through triangles in one state.

    Args:
        now: Positions of nodes [m], shape (node, 3).
        pieces: Nodes at the ends of segments, shape (piece, 2).
        triangles: Corners, shape (triangle, 3).
        pairs: Segments and triangles that are near, shape (pair, 2).
    """
    piece, triangle = pairs.T
    segments, corners = now[pieces[piece]], now[triangles[triangle]]
    crosses = np.flatnonzero(go_through(segments, corners))
    a, b, c = corners[crosses].swapaxes(0, 1)
    start, end = segments[crosses].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    above, below = dot(normal, start - a), dot(normal, end - a)
    share = above / (above - below)
    return [
        Passage(*numbers)
        for numbers in zip(
            piece[crosses].tolist(), share.tolist(), triangle[crosses].tolist(), strict=True
        )
    ]


def go_through(segments: Floats, triangles: Floats) -> NDArray[np.bool_]:
    """Return whether each segment goes through the triangle of the same row, shape (row,).

    Its ends are on different sides of the plane, and it passes all three sides of the triangle
    on the same side of them, by the signs of the volumes that it spans with them. What only
    touches does not count.

    Args:
        segments: Both ends of each [m], shape (row, 2, 3).
        triangles: Corners of each [m], shape (row, 3, 3).
    """
    start, end = segments[:, None, 0], segments[:, None, 1]
    corners, following = triangles, np.roll(triangles, -1, axis=1)
    sides = _orientations(start, end, corners, following)
    ends = _orientations(corners[:, :1], corners[:, 1:2], corners[:, 2:], segments)
    one_side = (sides > 0.0).all(axis=1) | (sides < 0.0).all(axis=1)
    return one_side & (ends[:, 0] * ends[:, 1] < 0.0)


def _orientations(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Return six times the signed volumes of tetrahedra."""
    return dot(cross(b - a, c - a), d - a)
