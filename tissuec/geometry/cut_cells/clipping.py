"""Tetrahedra that a level divides: sides, cut triangles, and volumes as products.

A corner at the height h is in front if h ≥ 0. Between a corner f in front and one behind, g,
the level meets the edge at the part t of it, and s = 1 - t:

    t = h_f / (h_f - h_g),    s = -h_g / (h_f - h_g).

The smaller tetrahedra are prisms cut thrice, so that their volumes are products of up to three
of these numbers: 0 exactly where the level passes through corners. (Marching tetrahedra: A.
Doi, A. Koide, IEICE Trans. E74:214, 1991; the products are derived here.)

Corners are in an order that all tetrahedra with a common face agree on, that of generations:
corners of the root by their numbers, then new points by the ends of their edges. The diagonal
of a quadrilateral face follows from it, so that neighbours match after any number of cuts.
"""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.cut_cells.roots import parity
from tissuec.model.network import Floats, Indices

Bools = NDArray[np.bool_]


class _Case(NamedTuple):
    """What becomes of a tetrahedron with a number of corners in front, which come first.

    Attributes:
        ends: Corners of the edges that are met, shape (point, 2); points follow the corners.
        front, behind: Corners and points of tetrahedra on each side, shape (tetrahedron, 4).
        factors: Numbers in t, s and 1, one behind the other, whose product is the volume of
            those in front, then behind, shape (tetrahedron, 3).
        triangles: Of the cut, shape (triangle, 3).
        signs: Of the determinants of the tetrahedra, shape (tetrahedron,).
        facing: 1 if a triangle turns to the left as seen from the front of a right-handed
            tetrahedron, else -1, shape (triangle,).
    """

    ends: Indices
    front: Indices
    behind: Indices
    factors: Indices
    triangles: Indices
    signs: Indices
    facing: Indices


def _case(
    ends: list[tuple[int, int]],
    front: dict[tuple[int, ...], str],
    behind: dict[tuple[int, ...], str],
    triangles: list[tuple[int, int, int]],
) -> _Case:
    """Return a case; factors of volumes are spelt like "t0 s1"."""
    count = len(ends)
    at = {f"t{k}": k for k in range(count)} | {f"s{k}": count + k for k in range(count)}
    factors = [
        [*(at[one] for one in text.split()), *[2 * count] * (3 - len(text.split()))]
        for text in (*front.values(), *behind.values())
    ]
    points = np.vstack([np.eye(4), *(np.eye(4)[list(pair)].mean(axis=0) for pair in ends)])
    every = np.array([*front, *behind])
    signs = np.sign(np.linalg.det(points[every]))
    seen = [np.linalg.det(points[[0, *triangle]]) for triangle in triangles]
    return _Case(
        np.array(ends), np.array([*front]), np.array([*behind]), np.array(factors),
        np.array(triangles), signs.astype(np.int64), -np.sign(seen).astype(np.int64),
    )  # fmt: skip


_CASES = {
    1: _case(
        [(0, 1), (0, 2), (0, 3)],
        {(0, 4, 5, 6): "t0 t1 t2"},
        {(1, 4, 5, 6): "s0 t1 t2", (1, 2, 5, 6): "s1 t2", (1, 2, 3, 6): "s2"},
        [(4, 5, 6)],
    ),
    2: _case(
        [(0, 2), (0, 3), (1, 2), (1, 3)],
        {(0, 1, 6, 7): "t2 t3", (0, 4, 6, 7): "t0 s2 t3", (0, 4, 5, 7): "t0 t1 s3"},
        {(2, 3, 5, 7): "s1 s3", (2, 4, 5, 7): "s0 t1 s3", (2, 4, 6, 7): "s0 s2 t3"},
        [(4, 5, 7), (4, 7, 6)],
    ),
    3: _case(
        [(0, 3), (1, 3), (2, 3)],
        {(0, 4, 5, 6): "t0 s1 s2", (0, 1, 5, 6): "t1 s2", (0, 1, 2, 6): "t2"},
        {(3, 4, 5, 6): "s0 s1 s2"},
        [(4, 5, 6)],
    ),
}


class Tetrahedra(Struct, frozen=True, eq=False):
    """Tetrahedra inside of roots.

    Attributes:
        shares: Of the corners of the root in each corner, shape (tetrahedron, 4, 4).
        fraction: Of the volume of the cell, in natural coordinates, shape (tetrahedron,).
        sign: 1 if it is right-handed in natural coordinates, else -1, shape (tetrahedron,).
        on: Whether a corner is on a level, shape (tetrahedron, 4, level).
    """

    shares: Floats
    fraction: Floats
    sign: Indices
    on: Bools

    def __getitem__(self, items: Indices | Bools) -> "Tetrahedra":
        return Tetrahedra(
            self.shares[items], self.fraction[items], self.sign[items], self.on[items]
        )

    @classmethod
    def together(cls, some: "list[Tetrahedra]") -> "Tetrahedra":
        """Return all of some tetrahedra."""
        names = ("shares", "fraction", "sign", "on")
        return cls(*(np.concatenate([getattr(each, name) for each in some]) for name in names))


class ClippedTetrahedra(Struct, frozen=True, eq=False):
    """Tetrahedra on both sides of a level, and what it cuts.

    Attributes:
        inside: All that have a volume.
        source: The one that each is a part of, shape (tetrahedron,).
        side: 1 in front, -1 behind, shape (tetrahedron,).
        triangles: Shares of the corners of the root, in turn to the left as seen from the
            front, shape (triangle, 3, 4).
        cut: The tetrahedron that each triangle is in, shape (triangle,).
        is_known: Whether a triangle lies on an earlier level, too, so that there is nothing in
            front of it, shape (triangle,).
    """

    inside: Tetrahedra
    source: Indices
    side: Indices
    triangles: Floats
    cut: Indices
    is_known: Bools


