"""Where points are in elements: natural coordinates, by Newton's method.

    x = Σ_a N_a(ξ) X_a

is solved for ξ of many pairs of a point and an element at once. Beside an element, functions
are continued, so that they reproduce places there, too, and every field that is linear in x.
(R. H. Crawford, D. C. Anderson, W. N. Waggenspack, Int. J. Numer. Meth. Eng. 28:2735, 1989.)
"""

from typing import NamedTuple

import numpy as np

from tissuec.core.arrays import norm
from tissuec.geometry.elements import (
    NodeFunctions,
    prismatic,
    quadratic,
    trilinear,
    triquadratic,
)
from tissuec.model.network import Floats

ROUNDS, CLOSE = 30, 1e-15  # of Newton's method; change of ξ that ends it


class ElementPlaces(NamedTuple):
    """Places of points in elements, for each pair of a point and an element.

    Attributes:
        weights: N_a there, dimensionless, shape (pair, node); NaN if there is no such place.
        beside: Distance from the nearest natural coordinates within the element [m], shape
            (pair,); 0 inside.
    """

    weights: Floats
    beside: Floats


def functions(shape: str, xi: Floats) -> NodeFunctions:
    """Return the dimensionless functions of the nodes of an element.

    Args:
        shape: Name of the shape of the element.
        xi: Natural coordinates, of which those of tetrahedra and the first two of wedges are
            the shares of all corners but the first, shape (point, 3), or (point, 2) of
            triangles.
    """
    match shape:
        case "hexahedron":
            return trilinear(xi)
        case "quadratic hexahedron":
            return triquadratic(xi)
        case "wedge":
            flat = np.column_stack([1.0 - xi[:, 0] - xi[:, 1], xi[:, :2]])
            return prismatic(flat, xi[:, 2])
        case "triangle":
            shares = np.column_stack([1.0 - xi.sum(axis=1), xi])
            steep = np.vstack([-np.ones(2), np.eye(2)])
            return NodeFunctions(shares, np.broadcast_to(steep, (len(xi), 3, 2)))
        case _:
            return quadratic(np.column_stack([1.0 - xi.sum(axis=1), xi]))


def _within(shape: str, xi: Floats) -> Floats:
    """Return natural coordinates moved into the element, shape (point, 3)."""
    if "hexahedron" in shape:
        return np.clip(xi, -1.0, 1.0)
    count = 2 if shape == "wedge" else 3
    shares = np.column_stack([1.0 - xi[:, :count].sum(axis=1), xi[:, :count]]).clip(min=0.0)
    shares /= shares.sum(axis=1)[:, None]
    return np.column_stack([shares[:, 1:], np.clip(xi[:, count:], -1.0, 1.0)])


def _solved(slopes: Floats, left: Floats) -> Floats:
    """Return the solutions of slopes · change = left, the shortest ones if any has many."""
    try:
        return np.linalg.solve(slopes, left[..., None])[..., 0]
    except np.linalg.LinAlgError:  # some are singular
        return np.einsum("pxk,pk->px", np.linalg.pinv(slopes), left)


def places_in(shape: str, points: Floats, corners: Floats) -> ElementPlaces:
    """Return where points are in elements of a shape.

    Args:
        shape: Name of the shape.
        points: [m], shape (pair, 3).
        corners: Of the element of each pair, all nodes of it [m], shape (pair, node, 3).
    """
    middle = {"wedge": [1.0 / 3.0, 1.0 / 3.0, 0.0], "tetrahedron": [0.25, 0.25, 0.25]}
    xi = np.tile(middle.get(shape, [0.0, 0.0, 0.0]), (len(points), 1))
    with np.errstate(all="ignore"):  # of elements without volume
        for _ in range(ROUNDS):
            at = functions(shape, xi)
            left = points - np.einsum("pa,pak->pk", at.values, corners)
            slopes = np.einsum("pak,pax->pkx", corners, at.gradients)
            change = _solved(slopes, left)
            xi = xi + change
            if not np.abs(change).max(initial=0.0) > CLOSE:
                break
        weights = functions(shape, xi).values
        inside = np.einsum("pa,pak->pk", functions(shape, _within(shape, xi)).values, corners)
    return ElementPlaces(weights, norm(points - inside))
