"""Volumes of solid elements, and their first and second moments.

    V = ∫ dV,    s = ∫ x dV,    S = ∫ x ⊗ x dV

are integrals of polynomials of natural coordinates: x is that of the functions of nodes, and dV
is det ∂x/∂ξ dξ. The points of ``_RULES`` integrate them to rounding, whatever the corners, but
for tetrahedra and hexahedra with curved edges, whose polynomials have a higher degree (products
of Gauss's rules; P. J. Davis, P. Rabinowitz, Methods of Numerical Integration, 2nd edition,
1984).
"""

from typing import NamedTuple

import numpy as np

from tissuec.core.arrays import are_alike
from tissuec.geometry.elements import (
    CUBE_27,
    GAUSS,
    SHAPES,
    TETRAHEDRAL_POINTS,
    NodeFunctions,
    fourth_degree,
    prismatic,
    quadratic,
    trilinear,
)
from tissuec.model.network import Floats


class SolidMoments(NamedTuple):
    """Integrals over elements of a density of 1; each attribute has a row for each element.

    Attributes:
        volume: [m³], shape (element,).
        first: ∫ x [m⁴], shape (element, 3).
        second: ∫ x ⊗ x [m⁵], shape (element, 3, 3).
    """

    volume: Floats
    first: Floats
    second: Floats

    def total(self, density: Floats) -> "SolidMoments":
        """Return the sums of elements in kg, kg m and kg m², as those of a single one.

        Args:
            density: [kg/m³], shape (element,).
        """
        return SolidMoments(*(np.tensordot(density[None], each, 1) for each in self))

    def shifted(self, by: Floats) -> "SolidMoments":
        """Return the moments of elements moved by vectors [m], shape (element, 3)."""
        sides = self.first[:, :, None] * by[:, None, :]
        outer = self.volume[:, None, None] * by[:, :, None] * by[:, None, :]
        second = self.second + sides + sides.swapaxes(1, 2) + outer
        return SolidMoments(self.volume, self.first + self.volume[:, None] * by, second)


class _Rule(NamedTuple):
    """Functions of nodes at points, and weights in natural coordinates, shape (point,)."""

    at: NodeFunctions
    weights: Floats


def _rules() -> dict[str, _Rule]:
    places, weights = GAUSS
    cube, flat = SHAPES["quadratic hexahedron"], fourth_degree()
    columns = prismatic(np.tile(flat.points, (3, 1)), np.repeat(places, 6))
    return {
        "hexahedron": _Rule(trilinear(cube.lumped @ CUBE_27), cube.weights),
        "wedge": _Rule(columns, 0.5 * np.outer(weights, flat.weights).ravel()),
        "tetrahedron": _Rule(quadratic(TETRAHEDRAL_POINTS), SHAPES["tetrahedron"].weights),
        "quadratic hexahedron": _Rule(NodeFunctions(cube.lumped, cube.gradients), cube.weights),
    }


#: Points of each shape that integrate second moments exactly.
_RULES = _rules()


def moments(shape: str, corners: Floats) -> SolidMoments:
    """Return the moments of elements of one shape; the drawn ones of a lattice are found once.

    Args:
        shape: As in ``geometry.elements.SHAPES``.
        corners: Positions of their nodes [m], shape (element, node, 3).
    """
    first = corners[:, 0]
    own = corners - first[:, None]
    alike = are_alike(corners)
    found = _moments(_RULES[shape], own[:1] if alike else own)
    if alike:
        found = SolidMoments(*(np.repeat(each, len(own), axis=0) for each in found))
    return found.shifted(first)


def _moments(rule: _Rule, corners: Floats) -> SolidMoments:
    volume = np.linalg.det(np.einsum("eax,qak->eqxk", corners, rule.at.gradients))
    volume *= rule.weights
    places = np.einsum("qa,eax->eqx", rule.at.values, corners)
    weighted = volume[..., None] * places
    return SolidMoments(
        volume.sum(axis=1), weighted.sum(axis=1), weighted.swapaxes(1, 2) @ places
    )