def clipped(some: Tetrahedra, heights: Floats, flat_side: Indices) -> ClippedTetrahedra:
    """Return tetrahedra divided by a level, the last one of ``on``.

    Args:
        some: In any cells.
        heights: Of their corners above the level, in any unit, shape (tetrahedron, 4).
        flat_side: Where those with heights of 0 are, 1 or -1, shape (tetrahedron,).
    """
    front = heights >= 0.0
    count = front.sum(axis=1)
    uncut = np.flatnonzero((count == 0) | (count == 4))
    on = some.on[uncut].copy()
    on[..., -1] = heights[uncut] == 0.0
    kept = some[uncut]
    inside = [Tetrahedra(kept.shares, kept.fraction, kept.sign, on)]
    side = [
        np.where(on[..., -1].all(axis=1), flat_side[uncut], np.where(front[uncut, 0], 1, -1))
    ]
    source = [uncut]
    triangles, cut, is_known = [np.zeros((0, 3, 4))], [uncut[:0]], [np.zeros(0, dtype=bool)]
    for number, case in _CASES.items():
        own = np.flatnonzero(count == number)
        if not len(own):
            continue
        found, which, at, facets, of = _divided(case, some[own], heights[own], front[own])
        inside.append(found)
        source.append(own[which])
        side.append(at)
        triangles.append(facets)
        cut.append(own[of])
        zero = heights[own] == 0.0
        known = (some.on[own][..., :-1] | ~zero[..., None]).all(axis=1).any(axis=1)
        is_known.append((known & (zero.sum(axis=1) == 3))[of])
    return ClippedTetrahedra(
        Tetrahedra.together(inside), np.concatenate(source), np.concatenate(side),
        np.concatenate(triangles), np.concatenate(cut), np.concatenate(is_known),
    )  # fmt: skip


def _divided(
    case: _Case, some: Tetrahedra, heights: Floats, front: Bools
) -> tuple[Tetrahedra, Indices, Indices, Floats, Indices]:
    """Return parts of tetrahedra of a case, sources and sides, and triangles and sources."""
    order = np.argsort(~front, axis=1, kind="stable")
    turn = some.sign * parity(order)
    height = np.take_along_axis(heights, order, axis=1)
    rows = np.take_along_axis(some.shares, order[..., None], axis=1)
    on = np.take_along_axis(some.on, order[..., None], axis=1)
    on[..., -1] = height == 0.0
    f, g = case.ends.T
    gap = height[:, f] - height[:, g]
    t, s = height[:, f] / gap, -height[:, g] / gap
    points = s[..., None] * rows[:, f] + t[..., None] * rows[:, g]
    new_on = on[:, f] & (on[:, g] | (t == 0.0)[..., None])
    new_on[..., -1] = True
    pool, pool_on = np.concatenate([rows, points], 1), np.concatenate([on, new_on], 1)
    tetrahedra = np.concatenate([case.front, case.behind])
    numbers = np.concatenate([t, s, np.ones((len(t), 1))], axis=1)
    a, b, c = case.factors.T
    size = numbers[:, a] * numbers[:, b] * numbers[:, c]
    which, kind = np.nonzero(size > 0.0)
    chosen, turned = _in_order(case, tetrahedra[kind], which, order, t)
    row = which[:, None]
    found = Tetrahedra(
        pool[row, chosen], size[which, kind] * some.fraction[which],
        turn[which] * case.signs[kind] * turned, pool_on[row, chosen],
    )  # fmt: skip
    side = np.where(kind < len(case.front), 1, -1)
    facets, of = _facets(case, pool, turn)
    return found, which, side, facets, of


def _in_order(
    case: _Case, chosen: Indices, which: Indices, order: Indices, t: Floats
) -> tuple[Indices, Indices]:
    """Return corners of tetrahedra in the order that others have, too, and its parity.

    A new point that is a corner has the place of the corner.

    Args:
        case: Of the tetrahedra.
        chosen: Corners and points of each part of one, shape (part, 4).
        which: The tetrahedron that it is a part of, shape (part,).
        order: Former places of its corners, shape (tetrahedron, 4).
        t: Part of edges at which points are, shape (tetrahedron, point).
    """
    turned = np.ones(len(chosen), dtype=np.int64)
    own = np.flatnonzero((t == 0.0).any(axis=1)[which])
    if len(own):
        new = 4 + np.arange(len(case.ends))
        key = np.concatenate(
            [order, np.where(t == 0.0, order[:, case.ends[:, 0]], new)], axis=1
        )
        by = np.argsort(key[which[own, None], chosen[own]], axis=1)
        chosen[own] = np.take_along_axis(chosen[own], by, axis=1)
        turned[own] = parity(by)
    return chosen, turned


def _facets(case: _Case, pool: Floats, turn: Indices) -> tuple[Floats, Indices]:
    """Return cut triangles that are no lines or points, and their tetrahedra."""
    every = pool[:, case.triangles]
    left = (turn[:, None] * case.facing) < 0
    every = np.where(left[..., None, None], every[:, :, [0, 2, 1]], every)
    a, b, c = np.moveaxis(every, 2, 0)
    is_flat = (a == b).all(axis=2) | (b == c).all(axis=2) | (c == a).all(axis=2)
    of, which = np.nonzero(~is_flat)
    return every[of, which], of
