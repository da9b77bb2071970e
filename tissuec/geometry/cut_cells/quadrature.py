"""Moments of parts of cells, and points of quadrature that match them.

A part has as many points as a whole cell, of equal weights V/n, at

    ξ_q = c + R u_q,    R = L sqrt(L⁻¹ S L⁻ᵀ),    S_0 = L Lᵀ,

with its volume V, its centroid c and its covariance S in natural coordinates, those of the
whole cell, S_0, and the points u_q of the shape scaled to unit covariance. So they integrate
polynomials of degree 2, and are the usual points in a whole cell. In a cell that is no
parallelepiped, moments have the weight det Z (see ``geometry.elements``), and the mean gradient
is replaced by the exact one,

    ∫ ∂N_a/∂X dV = ∫ ∂N_a/∂ξ Z⁻¹ det Z dξ,

a polynomial of degree 4, or 3 in tetrahedra, so that forces of uniform stress cancel between
parts and uniform strain is exact. (Mean gradients: D. P. Flanagan, T. Belytschko, Int. J.
Numer. Meth. Eng. 17:679, 1981. Points that match moments are derived here. Fourteen points of
degree 5: N. J. Walkington, Quadrature on simplices of arbitrary dimension, Carnegie Mellon
University, 2000.)
"""

import numpy as np
from msgspec import Struct

from tissuec.geometry.cut_cells.parts import CellParts, PartPieces, functions_at
from tissuec.geometry.elements import SHAPES, TETRAHEDRAL_POINTS, ElementShape, Measures
from tissuec.geometry.natural_coordinates import functions
from tissuec.model.network import Floats

_STRAIGHT = 1e-12  # of Z: what is more even than this changes by rounding


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


def _collapsed() -> tuple[Floats, Floats]:
    """Return points of a tetrahedron as ``_fourteen`` does, for degrees up to 7.

    They are products of Gauss's rules in collapsed coordinates (P. J. Davis, P. Rabinowitz,
    Methods of Numerical Integration, 2nd edition, 1984). Places times det Z have degree 7.
    """
    line, weight = np.polynomial.legendre.leggauss(5)
    a, b, c = (0.5 + 0.5 * each.ravel() for each in np.meshgrid(line, line, line))
    size = np.einsum("i,j,k->jik", weight, weight, weight).ravel() / 8.0
    weights = 6.0 * size * (1.0 - a) ** 2 * (1.0 - b)
    shares = [a, (1.0 - a) * b, (1.0 - a) * (1.0 - b) * c, (1.0 - a) * (1.0 - b) * (1.0 - c)]
    return np.stack(shares, axis=1), weights


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
        pieces = parts.with_roots(np.ones(len(parts), dtype=bool))
        cloud, count = _Cloud.of(parts, pieces, corners), len(parts)
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
    def of(cls, parts: CellParts, pieces: PartPieces, corners: Floats) -> "_Cloud":
        affine = _are_affine(SHAPES[parts.shape], corners)
        # Of a parallelepiped, covariances have degree 2; of others, those of natural
        # coordinates have degree 6, which need not be exact.
        points, weights = FIFTH_DEGREE
        if affine:
            points, weights = TETRAHEDRAL_POINTS, np.full(4, 0.25)
        xi = parts.natural(pieces, points @ pieces.inside.shares)
        size = pieces.inside.fraction[:, None] * weights * parts.division.volume
        if affine:
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
    points, weights = np.full((1, 4), 0.25), np.ones(1)
    if not _are_affine(SHAPES[parts.shape], corners):
        points, weights = _collapsed()
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
    bending has three quarters of its energy. Those of wedges and of tetrahedra stay.

    Args:
        parts: Of cells of one shape.
        corners: Drawn places of their nodes [m], shape (part, node, 3).
    """
    shape, moments = SHAPES[parts.shape], PartMoments.of(parts, corners)
    points = matched_points(parts, moments)
    steep = functions_at(parts.shape, points).gradients
    sides = np.einsum("pax,pqak->pqxk", corners, steep)
    inverse = np.asarray(np.linalg.inv(sides), dtype=float)
    gradients = np.einsum("pqak,pqkx->pqax", steep, inverse)
    mean = gradients.mean(axis=1, keepdims=True)
    factor = np.sqrt(0.75) if parts.shape == "hexahedron" else 1.0
    exact = mean if _are_affine(shape, corners) else _mean(parts, corners)[:, None]
    gradients = exact + factor * (gradients - mean)
    volume = np.repeat(moments.volume[:, None] / points.shape[1], points.shape[1], axis=1)
    return Measures(np.ascontiguousarray(gradients), volume)


def matched_points(parts: CellParts, moments: PartMoments) -> Floats:
    """Return natural coordinates of points, dimensionless, shape (part, point, 3)."""
    unit, root = _reference(parts)
    inverse = np.linalg.inv(root)
    values, ways = np.linalg.eigh(inverse @ moments.covariance @ inverse.T)
    size = np.sqrt(np.maximum(values, 0.0))[:, None]
    found = root @ (ways * size) @ ways.swapaxes(1, 2)
    return moments.centroid[:, None] + np.einsum("pxy,qy->pqx", found, unit)


def _reference(parts: CellParts) -> tuple[Floats, Floats]:
    """Return points of a shape scaled to unit covariance, and the root of that of the cell."""
    at = _usual_points(parts)
    away = at - at.mean(axis=0)
    root: Floats = np.asarray(np.linalg.cholesky(away.T @ away / len(at)), dtype=float)
    return np.asarray(np.linalg.solve(root, away.T), dtype=float).T, root


def _usual_points(parts: CellParts) -> Floats:
    """Return natural coordinates of the points of a shape, shape (point, 3)."""
    if parts.shape == "tetrahedron":
        return TETRAHEDRAL_POINTS[:, 1:]
    return SHAPES[parts.shape].lumped @ parts.division.corners


def _mean(parts: CellParts, corners: Floats) -> Floats:
    """Return exact means of ∂N_a/∂X over parts [1/m], shape (part, node, 3)."""
    pieces = parts.with_roots(np.ones(len(parts), dtype=bool))
    points, weights = FIFTH_DEGREE
    xi = parts.natural(pieces, points @ pieces.inside.shares)
    steep = functions_at(parts.shape, xi).gradients
    sides = np.einsum("pax,pqak->pqxk", corners[pieces.part], steep)
    size = np.linalg.det(sides) * weights * pieces.inside.fraction[:, None]
    inverse = np.asarray(np.linalg.inv(sides), dtype=float)
    gradients = np.einsum("pq,pqak,pqkx->pax", size, steep, inverse)
    total = _sums(pieces, size.sum(axis=1), len(parts))
    return _sums(pieces, gradients, len(parts)) / total[:, None, None]
