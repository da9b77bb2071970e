"""Points of parts of elements that blades have divided, by a quadrature of their moments.

A part is integrated over its tetrahedra by a product of Gauss's rules in collapsed coordinates
(A. H. Stroud, Approximate Calculation of Multiple Integrals, 1971, chapter 2.4). Its points are
those of a whole cell, moved and stretched so that their mean and their covariance are those of
the part; their mean of ∂N/∂X is made exact. In hexahedra with 27 nodes, what is neither
quadratic in natural coordinates nor linear in places has the slopes of the whole cell.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray
from scipy.linalg import sqrtm

Floats = NDArray[np.float64]
LESS = {"hexahedron": np.sqrt(0.75)}  # of what gradients differ by from their mean


def point_measures(
    parts: Any, usual: Floats, factors: Floats, nodes: Floats, corners: Floats,
    slopes: Callable[[Floats], Floats],
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return ∂N/∂X, shape (part, point, node, 3), and volumes of points [m³], (part, point).

    Args:
        parts: ``geometry.cut_cells.parts.CellParts`` that are not whole, read for their pieces.
        usual: Natural coordinates of the points of whole cells, shape (point, 3).
        factors: Their parts of the volume in natural coordinates, in any unit, shape (point,).
        nodes: Natural coordinates of the nodes, shape (node, 3).
        corners: Drawn places of nodes [m], shape (part, node, 3).
        slopes: Returns ∂N/∂ξ at natural coordinates of shape (place, 3), shape
            (place, node, 3).
    """
    is_quadratic = parts.shape == "quadratic hexahedron"
    shares, factor = _collapsed(9 if is_quadratic else 4)
    share = factors / factors.sum()
    middle = share @ usual
    spread = (share[:, None] * (usual - middle)).T @ (usual - middle)
    root = np.linalg.cholesky(spread)
    ends = np.einsum("pck,pkx->pcx", parts.pieces.inside.shares, _places(parts))
    gradients: list[Floats] = []
    volumes: list[Floats] = []
    for part in range(len(parts.cell)):
        own = ends[parts.pieces.part == part]
        size = np.abs(np.linalg.det(own[:, 1:] - own[:, :1]))
        xi = (shares @ own).reshape(-1, 3)
        steep = slopes(xi)
        sides = np.einsum("ax,qak->qxk", corners[part], steep)
        weight = np.outer(size, factor).ravel() * np.linalg.det(sides)
        volume = weight.sum()
        centre = weight @ xi / volume
        covariance = (weight[:, None] * (xi - centre)).T @ (xi - centre) / volume
        inner = np.linalg.solve(root, np.linalg.solve(root, covariance).T)
        turned = root @ np.real(sqrtm(inner)) @ np.linalg.inv(root)
        points = centre + (usual - middle) @ turned.T
        exact = np.einsum("q,qak,qkx->ax", weight, steep, np.linalg.inv(sides)) / volume
        found = _by_places(slopes(points), corners[part])
        if is_quadratic:
            whole = _by_places(slopes(usual), corners[part])
            kept = _fit(nodes, corners[part])
            found = whole + np.einsum("ab,qax->qbx", kept, found - whole)
        mean = np.einsum("q,qax->ax", share, found)
        gradients.append(exact + LESS.get(parts.shape, 1.0) * (found - mean))
        volumes.append(volume * share)
    return np.array(gradients), np.array(volumes)


def _by_places(steep: Floats, corners: Floats) -> Floats:
    """Return ∂N/∂X [1/m] of ∂N/∂ξ, shape (point, node, 3), of a cell with nodes at places."""
    return np.einsum(
        "qak,qkx->qax", steep, np.linalg.inv(np.einsum("ax,qak->qxk", corners, steep))
    )


def _fit(nodes: Floats, corners: Floats) -> Floats:
    """Return the fit at nodes of polynomials of degree 2 and of places, shape (node, node)."""
    x, y, z = nodes.T
    known = [np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x]
    away = (corners - corners.mean(axis=0)) / np.ptp(corners)
    basis, size, _ = np.linalg.svd(np.column_stack([*known, *away.T]), full_matrices=False)
    basis = basis[:, size > 1e-12 * size[0]]
    return basis @ basis.T


def _places(parts: Any) -> Floats:
    """Return natural coordinates of the corners of roots, shape (piece, 4, 3)."""
    return np.asarray(parts.division.corners[parts.pieces.roots])


def _collapsed(count: int) -> tuple[Floats, Floats]:
    """Return shares of the corners of a tetrahedron, shape (point, 4), and weights.

    The weights add up to 1/6, the volume over the determinant of the edges.
    """
    x, w = leggauss(count)
    x, w = 0.5 * (1.0 + x), 0.5 * w
    a, b, c = (each.ravel() for each in np.meshgrid(x, x, x, indexing="ij"))
    weight = np.einsum("i,j,k->ijk", w, w, w).ravel() * (1.0 - a) ** 2 * (1.0 - b)
    first, second = a, b * (1.0 - a)
    third = c * (1.0 - a) * (1.0 - b)
    return np.stack([1.0 - first - second - third, first, second, third], axis=1), weight
