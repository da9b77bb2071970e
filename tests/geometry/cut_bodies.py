"""What tests of cut cells share: bodies, blades, and linear elasticity of their parts."""

from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import Delaunay

from tests.forces.test_elements import mesh
from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.cutting import cut
from tissuec.geometry.cut_cells.joining import free_faces, part_faces
from tissuec.geometry.cut_cells.parts import CellParts, PieceFaces
from tissuec.geometry.cut_cells.quadrature import (
    PartMoments,
    linear_functions,
    measures,
    part_centroids,
)
from tissuec.geometry.elements import MIDDLES
from tissuec.geometry.natural_coordinates import functions
from tissuec.model.topology import pieces

SHAPES = ("hexahedron", "quadratic hexahedron", "wedge", "tetrahedron")


class Body(NamedTuple):
    """A body of cells of one shape.

    Attributes:
        parts: Of its cells.
        drawn: Places of drawn nodes [m], shape (node, 3).
        position: Of present nodes [m], shape (node, 3).
        parent: The drawn node of each present one, shape (node,).
    """

    parts: CellParts
    drawn: np.ndarray
    position: np.ndarray
    parent: np.ndarray

    @classmethod
    def of(cls, shape, position, nodes):
        return cls(CellParts.whole(shape, nodes), position, position, np.arange(len(position)))

    @classmethod
    def cube(cls, shape, cells=4, displaced=0.0, seed=3):
        """Return a cube of 1 m."""
        position, nodes = mesh(shape, cells, displaced, seed)
        return cls.of(shape, position / 0.02, nodes)

    @classmethod
    def random(cls, cells=3, seed=0):
        """Return a cube of 1 m of irregular tetrahedra."""
        steps = np.linspace(0.0, 1.0, cells + 1)
        grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
        inner = ((grid > 0.0) & (grid < 1.0)).all(axis=1)
        shift = np.random.default_rng(seed).uniform(-0.25, 0.25, grid.shape) / cells
        grid = grid + shift * inner[:, None]
        found = Delaunay(grid).simplices.astype(np.int64)
        size = np.linalg.det(grid[found[:, 1:]] - grid[found[:, :1]])
        found = np.where((size < 0.0)[:, None], found[:, [1, 0, 2, 3]], found)
        found = found[np.abs(size) > 1e-9]
        edges, place = np.unique(
            np.sort(found[:, MIDDLES].reshape(-1, 2), axis=1), axis=0, return_inverse=True
        )
        position = np.concatenate([grid, grid[edges].mean(axis=1)])
        return cls.of(
            "tetrahedron", position, np.hstack([found, len(grid) + place.reshape(-1, 6)])
        )

    def cut(self, heights, active=None, near=None):
        """Return the body after a cut, and the cut."""
        found = cut([self.parts], heights, None if active is None else [active], near)
        position = np.concatenate([self.position, self.position[found.copied]])
        parent = np.concatenate([self.parent, self.parent[found.copied]])
        (parts,) = found.groups
        return Body(parts, self.drawn, position, parent), found

    @property
    def corners(self):
        return self.drawn[self.parts.drawn]

    @property
    def moments(self):
        return PartMoments.of(self.parts, self.corners)

    @property
    def centroids(self):
        return part_centroids(self.parts, self.corners)

    @property
    def measures(self):
        return measures(self.parts, self.corners)

    @property
    def joins(self):
        return part_faces([self.parts])

    @property
    def connected(self):
        """Return the connected piece of each part."""
        return pieces(len(self.parts), self.joins.parts)

    @property
    def inner(self):
        """Return which present nodes are not in the surface of the cube."""
        place = self.drawn[self.parent]
        return ((place > 1e-9) & (place < 1.0 - 1e-9)).all(axis=1)


BALL = np.array(list(product((0, 1), repeat=3)))


def outer_faces(body):
    """Return which faces of cells have no neighbour as drawn, shape (part, face)."""
    return free_faces([replace(body.parts, nodes=body.parts.drawn)])[0]


def in_cube(normal, offset):
    """Return the volume of a unit cube behind a plane, and the area of the plane in it.

    (Inclusion and exclusion over corners: D. L. Barrow, P. W. Smith, Amer. Math. Monthly
    86:291, 1979.) Components of the normal must not be near zero.
    """
    offset -= normal[normal < 0.0].sum()
    normal = np.abs(normal)
    left = np.maximum(offset - BALL @ normal, 0.0)
    sign = (-1.0) ** BALL.sum(axis=1)
    size = np.prod(normal)
    return (sign * left**3).sum() / size / 6.0, (sign * left**2).sum() / size / 2.0


