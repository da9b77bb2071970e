"""Cubic spline surfaces: through the nodes, or near them.

Surfaces of bicubic patches over a grid of nodes.

A bicubic spline on a grid is known by four vectors at each node: the position p, the slopes
p_u along the row and p_v down the column, and the twist p_uv. Each comes from splines in one
direction only (de Boor, "Bicubic spline interpolation", J. Math. Phys. 41, 1962): p_u from
splines along the rows, p_v from splines down the columns, and p_uv from such splines through
p_u. Between four nodes the surface is the patch that has these vectors at its corners,

    S(u, v) = Σ H_a(v) H_b(u) of the vectors,    H: cubic Hermite polynomials.

On a whole grid this is the tensor-product spline. On a torn one every row and column ends at
its torn edges, so that all splines are one-sided there, and of a patch that has lost an edge at
most half is left. Node numbers are parameters, so that the surface is linear in the positions.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.fields import Whole
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.skin import Refinement, Skin
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: The corners of a cell are (0, 0), (0, 1), (1, 0) and (1, 1), as (row, column). For the one
#: that a half lacks is the sum of the two beside it less the one opposite.
_FOURTH = ((2, (0, 3), 1), (1, (0, 3), 2))  # (missing, added, taken away)


class Weights(NamedTuple):
    """A sparse matrix, entry by entry."""

    row: Indices
    column: Indices
    weight: Floats


class NodalSpline(NamedTuple):
    """A cubic spline at nodes in a row: its values and its slopes per node."""

    value: Weights
    slope: Weights


#: Takes the number of nodes in a row, and whether the last is followed by the first.
SplineOf = Callable[[int, bool], NodalSpline]


def refine_grid(skin: Skin, spline: SplineOf, pieces: int) -> Refinement:
    """Return the map from the nodes of a grid to a surface of bicubic patches.

    Args:
        skin: A skin whose nodes form a grid.
        spline: Spline in one direction.
        pieces: Number of pieces that each edge is divided into.
    """
    from scipy.sparse import block_diag, csr_array, vstack

    assert skin.grid is not None
    rows, columns, _ = skin.grid
    number = np.arange(skin.nodes).reshape(rows, columns)
    value, slope = _splines(number, skin.along, spline)
    u_first = csr_array(vstack([value, slope]))
    value, slope = _splines(number.T, skin.down.T, spline)
    then_v = csr_array(vstack([block_diag([value] * 2), block_diag([slope] * 2)]))
    patches, triangles = _patches(skin, pieces)
    return Refinement((u_first, then_v, patches), triangles)


def _splines(
    lines: Indices, joined: NDArray[np.bool_], spline: SplineOf
) -> "tuple[csr_array, csr_array]":
    """Return the maps from node positions to values and slopes of splines along lines.

    Args:
        lines: Node numbers, shape (line, place).
        joined: Whether each place is joined to the next one and the last to the first.
    """
    from scipy.sparse import csr_array

    alike: dict[tuple[int, bool], list[Indices]] = {}
    for line, links in zip(lines, joined, strict=True):
        for run, closed in _runs(line, links):
            alike.setdefault((len(run), closed), []).append(run)
    found: list[csr_array] = []
    for part in (0, 1):
        rows: list[Indices] = []
        columns: list[Indices] = []
        weights: list[Floats] = []
        for (length, closed), runs in alike.items():
            row, column, weight = spline(length, closed)[part]
            nodes = np.stack(runs)
            rows.append(nodes[:, row].ravel())
            columns.append(nodes[:, column].ravel())
            weights.append(np.tile(weight, len(nodes)))
        where = np.concatenate(rows), np.concatenate(columns)
        shape = lines.size, lines.size
        found.append(csr_array((np.concatenate(weights), where), shape=shape))
    return found[0], found[1]


def _runs(line: Indices, joined: NDArray[np.bool_]) -> Iterator[tuple[Indices, bool]]:
    """Yield the unbroken runs of a line, and whether each of them is a ring."""
    breaks = np.flatnonzero(~joined) + 1
    if not len(breaks):
        yield line, True
        return
    begun = np.roll(line, -breaks[-1])
    for run in np.split(begun, (breaks[:-1] - breaks[-1]) % len(line)):
        yield run, False


def _patches(skin: Skin, pieces: int) -> "tuple[csr_array, Indices]":
    """Return the map from the vectors at all nodes to the surface, and its triangles."""
    from scipy.sparse import csr_array

    assert skin.grid is not None
    _, columns, closed = skin.grid
    whole = skin.is_whole.reshape(-1, 2)
    is_mirrored = skin.triangles[0, 1] != skin.triangles[0, 0] + 1
    corners = skin.triangles.reshape(-1, 6)[:, [0, 2, 4, 1] if is_mirrored else [0, 1, 5, 2]]
    width = columns * pieces if closed else (columns - 1) * pieces + 1
    place, triangles = _divided(pieces)
    row, column = np.divmod(corners[:, :1], columns)
    point = (row * pieces + place[:, 0]) * width + (column * pieces + place[:, 1]) % width
    drawn = whole[:, _half_of(pieces)]  # (cell, triangle)
    # One cell for each point: on an edge, both of its cells give the same weights.
    points, first, triangle = np.unique(
        point[:, triangles][drawn], return_index=True, return_inverse=True
    )
    cell, corner = (part[first // 3] for part in np.nonzero(drawn))
    kind = np.where(whole.all(axis=1), 0, 1 + whole.argmax(axis=1))[cell]
    # Both of shape (point, vector, corner).
    weights = _patch_weights(pieces)[kind, triangles[corner, first % 3]]
    vector = np.arange(4)[:, None] * skin.nodes + corners[cell][:, None, :]
    start = np.arange(len(points) + 1) * 16
    shape = len(points), 4 * skin.nodes
    matrix = csr_array((weights.ravel(), vector.ravel(), start), shape=shape)
    matrix.eliminate_zeros()
    triangle = triangle.reshape(-1, 3)
    return matrix, triangle[:, [0, 2, 1]] if is_mirrored else triangle


@lru_cache(maxsize=8)
def _divided(pieces: int) -> tuple[Indices, Indices]:
    """Return the points of a divided cell as (row, column), and its triangles."""
    number = np.arange((pieces + 1) ** 2).reshape(pieces + 1, pieces + 1)
    start, beside = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    below, ahead = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    halves = (start, beside, ahead), (start, ahead, below)
    place = np.stack(np.divmod(number.ravel(), pieces + 1), axis=1)
    return place, np.moveaxis(np.array(halves), -1, 0).reshape(-1, 3)


def _half_of(pieces: int) -> Indices:
    """Return in which half of its cell each triangle of a divided cell lies."""
    row, column = np.divmod(np.arange(pieces**2), pieces)
    on_diagonal = np.tile([0, 1], (pieces**2, 1))
    return np.where((row == column)[:, None], on_diagonal, (row > column)[:, None]).ravel()


@lru_cache(maxsize=8)
def _patch_weights(pieces: int) -> Floats:
    """Return how the vectors at the corners weigh at each point of a cell.

    Returns:
        Shape (3, point, vector, corner): of a whole cell, and of either half of one whose other
        half is gone. Vectors are p, p_u, p_v, p_uv.
    """
    t = np.arange(pieces + 1) / pieces
    value = np.stack([(1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)])
    slope = np.stack([t * (1 - t) ** 2, t**2 * (t - 1)])
    hermite = np.stack([value, slope])  # (value or slope, corner, t)
    both = np.einsum("xai,ybj->ijxyab", hermite, hermite).reshape(-1, 4, 4)
    found = [both]
    for missing, added, taken in _FOURTH:
        half = both.copy()
        half[..., added] += half[..., [missing]]
        half[..., taken] -= half[..., missing]
        half[..., missing] = 0.0
        found.append(half)
    return np.stack(found)


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
