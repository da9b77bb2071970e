"""Faces of skins on which pressure acts, as weighted triangles.

The volume under a face whose shape functions N_i are polynomials is

    V = ⅓ ∫ x · (∂x/∂ξ × ∂x/∂η) dξ dη = Σ w_T det(x_i, x_j, x_k) / 6

over triples T of its nodes: one of weight 1 for a triangle, four of weight ½ for a
quadrilateral (both ways to divide it), 20 for the six nodes of a side of a tetrahedron with ten
nodes, and 76 for the nine nodes of a side of a hexahedron with 27. A third of the force
p w_T (x_j - x_i) × (x_k - x_i)/2 of each triple acts on each of its nodes. On a closed surface,
that is p ∂V/∂x; on a face with straight sides, also at the end of a surface, it is the force
p ∫ N_i n dA of finite elements.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import combinations
from typing import cast

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.forces.enclosed.rims import Crossing, Rims, are_parallel, planes_at, rims_of
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.geometry.edges import TriangleIndex
from tissuec.geometry.elements import GAUSS
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import Floats, Indices, MirrorPlane, Network

_TRIANGLE = ((0, 1, 2),)
_QUAD = ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))


def _quadratic() -> dict[tuple[int, int, int], float]:
    """Return the weights of the triples of a triangle with nodes in the middle of its sides.

    The middles 3, 4 and 5 follow the corners 0, 1 and 2. Weights are the integrals
    2 Σ sign(ijk) ∫ N_i ∂N_j/∂ξ ∂N_k/∂η over the orders of a triple; turned triples have equal
    ones.
    """
    parts = {(0, 1, 2): 2 / 15}
    kinds = {
        (0, 1, 3): (1, 5), (0, 1, 4): (-1, 3), (0, 1, 5): (-1, 3), (0, 3, 4): (4, 15),
        (0, 3, 5): (8, 5), (0, 4, 5): (4, 15),
    }  # fmt: skip
    turn = {0: 1, 1: 2, 2: 0, 3: 4, 4: 5, 5: 3}
    for triple, (above, below) in kinds.items():
        for _ in range(3):
            parts[triple] = above / below
            triple = cast(tuple[int, int, int], tuple(turn[node] for node in triple))
    parts[3, 4, 5] = 16 / 15
    return parts


def _biquadratic() -> dict[tuple[int, int, int], float]:
    """Return the weights of the triples of a quadrilateral of nine nodes; see ``_quadratic``.

    Eight nodes lie around it, corners and middles in turn, and the last one is its middle.
    """
    line, weight = GAUSS
    shape = np.stack([0.5 * line * (line - 1.0), 1.0 - line**2, 0.5 * line * (line + 1.0)])
    slope = np.stack([line - 0.5, -2.0 * line, line + 0.5])
    around = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1], [1, 1]])
    i, j = around.T
    values, by_x, by_y = (
        np.einsum("ap,aq->apq", one[i], other[j])
        for one, other in ((shape, shape), (slope, shape), (shape, slope))
    )
    each = np.einsum("p,q,ipq,jpq,kpq->ijk", weight, weight, values, by_x, by_y)
    each = each - each.swapaxes(1, 2)
    whole = 2.0 * (each + np.moveaxis(each, 0, 2) + np.moveaxis(each, 2, 0))
    triples = combinations(range(9), 3)
    return {triple: float(whole[triple]) for triple in triples if abs(whole[triple]) > 1e-14}


_SIX, _NINE = _quadratic(), _biquadratic()
#: Triples and weights by the number of triangles of the skin that a face consists of.
FORMS: dict[int, tuple[Indices, Floats]] = {
    1: (np.array(_TRIANGLE), np.ones(1)),
    2: (np.array(_QUAD), np.full(4, 0.5)),
    4: (np.array(list(_SIX)), np.array(list(_SIX.values()))),
    8: (np.array(list(_NINE)), np.array(list(_NINE.values()))),
}
#: Where the nodes of a face are among the corners of its triangles, (triangle, corner), by the
#: number of these.
_NODES = {
    2: ((0, 0), (0, 1), (0, 2), (1, 2)),
    4: ((0, 0), (1, 1), (2, 2), (1, 0), (2, 1), (0, 2)),
    8: (*((k, 1) for k in range(8)), (0, 0)),
}


class WeightedTriangles(Struct, frozen=True, eq=False):
    """Triples of nodes with weights, face by face.

    Attributes:
        corners: Shape (triple, 3).
        weight: Shape (triple,).
        first: The triples of a face are first[face]:first[face + 1], shape (face + 1,).
    """

    corners: Indices
    weight: Floats
    first: Indices

    @property
    def count(self) -> int:
        """Return the number of faces."""
        return len(self.first) - 1

    @property
    def face(self) -> Indices:
        """Return the face of each triple, shape (triple,)."""
        return np.repeat(np.arange(self.count), np.diff(self.first))

    def some(self, faces: Indices) -> "WeightedTriangles":
        """Return some of the faces, by indices of shape (n,)."""
        counts = np.diff(self.first)[faces]
        rows = np.repeat(self.first[faces], counts) + counted_up(counts)
        first = np.append(0, np.cumsum(counts))
        return WeightedTriangles(self.corners[rows], self.weight[rows], first)

    def turned(self, turns: NDArray[np.bool_]) -> "WeightedTriangles":
        """Return the same with some faces reversed, shape (face,)."""
        corners = self.corners.copy()
        own = turns[self.face]
        corners[own] = corners[own][:, ::-1]
        return WeightedTriangles(corners, self.weight, self.first)


class PressedFaces(Struct, frozen=True, eq=False, dict=True):
    """Faces of the skin of a network.

    Attributes:
        corners: Nodes of their triangles of the skin, shape (triangle, 3).
        rows: Their numbers among all triangles of the skin, -1 of faces of cuts, shape
            (triangle,).
        face: The face that each of them belongs to, shape (triangle,).
        triples: Their weighted triangles.
        ends: Nodes of each spring of the network, shape (spring, 2).
        planes: Of symmetry, at which the faces end; no two are parallel.
        parts: The part of an element that each triangle bounds, an entity, -1 of triangles as
            drawn, shape (triangle,); None where all are.
    """

    corners: Indices
    rows: Indices
    face: Indices
    triples: WeightedTriangles
    ends: NDArray[np.integer]
    planes: tuple[MirrorPlane, ...] = ()
    parts: Indices | None = None

    def some(self, faces: Indices) -> "PressedFaces":
        """Return some of the faces, by ascending indices of shape (n,)."""
        own = np.flatnonzero(np.isin(self.face, faces))
        face = np.searchsorted(faces, self.face[own])
        triples = self.triples.some(faces)
        corners, rows = self.corners[own], self.rows[own]
        parts = None if self.parts is None else self.parts[own]
        return PressedFaces(corners, rows, face, triples, self.ends, self.planes, parts)

    def with_parts(self, lost: NDArray[np.bool_], parts: PartTriangles) -> "PressedFaces":
        """Return these faces after cuts; parts of them are pressed from the same side.

        Args:
            lost: Triangles of elements that are not there any more, shape (triangle,).
            parts: Triangles that bound the parts of elements.
        """
        left = self.some(np.setdiff1d(np.arange(self.triples.count), self.face[lost]))
        new = parts.on(self.rows)
        turns = self._turns[self.face[np.argsort(self.rows)]]
        turns = turns[np.searchsorted(np.sort(self.rows), new.skin)]
        corners = np.where(turns[:, None], new.corners[:, ::-1], new.corners)
        planes = tuple(_with_nodes(plane, parts.planes) for plane in self.planes)
        return replace(left, planes=planes)._followed_by(replace(new, corners=corners))

    def joined_with(self, parts: PartTriangles) -> "PressedFaces":
        """Return these faces and faces of cuts, which are pressed from outside of the parts."""
        return self._followed_by(replace(parts, corners=parts.corners[:, ::-1]))

    def _followed_by(self, new: PartTriangles) -> "PressedFaces":
        """Return these and triangles of parts behind them, each of which is a face."""
        count, triples = len(new.skin), self.triples
        former = np.full(len(self.rows), -1) if self.parts is None else self.parts
        return replace(
            self,
            corners=np.concatenate([self.corners, new.corners]),
            rows=np.append(self.rows, new.skin),
            face=np.append(self.face, triples.count + np.arange(count)),
            triples=WeightedTriangles(
                np.concatenate([triples.corners, new.corners]),
                np.append(triples.weight, np.ones(count)),
                np.append(triples.first, triples.first[-1] + 1 + np.arange(count)),
            ),
            parts=np.append(former, new.parts),
        )

    def turned(self, turns: NDArray[np.bool_]) -> "PressedFaces":
        """Return the same with some faces reversed, shape (face,)."""
        return replace(self, triples=self.triples.turned(turns))

    def torn(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the faces that are cut or torn, ascending.

        Args:
            alive: False for springs that were cut or broke, shape (spring,).
        """
        whole = self._supported.whole(alive)
        if self.parts is not None:
            whole = np.where(self.parts < 0, whole, alive[self.parts])
        return np.unique(self.face[~whole])

    @property
    def _turns(self) -> NDArray[np.bool_]:
        """Return which faces are pressed on the side that they face, shape (face,).

        Those of solids always are; of walls, whose faces are triangles, only some.
        """
        skin = np.zeros((self.triples.count, 3), dtype=np.int64)
        skin[self.face] = self.corners
        first = self.triples.corners[self.triples.first[:-1]]
        alike = [(np.roll(skin, k, axis=1) == first).all(axis=1) for k in range(3)]
        return ~np.any(alike, axis=0)

    @cached_property
    def rims(self) -> Rims:
        """Return the rims of the faces."""
        return rims_of(self.triples.corners, self.triples.weight, self.planes)

    @cached_property
    def crossing(self) -> Crossing:
        """Return the intersection of the planes of symmetry at which the faces end."""
        return Crossing.of(self.planes)

    @cached_property
    def _supported(self) -> SupportedTriangles:
        return SupportedTriangles(self.ends, self.corners)


