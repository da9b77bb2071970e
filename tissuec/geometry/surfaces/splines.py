"""Cubic spline surfaces: through the nodes, or near them."""

from functools import lru_cache
from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.fields import Whole
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.patches import NodalSpline, Weights, refine_grid
from tissuec.geometry.surfaces.skin import Refinement, Skin
from tissuec.model.network import Floats


@SURFACES.member("approximating spline")
class ApproximatingSpline(Struct, frozen=True):
    """A bicubic spline whose control points are the nodes of a tube or sheet.

    It stays within the hull of the nodes and never overshoots. A tube therefore becomes
    thinner, one of 10 sides by 6 %. The surface of a tube closes without a seam. At ends and
    torn edges it is one-sided, and ends in the curve of the last nodes.

    Attributes:
        subdivisions: How often every edge is halved.
    """

    needs_grid: ClassVar[bool] = True
    subdivisions: Annotated[int, Whole(at_least=1, at_most=6)] = 2

    def refine(self, skin: Skin) -> Refinement:
        """Return the map from nodes to the spline."""
        return refine_grid(skin, near_nodes, 2**self.subdivisions)


def near_nodes(count: int, closed: bool) -> NodalSpline:
    """Return the uniform cubic B-spline of nodes in a row, as values and slopes at the nodes.

    With neighbours a and c of a node b they are (a + 4 b + c) / 6 and (c - a) / 2. Beyond an
    end b with the neighbour a, the next node is 2 b - a, so that the spline ends at b.
    """
    return NodalSpline(
        _stencil(count, closed, np.array([1.0, 4.0, 1.0]) / 6.0),
        _stencil(count, closed, np.array([-0.5, 0.0, 0.5])),
    )


def _stencil(count: int, closed: bool, weights: Floats) -> Weights:
    """Return weights of the node before, the node itself and the one after, for all nodes."""
    row = np.repeat(np.arange(count), 3)
    column = row + np.tile([-1, 0, 1], count)
    weight = np.tile(weights, count)
    if closed:
        return Weights(row, column % count, weight)
    if count == 1:
        return Weights(row[:1], row[:1], weights.sum(keepdims=True))
    # The node beyond an end is twice the end less the one inside.
    beyond = (column < 0) | (column == count)
    end, inside = row[beyond], np.clip(2 * row[beyond] - column[beyond], 0, count - 1)
    outer = weight[beyond]
    return Weights(
        np.concatenate([row[~beyond], end, end]),
        np.concatenate([column[~beyond], end, inside]),
        np.concatenate([weight[~beyond], 2.0 * outer, -outer]),
    )


_REACH = 36
"""Nodes beyond which a spline forgets: the weight of a node falls by 2 - √3 from one to the
next, below a rounding error of the largest after 28."""
_NOTHING = 1e-18


@SURFACES.member("interpolating spline")
class InterpolatingSpline(Struct, frozen=True):
    """A bicubic spline through all nodes of a tube or sheet, with continuous curvature.

    The surface of a tube closes without a seam. At ends and torn edges it is one-sided, and its
    last two pieces are one cubic ("not a knot").

    Attributes:
        subdivisions: How often every edge is halved.
    """

    needs_grid: ClassVar[bool] = True
    subdivisions: Annotated[int, Whole(at_least=1, at_most=6)] = 2

    def refine(self, skin: Skin) -> Refinement:
        """Return the map from nodes to the spline."""
        return refine_grid(skin, through_nodes, 2**self.subdivisions)


@lru_cache(maxsize=256)
def through_nodes(count: int, closed: bool) -> NodalSpline:
    """Return the cubic spline through nodes in a row, as values and slopes at the nodes."""
    number = np.arange(count)
    value = Weights(number, number, np.ones(count))
    if count < 2:
        return NodalSpline(value, Weights(number[:0], number[:0], np.zeros(0)))
    if closed:  # every node has the weights of the first, shifted
        weight = _slopes(min(count, 2 * _REACH), closed=True)[0]
        step = np.arange(len(weight))
        step = (step + len(weight) // 2) % len(weight) - len(weight) // 2
        row = np.repeat(number, len(weight))
        column = (row + np.tile(step, count)) % count
        return NodalSpline(value, Weights(row, column, np.tile(weight, count)))
    slope = _slopes(min(count, 2 * _REACH), closed=False)
    # Of a long row the two ends are those of a shorter one, and all between is alike.
    like = np.maximum(np.minimum(number, _REACH), len(slope) - count + number)
    row, near = np.nonzero(np.abs(slope[like]) > _NOTHING)
    return NodalSpline(value, Weights(row, row + near - like[row], slope[like[row], near]))


def _slopes(count: int, *, closed: bool) -> Floats:
    """Return the slopes of the spline at the nodes, shape (node, node)."""
    from scipy.interpolate import CubicSpline

    unit = np.eye(count)
    if closed:
        ring = np.vstack([unit, unit[:1]])
        return CubicSpline(np.arange(count + 1), ring, bc_type="periodic")(np.arange(count), 1)
    return CubicSpline(np.arange(count), unit, bc_type="not-a-knot")(np.arange(count), 1)
