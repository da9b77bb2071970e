"""A cubic spline surface near the nodes."""

from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.fields import Whole
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.patches import NodalSpline, Weights, refine_grid
from tissuec.geometry.surfaces.refinement import Refinement
from tissuec.geometry.surfaces.skin import Skin
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