def _with_nodes(plane: MirrorPlane, planes: Sequence[MirrorPlane]) -> MirrorPlane:
    """Return the one of some planes that coincides with a plane, but has other nodes."""
    (found,) = (
        each
        for each in planes
        if (each.normal == plane.normal).all() and (each.origin == plane.origin).all()
    )
    return found


def faces_of(network: Network, rows: Indices) -> PressedFaces:
    """Return the faces that triangles of the skin form.

    Triangles that divide one side of a solid element are one face if all of them are there;
    every other triangle is a face of its own.

    Args:
        rows: Numbers of the triangles among those of the skin, ascending, shape (n,).
    """
    corners = network.skin[rows].astype(np.int64)
    face, sides = np.arange(len(rows)), list(_sides(network, corners))
    for own, _ in sides:
        face[own] = own[:, :1]
    alone = np.flatnonzero(np.bincount(face, minlength=len(face)) == 1)
    order = np.argsort(face, kind="stable")
    names, face = np.unique(face[order], return_inverse=True)
    triples = np.empty(len(names), dtype=object)
    for own, nodes in ((alone[:, None], corners[alone]), *sides):
        form, weight = FORMS[own.shape[1]]
        places = np.searchsorted(names, own[:, 0]).tolist()
        for place, each in zip(places, nodes[:, form], strict=True):
            triples[place] = each, weight
    corners, rows = corners[order], rows[order]
    found = WeightedTriangles(
        np.concatenate([np.zeros((0, 3), dtype=np.int64), *(each for each, _ in triples)]),
        np.concatenate([np.zeros(0), *(weight for _, weight in triples)]),
        np.append(0, np.cumsum([len(weight) for _, weight in triples])).astype(np.int64),
    )
    planes = tuple(one for one in network.mirrored if planes_at(corners.ravel(), [one]).any())
    # Between parallel planes, no point closes the faces along all of them.
    own = () if are_parallel(planes) else planes
    return PressedFaces(corners, rows, face.reshape(-1), found, network.line_ends, own)


def _sides(network: Network, corners: Indices) -> Iterator[tuple[Indices, Indices]]:
    """Yield whole sides of solid elements that several triangles make up.

    Args:
        corners: Nodes of the triangles, shape (triangle, 3).

    Yields:
        Places of the triangles, shape (side, triangle), and nodes, shape (side, node).
    """
    index = TriangleIndex(corners)
    for field in network.of_kind("elements"):
        shape = field.shape
        at_surface = field.nodes[np.isin(field.nodes, corners).any(axis=1)]
        for side in range(int(shape.faces.max()) + 1):
            local = shape.triangles[shape.faces == side]
            if len(local) == 1:
                continue
            place = index.find(at_surface[:, local].reshape(-1, 3)).reshape(-1, len(local))
            found = (place >= 0).all(axis=1)
            nodes = [local[k, corner] for k, corner in _NODES[len(local)]]
            yield place[found], at_surface[np.ix_(found, nodes)]
