"""Tetrahedra and triangles that a level divides: sides, facets of the cut, and contents.

A corner at the height h is in front if h ≥ 0. Between a corner f in front and one behind, g,
the level meets the edge at the part t of it, and s = 1 - t:

    t = h_f / (h_f - h_g),    s = -h_g / (h_f - h_g).

Parts of tetrahedra are prisms cut thrice, so that their volumes are products of up to three of
these numbers: 0 exactly where the level passes through corners. Areas of parts of triangles are
products of up to two. (Marching tetrahedra: A. Doi, A. Koide, IEICE Trans. E74:214, 1991; the
products are derived here.)

Solids consist of tetrahedra, whose facets are triangles, and walls of triangles, whose facets
are lines. Both are *simplices*: they have one corner more than dimensions.

Corners are in an order that all simplices with a common face agree on, that of generations:
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
    """What becomes of a simplex with a number of corners in front, which come first.

    Attributes:
        ends: Corners of the edges that are met, shape (point, 2); points follow the corners.
        front, behind: Corners and points of simplices on each side, shape (simplex, corner).
        factors: Numbers in t, s and 1, one behind the other, whose product is the content of
            those in front, then behind, shape (simplex, dimension).
        facets: Of the cut, shape (facet, corner).
        signs: Of the determinants of the simplices, shape (simplex,).
        facing: 1 if a facet of a right-handed simplex turns as ``ClippedSimplices.facets`` do,
            else -1, shape (facet,).
    """

    ends: Indices
    front: Indices
    behind: Indices
    factors: Indices
    facets: Indices
    signs: Indices
    facing: Indices


def _case(
    ends: list[tuple[int, int]],
    front: dict[tuple[int, ...], str],
    behind: dict[tuple[int, ...], str],
    facets: list[tuple[int, ...]],
) -> _Case:
    """Return a case; factors of contents are spelt like "t0 s1"."""
    count, corners = len(ends), len(next(iter(front)))
    at = {f"t{k}": k for k in range(count)} | {f"s{k}": count + k for k in range(count)}
    factors = [
        [*(at[one] for one in text.split()), *[2 * count] * (corners - 1 - len(text.split()))]
        for text in (*front.values(), *behind.values())
    ]
    unit = np.eye(corners)
    points = np.vstack([unit, *(unit[list(pair)].mean(axis=0) for pair in ends)])
    every = np.array([*front, *behind])
    signs = np.sign(np.linalg.det(points[every]))
    seen = [np.linalg.det(points[[0, *facet]]) for facet in facets]
    return _Case(
        np.array(ends), np.array([*front]), np.array([*behind]), np.array(factors),
        np.array(facets), signs.astype(np.int64), -np.sign(seen).astype(np.int64),
    )  # fmt: skip


_OF_TETRAHEDRA = {
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
_OF_TRIANGLES = {
    1: _case(
        [(0, 1), (0, 2)],
        {(0, 3, 4): "t0 t1"},
        {(1, 3, 4): "s0 t1", (1, 2, 4): "s1"},
        [(3, 4)],
    ),
    2: _case(
        [(0, 2), (1, 2)],
        {(0, 3, 4): "t0 s1", (0, 1, 4): "t1"},
        {(2, 3, 4): "s0 s1"},
        [(3, 4)],
    ),
}
_CASES = {3: _OF_TRIANGLES, 4: _OF_TETRAHEDRA}  # by the number of corners


class Simplices(Struct, frozen=True, eq=False):
    """Tetrahedra, or triangles, inside of roots.

    Attributes:
        shares: Of the corners of the root in each corner, shape (simplex, corner, corner).
        fraction: Of the content of the cell, in natural coordinates, shape (simplex,).
        sign: 1 if it is right-handed in natural coordinates, else -1, shape (simplex,).
        on: Whether a corner is on a level, shape (simplex, corner, level).
    """

    shares: Floats
    fraction: Floats
    sign: Indices
    on: Bools

    def __getitem__(self, items: Indices | Bools) -> "Simplices":
        return Simplices(
            self.shares[items], self.fraction[items], self.sign[items], self.on[items]
        )

    @classmethod
    def together(cls, some: "list[Simplices]") -> "Simplices":
        """Return all of some simplices."""
        names = ("shares", "fraction", "sign", "on")
        return cls(*(np.concatenate([getattr(each, name) for each in some]) for name in names))


class ClippedSimplices(Struct, frozen=True, eq=False):
    """Simplices on both sides of a level, and what it cuts.

    Attributes:
        inside: All that have a content.
        source: The one that each is a part of, shape (simplex,).
        side: 1 in front, -1 behind, shape (simplex,).
        facets: Shares of the corners of the root, shape (facet, corner, corner of the root).
            Triangles turn to the left as seen from the front; lines have it on their right.
        cut: The simplex that each facet is in, shape (facet,).
        is_known: Whether a facet lies on an earlier level, too, so that there is nothing in
            front of it, shape (facet,).
    """

    inside: Simplices
    source: Indices
    side: Indices
    facets: Floats
    cut: Indices
    is_known: Bools


def clipped(some: Simplices, heights: Floats, flat_side: Indices) -> ClippedSimplices:
    """Return simplices divided by a level, the last one of ``on``.

    Args:
        some: In any cells.
        heights: Of their corners above the level, in any unit, shape (simplex, corner).
        flat_side: Where those with heights of 0 are, 1 or -1, shape (simplex,).
    """
    front, corners = heights >= 0.0, int(heights.shape[1])
    count = front.sum(axis=1)
    uncut = np.flatnonzero((count == 0) | (count == corners))
    on = some.on[uncut].copy()
    on[..., -1] = heights[uncut] == 0.0
    kept = some[uncut]
    inside = [Simplices(kept.shares, kept.fraction, kept.sign, on)]
    side = [
        np.where(on[..., -1].all(axis=1), flat_side[uncut], np.where(front[uncut, 0], 1, -1))
    ]
    source = [uncut]
    every = [np.zeros((0, corners - 1, corners))]
    cut, is_known = [uncut[:0]], [np.zeros(0, dtype=bool)]
    for number, case in _CASES[corners].items():
        own = np.flatnonzero(count == number)
        if not len(own):
            continue
        found, which, at, facets, of = _divided(case, some[own], heights[own], front[own])
        inside.append(found)
        source.append(own[which])
        side.append(at)
        every.append(facets)
        cut.append(own[of])
        zero = heights[own] == 0.0
        known = (some.on[own][..., :-1] | ~zero[..., None]).all(axis=1).any(axis=1)
        is_known.append((known & (zero.sum(axis=1) == corners - 1))[of])
    return ClippedSimplices(
        Simplices.together(inside), np.concatenate(source), np.concatenate(side),
        np.concatenate(every), np.concatenate(cut), np.concatenate(is_known),
    )  # fmt: skip


def _divided(
    case: _Case, some: Simplices, heights: Floats, front: Bools
) -> tuple[Simplices, Indices, Indices, Floats, Indices]:
    """Return parts of simplices of a case, sources and sides, and facets and sources."""
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
    simplices = np.concatenate([case.front, case.behind])
    numbers = np.concatenate([t, s, np.ones((len(t), 1))], axis=1)
    size = numbers[:, case.factors[:, 0]]
    for column in case.factors.T[1:]:
        size = size * numbers[:, column]
    which, kind = np.nonzero(size > 0.0)
    chosen, flips = _in_order(case, simplices[kind], which, order, t)
    row = which[:, None]
    found = Simplices(
        pool[row, chosen], size[which, kind] * some.fraction[which],
        turn[which] * case.signs[kind] * flips, pool_on[row, chosen],
    )  # fmt: skip
    side = np.where(kind < len(case.front), 1, -1)
    facets, of = _facets(case, pool, turn)
    return found, which, side, facets, of


def _in_order(
    case: _Case, chosen: Indices, which: Indices, order: Indices, t: Floats
) -> tuple[Indices, Indices]:
    """Return corners of simplices in the order that others have, too, and its parity.

    A new point that is a corner has the place of the corner.

    Args:
        case: Of the simplices.
        chosen: Corners and points of each part of one, shape (part, corner).
        which: The simplex that it is a part of, shape (part,).
        order: Former places of its corners, shape (simplex, corner).
        t: Part of edges at which points are, shape (simplex, point).
    """
    flips = np.ones(len(chosen), dtype=np.int64)
    own = np.flatnonzero((t == 0.0).any(axis=1)[which])
    if len(own):
        new = order.shape[1] + np.arange(len(case.ends))
        key = np.concatenate(
            [order, np.where(t == 0.0, order[:, case.ends[:, 0]], new)], axis=1
        )
        by = np.argsort(key[which[own, None], chosen[own]], axis=1)
        chosen[own] = np.take_along_axis(chosen[own], by, axis=1)
        flips[own] = parity(by)
    return chosen, flips


def _facets(case: _Case, pool: Floats, turn: Indices) -> tuple[Floats, Indices]:
    """Return facets of a cut which have a content, and their simplices."""
    every = pool[:, case.facets]
    left = (turn[:, None] * case.facing) < 0
    every = np.where(left[..., None, None], turned(every), every)
    of, which = np.nonzero(~are_flat(every))
    return every[of, which], of


def turned(facets: Floats) -> Floats:
    """Return facets that face the other way.

    Args:
        facets: Shares or places of corners, in any unit, shape (…, facet, corner, n).
    """
    last = facets.shape[-2] - 1
    return facets[..., [*range(last - 1), last, last - 1], :]


def are_flat(facets: Floats) -> Bools:
    """Return which facets have two corners in one place, shape (…, facet).

    Args:
        facets: Shares or places of corners, in any unit, shape (…, facet, corner, n).
    """
    before = np.roll(facets, 1, axis=-2)
    return np.asarray((facets == before).all(axis=-1).any(axis=-1))
