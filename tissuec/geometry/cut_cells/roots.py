"""Roots: simplices that divide a cell, such that neighbours divide their common face alike.

A quadrilateral face is divided from its corner with the smallest number. A cell is the union of
the cones from its own such corner to the triangles of faces without it: six tetrahedra in a
hexahedron, three in a wedge. (J. Dompierre, P. Labbé, M.-G. Vallet, R. Camarero, How to
subdivide pyramids, prisms, and hexahedra into tetrahedra, 8th International Meshing Roundtable,
1999.) A triangle of a wall is its own root, and its faces are its edges. Numbers are those of
drawn nodes, so that copies of a cell are divided alike.

Corners of a root are in ascending order of these numbers, and roots are equal parts of the
volume of a cell in natural coordinates.
"""

from itertools import combinations

import numpy as np
from msgspec import Struct

from tissuec.geometry.elements import CUBE, CUBE_27, MIDDLES
from tissuec.model.network import Floats, Indices

_QUADS = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_PRISM = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_SIMPLEX = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_TRIANGLE = ((1, 2), (2, 0), (0, 1))
_FLAT = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
_CORNERS = np.vstack([np.zeros(3), np.eye(3)])
MOST_ON_FACE = 9  # nodes


class CellDivision(Struct, frozen=True, eq=False):
    """How cells of a shape are divided.

    Attributes:
        shape: Name of it.
        corners: Natural coordinates of the corners, which are the first nodes, shape
            (corner, dimension).
        places: The same of all nodes, shape (node, dimension).
        volume: Content in natural coordinates, of triangles an area.
        count: Of roots in a cell.
        faces: Corners of each, padded by -1, shape (face, 4): in turn as seen from outside;
            those of a triangle are edges, with the triangle on their left.
        face_nodes: All nodes of each, padded by -1, shape (face, 9).
        edges: Their ends, in the order of the nodes in their middles, shape (edge, 2).
        face_of: The face that contains a set of corners, by the sum of 2 to the power of each
            of them; -1 if none does. As many as a root has in a face are in one face at most.
    """

    shape: str
    corners: Floats
    places: Floats
    volume: float
    count: int
    faces: Indices
    face_nodes: Indices
    edges: Indices
    face_of: Indices

    @classmethod
    def of(
        cls,
        shape: str,
        corners: Floats,
        volume: float,
        count: int,
        faces: tuple[tuple[int, ...], ...],
        middles: Floats | None = None,
    ) -> "CellDivision":
        """Return the division of a shape.

        Args:
            shape: Name of it.
            corners: Natural coordinates, dimensionless, shape (corner, dimension).
            volume: Content in natural coordinates.
            count: Of roots in a cell.
            faces: Corners of each, see above.
            middles: Natural coordinates of nodes behind the corners, the first of which are in
                the middles of edges, shape (node, dimension).
        """
        places = corners if middles is None else np.concatenate([corners, middles])
        nodes = np.full((len(faces), MOST_ON_FACE), -1)
        ends = np.full((len(faces), 4), -1)
        face_of = np.full(2 ** len(corners), -1)
        for k, face in enumerate(faces):
            ends[k, : len(face)] = face
            own = [*face]
            if middles is not None:
                a, b, c = corners[list(face[:3])]
                high = (middles - a) @ np.cross(b - a, c - a)
                own += (len(corners) + np.flatnonzero(np.abs(high) < 1e-12)).tolist()
            nodes[k, : len(own)] = own
            for size in range(corners.shape[1], len(face) + 1):
                for some in combinations(face, size):
                    face_of[sum(1 << corner for corner in some)] = k
        sides = {
            frozenset((a, b)) for f in faces for a, b in zip(f, f[1:] + f[:1], strict=True)
        }
        edges = np.array(sorted(sorted(side) for side in sides))
        if middles is not None:
            away = places - corners[edges].mean(axis=1)[:, None]
            edges = edges[np.argsort(np.abs(away).sum(axis=2).argmin(axis=1))]
        return cls(shape, corners, places, volume, count, ends, nodes, edges, face_of)

    @property
    def dimension(self) -> int:
        """Return 3 of solids and 2 of walls: how many corners a face of a root has."""
        return self.corners.shape[1]

    @property
    def whole_faces(self) -> Indices:
        """Return how many corners each face has, shape (face,)."""
        return (self.faces >= 0).sum(axis=1)


