"""Points of bodies of elements: the element that contains one, and its parts there.

A place has the parts N_a of the nodes of its element, and moves with these. Numbers at the
points of an element are continued by the functions that they determine: those of its nodes, and
in tetrahedra the linear ones.
"""

from typing import NamedTuple

import numpy as np

from tissuec.geometry.elements import MIDDLES, SHAPES, TETRAHEDRAL_POINTS
from tissuec.geometry.natural_coordinates import places_in
from tissuec.meshes.elements import TRIANGLE
from tissuec.meshes.generators import ElementMesh
from tissuec.model.network import Floats, Indices

NEAR = 1e-6  # of the size of an element: how far a point in it may be outside, by rounding
MANY = 64  # elements of a shape that are looked at, those whose boxes are nearest


class PointPlace(NamedTuple):
    """Where a point is in a body.

    Attributes:
        nodes: Of its element, numbered in the body, shape (node,).
        weights: Of these nodes, dimensionless, shape (node,).
        of_points: Of the points of the element, dimensionless, shape (point,).
        beside: How far it is outside of the element [m].
        size: Of the element [m].
    """

    nodes: Indices
    weights: Floats
    of_points: Floats
    beside: float
    size: float

    @property
    def is_outside(self) -> bool:
        """Return whether the point is not in the body."""
        return not self.beside <= NEAR * self.size


def place_of_point(
    elements: tuple[ElementMesh, ...], position: Floats, point: Floats
) -> PointPlace:
    """Return where a point is in a body, in the element that is nearest to it.

    Args:
        elements: Of the body; there are some.
        position: Of its nodes as drawn [m], shape (node, 3).
        point: [m], shape (3,).
    """
    return min(
        (_place(one, position, point) for one in elements if len(one.nodes)),
        key=lambda found: found.beside,
    )


def _place(elements: ElementMesh, position: Floats, point: Floats) -> PointPlace:
    """Return where a point is in the nearest of the elements of a shape."""
    corners = position[elements.nodes]
    low, high = corners.min(axis=1), corners.max(axis=1)
    apart = np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0), axis=1)
    some = np.argsort(apart, kind="stable")[:MANY]
    corners, points = corners[some], np.tile(point, (len(some), 1))
    if elements.shape == TRIANGLE:
        weights, beside = _in_triangles(corners, points)
    else:
        weights, beside = places_in(elements.shape, points, corners)
    nearest = int(np.argmin(np.where(np.isfinite(beside), beside, np.inf)))
    own = weights[nearest]
    size = float(np.ptp(corners[nearest], axis=0).max())
    return PointPlace(
        elements.nodes[some[nearest]], own, _of_points(elements.shape, own),
        float(beside[nearest]), size,
    )  # fmt: skip


def _in_triangles(corners: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Return shares of corners, and distances from the planes or sides of triangles [m].

    Args:
        corners: [m], shape (triangle, 3, 3).
        points: [m], shape (triangle, 3).
    """
    sides = (corners[:, 1:] - corners[:, :1]).swapaxes(1, 2)
    share = np.einsum("tkx,tx->tk", np.linalg.pinv(sides), points - corners[:, 0])
    weights = np.column_stack([1.0 - share.sum(axis=1), share])
    within = weights.clip(min=0.0)
    within /= within.sum(axis=1)[:, None]
    nearest = np.einsum("ta,tax->tx", within, corners)
    return weights, np.linalg.norm(points - nearest, axis=1)


def _of_points(shape: str, weights: Floats) -> Floats:
    """Return the parts of the points of an element, shape (point,), where nodes have parts."""
    if shape == TRIANGLE:
        return np.ones(1)
    if shape == "tetrahedron":
        corners = weights[:4].copy()
        np.add.at(corners, MIDDLES, 0.5 * weights[4:, None])
        return np.linalg.solve(TETRAHEDRAL_POINTS.T, corners)
    return np.linalg.solve(SHAPES[shape].lumped.T, weights)
