"""Shapes of solid elements and rules of quadrature: nodes, points, faces and edges.

Nodes are numbered as in VTK; wedges are right-handed, so that nodes 3 to 5 are where the normal
of nodes 0 to 2 points. Of each shape, the reference element lies in natural coordinates; with
the natural gradients ∂N_a/∂ξ at its points, positions X_a of its nodes give

    Z = Σ_a X_a ∂N_a/∂ξ,    ∂N_a/∂X = ∂N_a/∂ξ Z⁻¹,    dV = det Z dξ.

(O. C. Zienkiewicz, R. L. Taylor, J. Z. Zhu, The Finite Element Method, 7th edition, 2013,
chapter 6; mass of tetrahedra with ten nodes: E. Hinton, T. Rock, O. C. Zienkiewicz, Earthquake
Eng. Struct. Dyn. 4:245, 1976. Row sums of hexahedra with 27 nodes are those of Simpson's rule,
which is exact for them: in a box, corners, edges, faces and the centre have 1, 4, 16 and 64 of
216 parts.)
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
        functions: Of the place, on which the volume of an element is projected; the first is
            constant, three more are linear.
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
    functions: int = 1

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

    def mean_strain(self, corners: Floats, drawn: Floats) -> Floats:
        """Return mean Green-Lagrange strains, dimensionless, shape (…, element, 3, 3).

        Points count by their drawn volume.

        Args:
            corners: Positions of the nodes of elements [m], shape (…, element, node, 3).
            drawn: The same before the deformation, shape (element, node, 3).
        """
        measures = Measures.of(self, drawn)
        strain = np.einsum("...eax,eqay->...eqxy", corners, measures.gradients)
        strain = 0.5 * (strain.swapaxes(-1, -2) @ strain - np.eye(3))
        weight = measures.volume / measures.volume.sum(axis=1, keepdims=True)
        return np.einsum("...eqxy,eq->...exy", strain, weight)

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


class NodeFunctions(NamedTuple):
    """The functions of nodes at points of an element.

    Attributes:
        values: N_a, dimensionless, shape (point, node).
        gradients: ∂N_a/∂ξ, dimensionless, shape (point, node, 3).
    """

    values: Floats
    gradients: Floats


def trilinear(points: Floats) -> NodeFunctions:
    """Return the functions of hexahedra, dimensionless.

    Args:
        points: Natural coordinates from -1 to 1, shape (point, 3).
    """
    factors = 0.5 * (1.0 + CUBE * points[:, None, :])
    gradients = np.stack(
        [0.5 * CUBE[:, k] * np.prod(np.delete(factors, k, axis=2), axis=2) for k in range(3)],
        axis=2,
    )
    return NodeFunctions(np.prod(factors, axis=2), gradients)


def prismatic(flat: Floats, heights: Floats) -> NodeFunctions:
    """Return the functions of wedges, dimensionless.

    Args:
        flat: Shares of the corners of the triangle, shape (point, 3).
        heights: From -1 to 1, shape (point,).
    """
    slopes = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    values: list[Floats] = []
    gradients: list[Floats] = []
    for sign in (-1.0, 1.0):
        end = 0.5 * (1.0 + sign * heights)[:, None]
        values.append(end * flat)
        across = np.broadcast_to(slopes, (len(flat), 3, 2)) * end[:, :, None]
        gradients.append(np.concatenate([across, sign * 0.5 * flat[:, :, None]], axis=2))
    return NodeFunctions(np.concatenate(values, axis=1), np.concatenate(gradients, axis=1))


def _hexahedron() -> ElementShape:
    at = trilinear(CUBE / np.sqrt(3.0))
    quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    triangles = [[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]
    edges = [(a, b) for a, b in combinations(range(8), 2) if (CUBE[a] != CUBE[b]).sum() == 1]
    return ElementShape(
        "hexahedron", at.gradients, np.ones(8), at.values, np.array(edges), np.array(triangles),
        np.repeat(np.arange(6), 2), bends=True,
    )  # fmt: skip


#: Gauss's three points between -1 and 1, and their weights.
GAUSS = np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0]), np.array([5.0, 8.0, 5.0]) / 9.0
#: Numbers of the nodes of a hexahedron with 27 nodes, by their places along ξ, η and ζ:
#: corners, middles of edges and of faces, and the centre. The order is VTK's.
TRIQUADRATIC = np.array(
    [[[0, 16, 4], [11, 20, 15], [3, 19, 7]],
     [[8, 22, 12], [24, 26, 25], [10, 23, 14]],
     [[1, 17, 5], [9, 21, 13], [2, 18, 6]]]
)  # fmt: skip
#: Along each axis, the places 0, 1 or 2 of these nodes, and their natural coordinates.
GRID = np.stack(np.unravel_index(np.argsort(TRIQUADRATIC, axis=None), (3, 3, 3)), axis=1)
CUBE_27 = GRID - 1.0


def triquadratic(places: Floats) -> NodeFunctions:
    """Return the functions of hexahedra with 27 nodes, dimensionless.

    Args:
        places: In natural coordinates, shape (place, 3).
    """
    x = places[..., None]
    values = np.concatenate([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], axis=2)
    slopes = np.concatenate([x - 0.5, -2.0 * x, x + 0.5], axis=2)
    along, steep = ([one[:, k, GRID[:, k]] for k in range(3)] for one in (values, slopes))
    gradients = [np.prod([*along[:k], steep[k], *along[k + 1 :]], axis=0) for k in range(3)]
    return NodeFunctions(np.prod(along, axis=0), np.stack(gradients, axis=2))


def _quadratic_hexahedron() -> ElementShape:
    line, weight = GAUSS
    points: Floats = line[np.stack(np.unravel_index(np.arange(27), (3, 3, 3)), axis=1)]
    weights = np.einsum("i,j,k->ijk", weight, weight, weight).ravel()
    lumped, gradients = triquadratic(points)
    grid, edges = TRIQUADRATIC, list[tuple[int, int]]()
    for axis in range(3):
        rows = np.moveaxis(grid, axis, -1).reshape(-1, 3)
        edges += [(int(row[k]), int(row[k + 1])) for row in rows for k in (0, 1)]
    # Faces as those of hexahedra, with ξ, η and ζ in a cyclic order, in triangles round their
    # middles, so that mirror images have the same triangles.
    triangles: list[list[int]] = []
    for axis, end in ((2, 0), (2, 2), (1, 0), (0, 2), (1, 2), (0, 0)):
        face = np.moveaxis(grid, (axis, (axis + 1) % 3, (axis + 2) % 3), (0, 1, 2))[end]
        face = face if end else face.T
        ring = [*face[:2, 0], *face[2, :2], *face[:0:-1, 2], *face[0, :0:-1]]
        triangles += [[int(face[1, 1]), int(ring[k]), int(ring[(k + 1) % 8])] for k in range(8)]
    return ElementShape(
        "quadratic hexahedron", gradients, weights, lumped, np.array(edges),
        np.array(triangles), np.repeat(np.arange(6), 8), functions=4,
    )  # fmt: skip


def _wedge() -> ElementShape:
    inner = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
    heights = np.repeat([-1.0, 1.0], 3) / np.sqrt(3.0)
    at = prismatic(np.tile(inner, (2, 1)), heights)
    triangles = [
        [0, 2, 1], [3, 4, 5],
        [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5],
    ]  # fmt: skip
    edges = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5)]
    return ElementShape(
        "wedge", at.gradients, np.full(6, 1.0 / 6.0), at.values, np.array(edges),
        np.array(triangles), np.array([0, 1, 2, 2, 3, 3, 4, 4]), bends=True,
    )  # fmt: skip


#: Pairs of corners of a tetrahedron between which its nodes 4 to 9 lie.
MIDDLES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
_OUTWARD = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))


#: Shares of the corners at the points of tetrahedra, shape (point, 4).
_NEAR, _FAR = (5.0 + 3.0 * np.sqrt(5.0)) / 20.0, (5.0 - np.sqrt(5.0)) / 20.0
TETRAHEDRAL_POINTS = _FAR + (_NEAR - _FAR) * np.eye(4)


def quadratic(points: Floats) -> NodeFunctions:
    """Return the functions of tetrahedra with ten nodes, dimensionless.

    Args:
        points: Shares λ of the corners, shape (point, 4).
    """
    slopes = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    a, b = MIDDLES.T
    corners = (4.0 * points - 1.0)[..., None] * slopes
    middles = 4.0 * (points[:, b, None] * slopes[a] + points[:, a, None] * slopes[b])
    values = [points * (2.0 * points - 1.0), 4.0 * points[:, a] * points[:, b]]
    return NodeFunctions(
        np.concatenate(values, axis=1), np.concatenate([corners, middles], axis=1)
    )


def _tetrahedron() -> ElementShape:
    at = quadratic(TETRAHEDRAL_POINTS)
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
        "tetrahedron", at.gradients, np.full(4, 1.0 / 24.0), lumped, np.array(sorted(edges)),
        np.array(triangles), np.repeat(np.arange(4), 4), local=2.0,
    )  # fmt: skip


SHAPES = {
    shape.name: shape
    for shape in (_hexahedron(), _quadratic_hexahedron(), _tetrahedron(), _wedge())
}


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
