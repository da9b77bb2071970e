"""Points of parts of elements that blades have divided, by a quadrature of their moments.

A part is integrated over its tetrahedra by a product of Gauss's rules in collapsed coordinates
(A. H. Stroud, Approximate Calculation of Multiple Integrals, 1971, chapter 2.4). Its points are
those of a whole cell, moved and stretched so that their mean and their covariance are those of
the part; their mean of ∂N/∂X is made exact.
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
    parts: Any, usual: Floats, corners: Floats, slopes: Callable[[Floats], Floats]
) -> tuple[Floats, Floats]:
    """Return ∂N/∂X, shape (part, point, node, 3), and volumes of points [m³], (part, point).

    Args:
        parts: ``geometry.cut_cells.parts.CellParts`` that are not whole, read for their pieces.
        usual: Natural coordinates of the points of whole cells, shape (point, 3).
        corners: Drawn places of nodes [m], shape (part, node, 3).
        slopes: Returns ∂N/∂ξ at natural coordinates of shape (place, 3), shape
            (place, node, 3).
    """
    shares, factor = _collapsed(4)
    middle = usual.mean(axis=0)
    spread = (usual - middle).T @ (usual - middle) / len(usual)
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
        steep = slopes(points)
        sides = np.einsum("ax,qak->qxk", corners[part], steep)
        found = np.einsum("qak,qkx->qax", steep, np.linalg.inv(sides))
        gradients.append(exact + LESS.get(parts.shape, 1.0) * (found - found.mean(axis=0)))
        volumes.append(np.full(len(usual), volume / len(usual)))
    return np.array(gradients), np.array(volumes)


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
