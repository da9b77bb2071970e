"""A cubic spline surface through the nodes."""

from functools import lru_cache
from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.fields import Whole
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.patches import NodalSpline, Weights, refine_grid
from tissuec.geometry.surfaces.refinement import Refinement
from tissuec.geometry.surfaces.skin import Skin
from tissuec.model.network import Floats

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
