"""Shapes of solid elements and rules of quadrature: nodes, points, faces and edges.

Nodes are numbered as in VTK; wedges are right-handed, so that nodes 3 to 5 are where the normal
of nodes 0 to 2 points. Of each shape, the reference element lies in natural coordinates; with
the natural gradients ∂N_a/∂ξ at its points, positions X_a of its nodes give

    Z = Σ_a X_a ∂N_a/∂ξ,    ∂N_a/∂X = ∂N_a/∂ξ Z⁻¹,    dV = det Z dξ.

(O. C. Zienkiewicz, R. L. Taylor, J. Z. Zhu, The Finite Element Method, 7th edition, 2013,
chapter 6; mass of tetrahedra with ten nodes: E. Hinton, T. Rock, O. C. Zienkiewicz, Earthquake
Eng. Struct. Dyn. 4:245, 1976.)
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.model.network import Floats, Indices


class ElementShape(Struct, frozen=True, eq=False):
    """A shape of elements.

    Attributes:
        name: As messages call it.
        gradients: ∂N_a/∂ξ at each point, dimensionless, shape (point, node, 3).
        weights: Of the points in natural coordinates, dimensionless, shape (point,).
        lumped: The part of a point's mass that each node has, shape (point, node).
        edges: Pairs of nodes, shape (edge, 2).
        triangles: That divide the faces, facing outwards, shape (triangle, 3).
        faces: The face that each of the triangles belongs to, shape (triangle,).
        local: Factor of the shear modulus, up to which the bulk modulus acts at each point and
            not on the volume of the element.
        bends: Whether points are strained by all nodes together; see ``geometry.bent_cells``.
    """

    name: str
    gradients: Floats
    weights: Floats
    lumped: Floats
    edges: Indices
    triangles: Indices
    faces: Indices
    local: float = 0.0
    bends: bool = False

    @property
    def nodes(self) -> int:
        """Return how many nodes an element has."""
        return self.gradients.shape[1]

    def sides(self, corners: Floats) -> Floats:
        """Return Z at each point [m], shape (…, element, point, 3, 3).

        Args:
            corners: Positions of the nodes of elements [m], shape (…, element, node, 3).
        """
        return np.einsum("...eax,qak->...eqxk", corners, self.gradients)

    def point_volumes(self, corners: Floats) -> Floats:
        """Return integration weights of points [m³], shape (…, element, point).

        They are negative where an element is inverted.

        Args:
            corners: Positions of the nodes of elements [m], shape (…, element, node, 3).
        """
        a, b, c = np.moveaxis(np.asarray(self.sides(corners)), -2, 0)
        across = (
            a[..., 0] * (b[..., 1] * c[..., 2] - b[..., 2] * c[..., 1])
            + a[..., 1] * (b[..., 2] * c[..., 0] - b[..., 0] * c[..., 2])
            + a[..., 2] * (b[..., 0] * c[..., 1] - b[..., 1] * c[..., 0])
        )
        return np.asarray(across * self.weights)

    def volumes(self, corners: Floats) -> Floats:
        """Return the volumes of elements [m³], shape (…, element); see ``point_volumes``."""
        return np.asarray(self.point_volumes(corners).sum(axis=-1))


class Measures(Struct, frozen=True, eq=False):
    """SolidElements of one shape as they are drawn.

    Attributes:
        gradients: ∂N_a/∂X at each point [1/m], shape (element, point, node, 3).
        volume: Integration weight of each point [m³], shape (element, point); negative where an
            element is inverted.
    """

    gradients: Floats
    volume: Floats

    @classmethod
    def of(cls, shape: ElementShape, corners: Floats) -> "Measures":
        """Return the measures of elements.

        Args:
            shape: Of all of them.
            corners: Positions of their nodes [m], shape (element, node, 3).
        """
        sides, volume = shape.sides(corners), shape.point_volumes(corners)
        with np.errstate(all="ignore"):
            inverse = np.linalg.inv(np.where(volume[..., None, None] == 0.0, np.nan, sides))
            gradients = np.einsum("qak,eqkx->eqax", shape.gradients, inverse)
        return cls(np.ascontiguousarray(gradients), volume)


#: Natural coordinates of the nodes of a hexahedron.
CUBE = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float,
)  # fmt: skip


def _hexahedron() -> ElementShape:
    sides, points = CUBE, CUBE / np.sqrt(3.0)
    factors = 0.5 * (1.0 + sides * points[:, None, :])
    gradients = np.stack(
        [0.5 * sides[:, k] * np.prod(np.delete(factors, k, axis=2), axis=2) for k in range(3)],
        axis=2,
    )
    quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    triangles = [[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]
    edges = [(a, b) for a, b in combinations(range(8), 2) if (sides[a] != sides[b]).sum() == 1]
    return ElementShape(
        "hexahedron", gradients, np.ones(8), np.prod(factors, axis=2), np.array(edges),
        np.array(triangles), np.repeat(np.arange(6), 2), bends=True,
    )  # fmt: skip


def _wedge() -> ElementShape:
    slopes = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    inner = np.array([[1.0, 1.0], [4.0, 1.0], [1.0, 4.0]]) / 6.0
    gradients: list[Floats] = []
    lumped: list[Floats] = []
    for height in (-1.0 / np.sqrt(3.0), 1.0 / np.sqrt(3.0)):
        for s, t in inner:
            flat = np.array([1.0 - s - t, s, t])
            ends = 0.5 * (1.0 - height), 0.5 * (1.0 + height)
            lumped.append(np.concatenate([flat * ends[0], flat * ends[1]]))
            halves = [
                np.column_stack([slopes * end, sign * 0.5 * flat])
                for end, sign in zip(ends, (-1.0, 1.0), strict=True)
            ]
            gradients.append(np.concatenate(halves))
    triangles = [
        [0, 2, 1], [3, 4, 5],
        [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5],
    ]  # fmt: skip
    edges = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5)]
    return ElementShape(
        "wedge", np.array(gradients), np.full(6, 1.0 / 6.0), np.array(lumped), np.array(edges),
        np.array(triangles), np.array([0, 1, 2, 2, 3, 3, 4, 4]),
    )  # fmt: skip


#: Pairs of corners of a tetrahedron between which its nodes 4 to 9 lie.
MIDDLES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
_OUTWARD = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))


def _tetrahedron() -> ElementShape:
    near, far = (5.0 + 3.0 * np.sqrt(5.0)) / 20.0, (5.0 - np.sqrt(5.0)) / 20.0
    slopes = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    gradients = np.empty((4, 10, 3))
    for q in range(4):
        part = np.full(4, far)
        part[q] = near
        gradients[q, :4] = (4.0 * part[:, None] - 1.0) * slopes
        a, b = MIDDLES.T
        gradients[q, 4:] = 4.0 * (part[b, None] * slopes[a] + part[a, None] * slopes[b])
    middle = {tuple(pair): 4 + k for k, pair in enumerate(np.sort(MIDDLES).tolist())}
    triangles: list[tuple[int, int, int]] = []
    edges: set[tuple[int, int]] = set()
    for face in _OUTWARD:
        ab, bc, ca = (
            middle[min(face[i], face[j]), max(face[i], face[j])]
            for i, j in ((0, 1), (1, 2), (2, 0))
        )
        a, b, c = face
        small = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles += small
        for one in small:
            edges |= {
                (min(p, q), max(p, q)) for p, q in zip(one, one[1:] + one[:1], strict=True)
            }
    lumped = np.tile([1.0 / 36.0] * 4 + [4.0 / 27.0] * 6, (4, 1))
    return ElementShape(
        "tetrahedron", gradients, np.full(4, 1.0 / 24.0), lumped, np.array(sorted(edges)),
        np.array(triangles), np.repeat(np.arange(4), 4), local=2.0,
    )  # fmt: skip


SHAPES = {shape.name: shape for shape in (_hexahedron(), _tetrahedron(), _wedge())}


class TriangleRule(NamedTuple):
    """Points of a triangle.

    Attributes:
        points: Shares of the corners, shape (point, 3).
        weights: Parts of the area, shape (point,).
    """

    points: Floats
    weights: Floats


def fourth_degree() -> TriangleRule:
    """Return six points that integrate polynomials up to the degree 4.

    (D. A. Dunavant, Int. J. Numer. Meth. Eng. 21:1129, 1985.) Their coordinates solve the
    equations of the moments; see ``tests``.
    """
    found = ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322))
    points = [np.roll([1.0 - 2.0 * a, a, a], k) for a, _ in found for k in range(3)]
    return TriangleRule(np.array(points), np.repeat([weight for _, weight in found], 3))


def even(count: int) -> TriangleRule:
    """Return the middles of equal triangles, ``count`` of them along a side.

    For an integrand that is discontinuous within, they are better than points of a high degree.
    """
    points: list[tuple[float, float, float]] = []
    for i in range(count):
        for j in range(count - i):
            for third in (1, 2) if i + j < count - 1 else (1,):
                a, b = (i + third / 3.0) / count, (j + third / 3.0) / count
                points.append((1.0 - a - b, a, b))
    return TriangleRule(np.array(points), np.full(len(points), 1.0 / len(points)))