def blades(count, seed=1, least=0.1):
    """Yield random planes through a unit cube, as normals and offsets."""
    random = np.random.default_rng(seed)
    found = 0
    while found < count:
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        if np.abs(normal).min() > least:
            found += 1
            yield normal, normal @ random.uniform(0.15, 0.85, 3)


def areas(triangles):
    """Return area vectors of triangles [m²], shape (triangle, 3)."""
    a, b, c = triangles.swapaxes(0, 1)
    return 0.5 * np.cross(b - a, c - a)


def skin(body):
    """Return triangles of the surface of all parts, their parts, faces and levels."""
    pieces_ = body.parts.with_roots(np.ones(len(body.parts), dtype=bool))
    faces = PieceFaces.of(body.parts.shape, pieces_)
    shares = pieces_.inside.shares[faces.piece[:, None], faces.corners]
    weights = body.parts.weights(pieces_[faces.piece], shares)
    part = pieces_.part[faces.piece]
    return weights @ body.corners[part], part, faces.face, faces.level


def stiffness(body, lame=1.5, shear=1.0):
    """Return matrices of linear elements, shape (part, node, 3, node, 3).

    Volumes are means, or linear in hexahedra with 27 nodes.
    """
    found = body.measures
    steep, weight = found.gradients, found.volume
    full = np.einsum("pq,pqax,pqbx->pab", weight, steep, steep, optimize=True)
    matrix = shear * np.einsum("pab,xy->paxby", full, np.eye(3))
    matrix += shear * np.einsum("pq,pqay,pqbx->paxby", weight, steep, steep, optimize=True)
    linear = linear_functions(body.parts.shape)
    swell = np.einsum("pq,qk,pqax->pkax", weight, linear, steep, optimize=True)
    firm = lame / weight.sum(axis=1)
    return matrix + np.einsum("p,pkax,pkby->paxby", firm, swell, swell, optimize=True)


def assembled(body, matrices):
    """Return the matrix of all nodes, shape (3 node, 3 node), as a sparse one."""
    from scipy.sparse import coo_matrix

    freedom = (3 * body.parts.nodes[:, :, None] + np.arange(3)).reshape(len(matrices), -1)
    width, size = freedom.shape[1], 3 * len(body.position)
    rows, columns = np.repeat(freedom, width, 1).ravel(), np.tile(freedom, (1, width)).ravel()
    return coo_matrix((matrices.ravel(), (rows, columns)), shape=(size, size)).tocsr()


def surface_loads(body, cut_triangles, stress, side):
    """Return forces on nodes of tractions on one side of a cut, by dense quadrature.

    Args:
        body: After the cut.
        cut_triangles: Of it.
        stress: On that side, shape (part, 3, 3).
        side: 0 in front, 1 behind.
    """
    line, weight = np.polynomial.legendre.leggauss(9)  # curved cells need a degree of 16
    r, w = 0.5 * (1.0 + line), 0.5 * weight
    a, b = np.meshgrid(r, r, indexing="ij")
    points = np.stack([(1.0 - a) * (1.0 - b), a, (1.0 - a) * b], axis=2).reshape(-1, 3)
    weights = (np.outer(w, w) * (1.0 - a)).ravel()
    parts = body.parts
    part = cut_triangles.parts[:, side]
    xi = cut_triangles.shares[:, side] @ parts.division.corners[cut_triangles.roots[:, side]]
    force = np.zeros((len(body.position), 3))
    ways = xi[:, 1:] - xi[:, :1]
    outward = -1.0 if side == 0 else 1.0
    for point, w_ in zip(points, weights, strict=True):
        at = functions(parts.shape, np.einsum("k,tkx->tx", point, xi))
        sides = np.einsum("tax,tak->txk", body.corners[part], at.gradients)
        along = np.einsum("txk,tik->tix", sides, ways)
        vector = outward * w_ * np.cross(along[:, 0], along[:, 1])
        load = np.einsum("txy,ty->tx", stress[part], vector)
        np.add.at(force, parts.nodes[part], at.values[..., None] * load[:, None])
    return force