DIVISIONS = {
    each.shape: each
    for each in (
        CellDivision.of("hexahedron", CUBE, 8.0, 6, _QUADS),
        CellDivision.of("quadratic hexahedron", CUBE, 8.0, 6, _QUADS, CUBE_27[8:]),
        CellDivision.of(
            "wedge",
            np.vstack([np.column_stack([_FLAT, np.full(3, z)]) for z in (-1.0, 1.0)]),
            1.0, 3, _PRISM,
        ),
        CellDivision.of("triangle", _FLAT, 0.5, 1, _TRIANGLE),
        CellDivision.of(
            "tetrahedron", _CORNERS, 1 / 6, 1, _SIMPLEX, _CORNERS[MIDDLES].mean(axis=1)
        ),
    )
}  # fmt: skip


class CellRoots(Struct, frozen=True, eq=False):
    """The roots of cells of one shape.

    Attributes:
        corners: Of the cell, in ascending order of their numbers, shape
            (cell, root, corner).
        sign: 1 if a root is right-handed in natural coordinates, else -1, shape (cell, root).
    """

    corners: Indices
    sign: Indices

    @classmethod
    def of(cls, shape: str, numbers: Indices) -> "CellRoots":
        """Return the roots of cells.

        Args:
            shape: Of all of them.
            numbers: Of the drawn nodes of the cells, shape (cell, node).
        """
        division = DIVISIONS[shape]
        numbers = numbers[:, : len(division.corners)]
        if division.count == 1:
            cones = np.broadcast_to(
                np.arange(numbers.shape[1]), (len(numbers), 1, numbers.shape[1])
            )
        else:
            cones = _cones(division, numbers)
        own = np.take_along_axis(numbers[:, None], cones, axis=2)
        order = np.argsort(own, axis=2)
        return cls(np.take_along_axis(cones, order, axis=2), parity(order))


def _cones(division: CellDivision, numbers: Indices) -> Indices:
    """Return cones from the lowest corner of each cell, right-handed, (cell, root, 4)."""
    lowest = np.argmin(numbers, axis=1)
    bases: list[Indices] = []
    for size in (3, 4):
        faces = division.faces[division.whole_faces == size][:, :size]
        if len(faces):
            every = range(len(division.corners))
            others = np.stack([faces[(faces != apex).all(axis=1)] for apex in every])[lowest]
            bases.append(fans(others, numbers[:, None]))
    base = np.concatenate(bases, axis=1)
    apex = np.broadcast_to(lowest[:, None, None], (*base.shape[:2], 1))
    return np.concatenate([apex, base], axis=2)


def fans(rings: Indices, numbers: Indices) -> Indices:
    """Return triangles of polygons around the corner with the smallest number.

    Edges are returned unchanged.

    Args:
        rings: Corners in turn, shape (cell, polygon, corner).
        numbers: Of the corners of cells, shape (cell, 1, corner of the cell).

    Returns:
        Those of each cell, shape (cell, triangle, 3), which turn as the polygons.
    """
    size = int(rings.shape[2])
    if size == 2:
        return rings
    first = np.argmin(np.take_along_axis(numbers, rings, axis=2), axis=2)[..., None]
    turned = np.take_along_axis(rings, (first + np.arange(size)) % size, axis=2)
    return np.concatenate([turned[..., [0, k, k + 1]] for k in range(1, size - 1)], axis=1)


def parity(order: Indices) -> Indices:
    """Return 1 for even permutations and -1 for odd ones, shape (…).

    Args:
        order: Numbers from 0, each once, shape (…, number).
    """
    count = np.zeros(order.shape[:-1], dtype=np.int64)
    for i, j in combinations(range(order.shape[-1]), 2):
        count += order[..., i] > order[..., j]
    return 1 - 2 * (count & 1)
