"""Moments of parts of cells, and points of quadrature that match them.

A part has as many points as a whole cell, of the same shares of its volume, at

    ξ_q = c + R u_q,    R = L sqrt(L⁻¹ S L⁻ᵀ),    S_0 = L Lᵀ,

with its volume V, its centroid c and its covariance S in natural coordinates, those of the
whole cell, S_0, and the points u_q of the shape scaled to unit covariance. So they integrate
polynomials of degree 2, and are the usual points in a whole cell. In a cell that is no
parallelepiped, moments have the weight det Z (see ``geometry.elements``), and the mean gradient
is replaced by the exact one,

    ∫ ∂N_a/∂X dV = ∫ ∂N_a/∂ξ Z⁻¹ det Z dξ,

a polynomial of degree 4, or 3 in tetrahedra, so that forces of uniform stress cancel between
parts and uniform strain is exact. In hexahedra with 27 nodes, its degree is 5 in
parallelepipeds, 8 if edges are straight, and up to 15.

Their functions include polynomials of degree up to 6, which hardly strain a small part: the
nodes far from it would have masses, but no stiffness. So values at nodes are divided into what
is quadratic in natural coordinates or linear in places, by least squares, and the rest, and

    ∂u/∂X = (∂u_2/∂X at the points of the part) + (∂(u - u_2)/∂X at those of the whole cell),

but for its mean, which is exact. In a whole cell, nothing changes. (Mean gradients:
D. P. Flanagan, T. Belytschko, Int. J. Numer. Meth. Eng. 17:679, 1981. Points that match moments
are derived here. Fourteen points of degree 5: N. J. Walkington, Quadrature on simplices of
arbitrary dimension, Carnegie Mellon University, 2000.)
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.geometry.cut_cells.parts import CellParts, PartPieces, functions_at
from tissuec.geometry.cut_cells.roots import DIVISIONS
from tissuec.geometry.elements import (
    CUBE_27,
    SHAPES,
    TETRAHEDRAL_POINTS,
    ElementShape,
    Measures,
    trilinear,
)
from tissuec.geometry.natural_coordinates import functions
from tissuec.model.network import Floats

_STRAIGHT = 1e-12  # of Z: what is more even than this changes by rounding
_AT_ONCE = 100_000  # points of pieces whose functions are in memory
_PIECES = 3  # of a root that a level divides, on one side


def _fourteen() -> tuple[Floats, Floats]:
    """Return shares of the corners of a tetrahedron, and parts of its volume."""
    inner = ((0.31088591926330060980, 6 * 0.018781320953002641800),
             (0.092735250310891226402, 6 * 0.012248840519393658257))  # fmt: skip
    edge, weight = 0.045503704125649649492, 6 * 0.0070910034628469110730
    points = [a + (1.0 - 4.0 * a) * np.eye(4) for a, _ in inner]
    ends = np.array([[i, j] for i in range(4) for j in range(i)])
    middles = np.full((6, 4), edge)
    np.put_along_axis(middles, ends, 0.5 - edge, axis=1)
    weights = np.repeat([w for _, w in inner], 4)
    return np.concatenate([*points, middles]), np.concatenate([weights, np.full(6, weight)])


FIFTH_DEGREE = _fourteen()


@cache
def points_of_degree(degree: int) -> tuple[Floats, Floats]:
    """Return points of a tetrahedron that integrate polynomials of a degree exactly.

    They are shares of its corners, shape (point, 4), and dimensionless parts of its volume,
    shape (point,). Above a degree of 5, they are products of the rules of Gauss and Jacobi in
    collapsed coordinates (A. H. Stroud, Approximate Calculation of Multiple Integrals, 1971,
    chapter 2.4).
    """
    if degree <= 2:
        return TETRAHEDRAL_POINTS, np.full(4, 0.25)
    if degree <= 5:
        return FIFTH_DEGREE
    from scipy.special import roots_jacobi

    rules = [roots_jacobi(degree // 2 + 1, power, 0.0) for power in (2, 1, 0)]
    grid = np.meshgrid(*(0.5 + 0.5 * at for at, _ in rules), indexing="ij")
    a, b, c = (each.ravel() for each in grid)
    weights = np.einsum("i,j,k->ijk", *(weight / weight.sum() for _, weight in rules)).ravel()
    shares = [a, (1.0 - a) * b, (1.0 - a) * (1.0 - b) * c, (1.0 - a) * (1.0 - b) * (1.0 - c)]
    return np.stack(shares, axis=1), weights


class _Degrees(NamedTuple):
    """Degrees of polynomials that are integrated exactly over parts of cells.

    Attributes:
        moments: For moments: at least that of det Z, and 2.
        gradients: Of ∂N/∂ξ Z⁻¹ det Z.
        centroids: Of places times det Z.
    """

    moments: int
    gradients: int
    centroids: int

    @classmethod
    def of(cls, shape: str, corners: Floats) -> "_Degrees":
        """Return those for cells whose nodes are at places [m], shape (cell, node, 3)."""
        # Covariances of natural coordinates have a degree of 2 beside that of det Z, which
        # need not be exact.
        is_quadratic = SHAPES[shape].functions > 1
        if _are_affine(SHAPES[shape], corners):
            return cls(2, 5 if is_quadratic else 2, 2)
        if not is_quadratic:
            return cls(5, 5, 7)
        straight = trilinear(CUBE_27).values @ corners[:, :8]
        bend = np.abs(corners - straight).max(initial=0.0)
        if bend <= _STRAIGHT * np.ptp(corners, axis=1).max(initial=0.0):
            return cls(5, 8, 7)
        return cls(15, 15, 21)


class PartMoments(Struct, frozen=True, eq=False):
    """Moments of parts of cells.

    Attributes:
        volume: As drawn [m³], shape (part,).
        centroid: In natural coordinates, shape (part, 3).
        covariance: Mean of (ξ - c) ⊗ (ξ - c), shape (part, 3, 3).
    """

    volume: Floats
    centroid: Floats
    covariance: Floats

    @classmethod
    def of(cls, parts: CellParts, corners: Floats) -> "PartMoments":
        """Return the moments of all parts.

        Args:
            parts: Of cells of one shape.
            corners: Drawn places of their nodes [m], shape (part, node, 3).
        """
        degrees = _Degrees.of(parts.shape, corners)
        pieces = parts.with_roots(np.ones(len(parts), dtype=bool))
        cloud, count = _Cloud.of(parts, pieces, corners, degrees.moments), len(parts)
        volume = _sums(pieces, cloud.weight.sum(axis=1), count)
        centroid = _sums(pieces, np.einsum("pq,pqx->px", cloud.weight, cloud.xi), count)
        centroid /= volume[:, None]
        away = cloud.xi - centroid[pieces.part][:, None]
        outer = np.einsum("pq,pqx,pqy->pxy", cloud.weight, away, away)
        covariance = _sums(pieces, outer, count) / volume[:, None, None]
        return cls(volume, centroid, covariance)


class _Cloud(Struct, frozen=True, eq=False):
    """Points of pieces that integrate polynomials exactly.

    Attributes:
        xi: Natural coordinates, shape (piece, point, 3).
        weight: As drawn [m³], shape (piece, point).
    """

    xi: Floats
    weight: Floats

    @classmethod
    def of(cls, parts: CellParts, pieces: PartPieces, corners: Floats, degree: int) -> "_Cloud":
        """Return points for polynomials of a degree, for one of 2 in parallelepipeds."""
        points, weights = points_of_degree(degree)
        xi = parts.natural(pieces, points @ pieces.inside.shares)
        size = pieces.inside.fraction[:, None] * weights * parts.division.volume
        if degree == 2:
            sides = SHAPES[parts.shape].sides(corners)[:, 0]
            return cls(xi, size * np.linalg.det(sides)[pieces.part, None])
        sides = _sides(parts.shape, xi, corners[pieces.part])
        return cls(xi, size * np.linalg.det(sides))


def _are_affine(shape: ElementShape, corners: Floats) -> bool:
    """Return whether the natural coordinates of all cells are linear in places."""
    sides = shape.sides(corners)
    change = np.abs(sides - sides[:, :1]).max(axis=(1, 2, 3), initial=0.0)
    return bool((change <= _STRAIGHT * np.abs(sides).max(axis=(1, 2, 3), initial=0.0)).all())


def _sides(shape: str, xi: Floats, corners: Floats) -> Floats:
    """Return Z [m] at points of cells, shape (cell, point, 3, 3)."""
    steep = functions_at(shape, xi).gradients
    return np.einsum("pax,pqak->pqxk", corners, steep)


def _sums(pieces: PartPieces, values: Floats, count: int) -> Floats:
    """Return sums over the pieces of each part, in their unit, shape (part, …)."""
    starts = np.searchsorted(pieces.part, np.arange(count))
    return np.add.reduceat(values, starts, axis=0)


def part_centroids(parts: CellParts, corners: Floats) -> Floats:
    """Return centroids of parts as drawn [m], shape (part, 3).

    Args:
        parts: Of cells of one shape.
        corners: Drawn places of their nodes [m], shape (part, node, 3).
    """
    pieces = parts.with_roots(np.ones(len(parts), dtype=bool))
    points, weights = points_of_degree(_Degrees.of(parts.shape, corners).centroids)
    first, volume = np.zeros((len(pieces), 3)), np.zeros(len(pieces))
    for point, part in zip(points, weights, strict=True):
        xi = parts.natural(pieces, point @ pieces.inside.shares[:, None])
        at = functions(parts.shape, xi[:, 0])
        own = corners[pieces.part]
        sides = np.einsum("pax,pak->pxk", own, at.gradients)
        content = part * pieces.inside.fraction * np.linalg.det(sides)
        volume += content
        first += content[:, None] * np.einsum("pa,pax->px", at.values, own)
    total = _sums(pieces, volume, len(parts))
    return _sums(pieces, first, len(parts)) / total[:, None]


def measures(parts: CellParts, corners: Floats) -> Measures:
    """Return gradients and volumes at the points of parts.

    Of hexahedra, deviations of gradients from their mean are multiplied by √(3/4), so that
    bending has three quarters of its energy. Those of other shapes stay.

    Args:
        parts: Of cells of one shape.
        corners: Drawn places of their nodes [m], shape (part, node, 3).
    """
    points, _ = points_of_degree(_Degrees.of(parts.shape, corners).gradients)
    count = max(1, _AT_ONCE // (_PIECES * parts.division.count * len(points)))
    found: list[Measures] = []
    for first in range(0, max(len(parts), 1), count):
        own = np.zeros(len(parts), dtype=bool)
        own[first : first + count] = True
        found.append(_measures_of_few(parts.some(own), corners[own]))
    return Measures(
        np.concatenate([each.gradients for each in found]),
        np.concatenate([each.volume for each in found]),
    )


def _measures_of_few(parts: CellParts, corners: Floats) -> Measures:
    """Return ``measures`` of parts that are so few that their points fit into memory."""
    shape, moments = SHAPES[parts.shape], PartMoments.of(parts, corners)
    share = shape.weights / shape.weights.sum()
    points = matched_points(parts, moments)
    steep = functions_at(parts.shape, points).gradients
    sides = np.einsum("pax,pqak->pqxk", corners, steep)
    inverse = np.asarray(np.linalg.inv(sides), dtype=float)
    gradients = np.einsum("pqak,pqkx->pqax", steep, inverse)
    if shape.functions > 1:
        usual, smooth = Measures.of(shape, corners).gradients, _quadratic_parts(corners)
        gradients = usual + smooth.swapaxes(1, 2)[:, None] @ (gradients - usual)
    mean = np.einsum("q,pqax->pax", share, gradients)[:, None]
    factor = np.sqrt(0.75) if parts.shape == "hexahedron" else 1.0
    degree = _Degrees.of(parts.shape, corners).gradients
    exact = mean if degree == 2 else _mean(parts, corners, degree)[:, None]
    gradients = exact + factor * (gradients - mean)
    return Measures(np.ascontiguousarray(gradients), moments.volume[:, None] * share)


def _quadratic_parts(corners: Floats) -> Floats:
    """Return u_2 by u of hexahedra with 27 nodes, dimensionless, shape (part, node, node).

    Args:
        corners: Drawn places of their nodes [m], shape (part, node, 3).
    """
    i, j = np.triu_indices(3)
    known = [np.ones((27, 1)), CUBE_27, CUBE_27[:, i] * CUBE_27[:, j]]
    columns = np.broadcast_to(np.hstack(known), (len(corners), 27, 10))
    size = np.ptp(corners, axis=(1, 2), keepdims=True)
    columns = np.concatenate([columns, (corners - corners[:, :1]) / size], axis=2)
    return np.asarray(columns @ np.linalg.pinv(columns, rcond=_STRAIGHT), dtype=float)


def linear_functions(shape: str) -> Floats:
    """Return φ_k at points of parts, on which their volume is projected.

    The first is constant; of shapes with three more, these are linear in natural coordinates,
    and all are orthonormal with the shares of the points as weights, whatever the part is.

    They are dimensionless, of shape (point, function).
    """
    unit, _ = _reference(shape)
    return np.column_stack([np.ones(len(unit)), unit])[:, : SHAPES[shape].functions]


def matched_points(parts: CellParts, moments: PartMoments) -> Floats:
    """Return natural coordinates of points, dimensionless, shape (part, point, 3)."""
    unit, root = _reference(parts.shape)
    inverse = np.linalg.inv(root)
    values, ways = np.linalg.eigh(inverse @ moments.covariance @ inverse.T)
    size = np.sqrt(np.maximum(values, 0.0))[:, None]
    found = root @ (ways * size) @ ways.swapaxes(1, 2)
    return moments.centroid[:, None] + np.einsum("pxy,qy->pqx", found, unit)


def _reference(shape: str) -> tuple[Floats, Floats]:
    """Return points of a shape scaled to unit covariance, and the root of that of the cell."""
    at, share = _usual_points(shape), SHAPES[shape].weights / SHAPES[shape].weights.sum()
    away = at - share @ at
    root: Floats = np.asarray(np.linalg.cholesky((share * away.T) @ away), dtype=float)
    return np.asarray(np.linalg.solve(root, away.T), dtype=float).T, root


def _usual_points(shape: str) -> Floats:
    """Return natural coordinates of the points of a shape, shape (point, 3)."""
    if shape == "tetrahedron":
        return TETRAHEDRAL_POINTS[:, 1:]
    return SHAPES[shape].lumped @ DIVISIONS[shape].places


def _mean(parts: CellParts, corners: Floats, degree: int) -> Floats:
    """Return exact means of ∂N_a/∂X over parts [1/m], shape (part, node, 3)."""
    pieces = parts.with_roots(np.ones(len(parts), dtype=bool))
    points, weights = points_of_degree(degree)
    xi = parts.natural(pieces, points @ pieces.inside.shares)
    steep = functions_at(parts.shape, xi).gradients
    sides = np.einsum("pax,pqak->pqxk", corners[pieces.part], steep)
    size = np.linalg.det(sides) * weights * pieces.inside.fraction[:, None]
    inverse = np.asarray(np.linalg.inv(sides), dtype=float)
    gradients = np.einsum("pq,pqak,pqkx->pax", size, steep, inverse)
    total = _sums(pieces, size.sum(axis=1), len(parts))
    return _sums(pieces, gradients, len(parts)) / total[:, None, None]
