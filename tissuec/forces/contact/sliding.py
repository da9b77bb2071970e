"""The part of the stiffness of contact from nearest points that slide along shapes.

The distance s of a point from a shape is the smallest over the weights w of its corners. With e
= δx - Σ w_a δx_a, the normal n, the sides b_i along which the place may move, their products
M_ij = b_i·b_j, their changes β_i, and the part Q of the unit matrix across n and all b_i,

    δ²s = e·Q e / s - 2 Σ (b_i·e) M⁻¹_ij (n·β_j) - s Σ (n·β_i) M⁻¹_ij (n·β_j),

because δ²(s²/2) = e·e - Σ g_i M⁻¹_ij g_j with g_i = b_i·e + s n·β_i: the last term is the gain
from weights that follow. The first term is the curvature of shapes that do not turn; the others
say how normals and weights follow corners that move.
"""

import numpy as np

from tissuec.geometry.nearest import PLANE, NearestPlace
from tissuec.model.network import Floats, Indices


def turning(
    place: NearestPlace, kind: Indices, corners: Floats, gap: Floats, shares: Floats
) -> Floats:
    """Return minus the last two terms of δ²s, as matrices [1/m], shape (pair, 4, 3, 4, 3).

    Args:
        place: Where points are in shapes.
        kind: Of the shapes, shape (pair,); planes get zeros.
        corners: Of the shapes [m], shape (pair, 3, 3).
        gap: Distances s [m], shape (pair,).
        shares: Of the point and of the corners in e, shape (pair, 4).
    """
    found = np.zeros((len(kind), 4, 3, 4, 3))
    on = (place.weights > 0.0) & (kind != PLANE)[:, None]
    for free in (1, 2):
        some = np.flatnonzero(on.sum(axis=1) == free + 1)
        if not len(some):
            continue
        ends = np.nonzero(on[some])[1].reshape(-1, free + 1)
        at = np.take_along_axis(corners[some], ends[:, :, None], axis=1)
        sides = at[:, 1:] - at[:, :1]
        products = np.einsum("pik,pjk->pij", sides, sides)
        inverse = np.asarray(np.linalg.inv(products), dtype=float)
        # n·β as rows of numbers by which displacements are multiplied.
        turns = np.zeros((len(some), free, 4))
        row = np.arange(len(some))
        for i in range(free):
            turns[row, i, 1 + ends[:, 1 + i]] = 1.0
            turns[row, i, 1 + ends[:, 0]] = -1.0
        turned = np.einsum("pia,pk->piak", turns, place.normal[some])
        follows = np.einsum("pij,pjk,pa->piak", inverse, sides, shares[some])
        cross = np.einsum("piak,pibl->pakbl", follows, turned)
        both = np.einsum("pij,piak,pjbl->pakbl", inverse, turned, turned)
        found[some] = (
            cross + cross.transpose(0, 3, 4, 1, 2) + gap[some, None, None, None, None] * both
        )
    return found
