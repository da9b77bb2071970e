"""Weights of glued faces by dual mortar functions, so that uniform stress passes exactly.

Faces of guests lie at faces of hosts, and need not match these. With the functions N_e of the
nodes of a face of guests and φ_j of hosts,

    W = D⁻¹ M,    D_e = ∫ N_e dA,    M_ej = ∫ ψ_e φ_j dA,    ∫ ψ_e N_k dA = D_e δ_ek,

so that jumps of displacement have no mean, and a uniform traction, whose forces are t D_e, is
Wᵀ t D = t ∫ φ_j dA on hosts. In each face, ψ = diag(D) (∫ N Nᵀ dA)⁻¹ N. (B. I. Wohlmuth, SIAM
J. Numer. Anal. 38:989, 2000.) Integrals are sums over the parts that triangles of faces have in
common with those of hosts, along the normal (M. A. Puso, Int. J. Numer. Meth. Eng. 59:315,
2004). Where W reproduces functions at nodes of guests, as where faces nest, it interpolates.

∫ N_e dA is 0 at corners of triangles with six nodes. There, functions of corners get a fifth of
those of the middles beside them, and displacements of middles change as required (A. Popp,
B. I. Wohlmuth, M. W. Gee, W. A. Wall, SIAM J. Sci. Comput. 34:B421, 2012).
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.hosts import ON, Hosts, candidates, placed
from tissuec.core.arrays import dot, norm
from tissuec.geometry.elements import MIDDLES, SHAPES, fourth_degree
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

COVERED = 0.5  # of the area of a face, that has to be in reach of hosts
FACING = 0.5  # cosine of the angle up to which faces of guests and hosts face each other
MOVED = 0.2  # of the functions of middles of edges, that corners get
NOTHING = 1e-10  # of the area of a triangle, for a part of it
TOGETHER = 256  # faces that memory has room for at once


class SideFaces(NamedTuple):
    """Faces of elements: all of them are the same face of one shape.

    Attributes:
        shape: Name of the shape; "triangle" for those of walls.
        elements: All nodes of the element of each face, shape (face, node).
        own: Those of the face, as places among the former, shape (n,).
        divided: Triangles that divide the face, as such places, shape (part, 3).
    """

    shape: str
    elements: Indices
    own: Indices
    divided: Indices

    @property
    def nodes(self) -> Indices:
        """Return the nodes of each face, shape (face, n)."""
        return self.elements[:, self.own]

    @property
    def triangles(self) -> Indices:
        """Return the nodes of the triangles of one face after the other, shape (…, 3)."""
        return self.elements[:, self.divided].reshape(-1, 3)

    def some(self, chosen: NDArray[np.bool_] | slice) -> "SideFaces":
        """Return some of the faces."""
        return self._replace(elements=self.elements[chosen])


def faces_of(hosts: Hosts) -> Iterator[SideFaces]:
    """Yield the faces of elements of a solid; triangles of walls are faces themselves."""
    if not hosts.is_solid:
        yield SideFaces("triangle", hosts.nodes, np.arange(3), np.arange(3)[None])
        return
    shape = SHAPES[hosts.shape]
    for face in range(int(shape.faces.max()) + 1):
        divided = shape.triangles[shape.faces == face]
        yield SideFaces(hosts.shape, hosts.nodes, np.unique(divided), divided)


def outer(every: Sequence[SideFaces]) -> list[SideFaces]:
    """Return the faces that one element alone has."""
    alone = are_outer(every)
    return [each.some(one) for each, one in zip(every, alone, strict=True) if one.any()]


def are_outer(every: Sequence[SideFaces]) -> list[NDArray[np.bool_]]:
    """Return which faces one element alone has, shape (face,) each."""
    most = max(len(each.own) for each in every)
    keys = [
        np.pad(np.sort(each.nodes), ((0, 0), (most - len(each.own), 0)), constant_values=-1)
        for each in every
    ]
    _, which, count = np.unique(
        np.concatenate(keys), axis=0, return_inverse=True, return_counts=True
    )
    ends = np.cumsum([len(each.elements) for each in every])[:-1]
    return np.split((count == 1)[which.ravel()], ends)


class CommonParts(NamedTuple):
    """Points of the parts that faces of guests and of hosts have in common.

    Attributes:
        guest, host: Faces at each point, shape (point,).
        place: Points on the triangles of guests [m], shape (point, 3).
        area: That each stands for [m²], shape (point,).
    """

    guest: Indices
    host: Indices
    place: Floats
    area: Floats

    def of(self, chosen: NDArray[np.bool_]) -> "CommonParts":
        """Return the points of some faces of guests, by a mask of shape (face,)."""
        return CommonParts(*(each[chosen[self.guest]] for each in self))


def mortar_weights(
    position: Floats, guests: Sequence[SideFaces], hosts: Sequence[SideFaces], reach: float
) -> "tuple[Indices, csr_matrix]":
    """Return the nodes of faces that hosts cover, and their weights, shape (node, node).

    Args:
        position: Of all nodes [m], shape (node, 3).
        guests, hosts: Faces of either side.
        reach: How far the sides may be from each other [m].
    """
    from scipy.sparse import csr_matrix, diags

    count = len(position)
    area, shape = np.zeros(count), (count, count)
    sums, mixing = csr_matrix(shape), [np.zeros((3, 0))]
    for every in guests:
        for start in range(0, len(every.elements), TOGETHER):
            own = every.some(slice(start, start + TOGETHER))
            takes, parts = covered_parts(position, own, hosts, reach)
            even, entries = _integrals(position, own, hosts, parts)
            np.add.at(area, own.nodes, even)
            sums = sums + csr_matrix(entries, shape=shape)
            rows, columns = np.broadcast_arrays(
                own.nodes[takes][:, :, None], own.nodes[takes][:, None, :]
            )
            mixed = np.broadcast_to(_mixing(own).T, rows.shape)
            mixing.append(np.stack([rows, columns, mixed])[:, mixed != 0.0])
    # Faces at an edge say the same.
    (rows, columns), mixed = np.split(np.unique(np.hstack(mixing), axis=1), [2])
    at = rows.astype(np.int64), columns.astype(np.int64)
    back = csr_matrix((mixed.ravel(), at), shape=shape)
    on = area > 0.0
    return np.flatnonzero(on), csr_matrix(back @ diags(1.0 / np.where(on, area, 1.0)) @ sums)


def covered_parts(
    position: Floats, own: SideFaces, hosts: Sequence[SideFaces], reach: float
) -> tuple[NDArray[np.bool_], list[CommonParts]]:
    """Return which faces hosts cover, shape (face,), and what these have in common with each.

    Args:
        position: Of all nodes [m], shape (node, 3).
        own: Faces of guests.
        reach: How far the sides may be from each other [m].
    """
    parts = [_parts(position, own, other, reach) for other in hosts]
    covered = sum(np.bincount(each.guest, each.area, len(own.nodes)) for each in parts)
    takes = covered >= COVERED * face_areas(position, own)
    return takes, [each.of(takes) for each in parts]


def face_areas(position: Floats, faces: SideFaces) -> Floats:
    """Return the areas of faces [m²], shape (face,); arguments as of ``covered_parts``."""
    return _areas(position[faces.triangles]).reshape(-1, len(faces.divided)).sum(axis=1)


def weights_at(position: Floats, own: SideFaces, part: CommonParts) -> tuple[Floats, Floats]:
    """Return the functions of nodes of faces of guests at points, and where they then are.

    Returns:
        Dimensionless, shape (point, n), and on the faces [m], shape (point, 3).
    """
    around = own.elements[part.guest]
    n = placed(own.shape, part.place, position[around])[0][:, own.own]
    n = n / n.sum(axis=1, keepdims=True)
    return n, np.einsum("pa,pak->pk", n, position[own.nodes[part.guest]])


def _integrals(
    position: Floats, own: SideFaces, hosts: Sequence[SideFaces], parts: Sequence[CommonParts]
) -> tuple[Floats, tuple[Floats, tuple[Indices, Indices]]]:
    """Return ∫ N_e dA of each face [m²], shape (face, n), and the numbers of M [m²].

    These are given with their rows and columns, as sparse matrices are made of.
    """
    nodes, mixed = own.nodes, _mixing(own)
    even, square = np.zeros(nodes.shape), np.zeros((*nodes.shape, nodes.shape[1]))
    found: list[tuple[Floats, Floats]] = []
    for part in parts:
        n, place = weights_at(position, own, part)
        n = n @ mixed.T
        np.add.at(even, part.guest, part.area[:, None] * n)
        both = n[:, :, None] * n[:, None, :]
        np.add.at(square, part.guest, part.area[:, None, None] * both)
        found.append((n, place))
    square[~even.any(axis=1)] = np.eye(nodes.shape[1])
    dual = even[:, :, None] * np.linalg.inv(square)
    values, rows, columns = [np.zeros(0)], [nodes[:0].ravel()], [nodes[:0].ravel()]
    for other, part, (n, place) in zip(hosts, parts, found, strict=True):
        psi = part.area[:, None] * np.einsum("pab,pb->pa", dual[part.guest], n)
        beside = other.elements[part.host]
        phi, _ = placed(other.shape, place, position[beside])
        entries = psi[:, :, None] * phi[:, None, :]
        values.append(entries.ravel())
        rows.append(np.broadcast_to(nodes[part.guest][:, :, None], entries.shape).ravel())
        columns.append(np.broadcast_to(beside[:, None, :], entries.shape).ravel())
    return even, (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))


def _mixing(own: SideFaces) -> Floats:
    """Return functions of nodes with positive integrals, as sums of N, shape (n, n)."""
    mixed = np.eye(len(own.own))
    if own.shape == "tetrahedron":
        number = {int(node): k for k, node in enumerate(own.own)}
        for node, ends in enumerate(MIDDLES.tolist(), start=4):
            if node in number:
                mixed[number[node], number[node]] -= 2.0 * MOVED
                mixed[[number[end] for end in ends], number[node]] = MOVED
    return mixed


def _areas(corners: Floats) -> Floats:
    """Return the areas of triangles [m²], shape (triangle,)."""
    return 0.5 * norm(_across(corners))


def _across(corners: Floats) -> Floats:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _parts(position: Floats, own: SideFaces, other: SideFaces, reach: float) -> CommonParts:
    """Return the parts that faces have in common, seen along the normals of guests."""
    here, there = position[own.triangles], position[other.triangles]
    size = float(norm(here - here.mean(axis=1, keepdims=True)).max())
    guest, host = candidates(here.mean(axis=1), there, reach + size)
    here, there = here[guest], there[host]
    normal, facing = _across(here), _across(there)
    turned = dot(normal, facing)
    turned = np.abs(turned) if other.shape == "triangle" else -turned
    kept = turned > FACING * norm(normal) * norm(facing)
    guest, host, here, there, normal = (x[kept] for x in (guest, host, here, there, normal))
    first = here[:, 1] - here[:, 0]
    first, normal = (each / norm(each)[:, None] for each in (first, normal))
    axes = np.stack([first, np.cross(normal, first), normal], axis=1)
    corner = here[:, 0]
    here, there = (
        np.einsum("pxk,pak->pax", axes, each - corner[:, None]) for each in (here, there)
    )
    for k in range(3):
        there = _left_of(there, here[:, k, :2], here[:, (k + 1) % 3, :2])
    fan = np.stack(
        [np.broadcast_to(there[:, :1], there[:, 2:].shape), there[:, 1:-1], there[:, 2:]],
        axis=2,
    )
    first, *others = np.moveaxis(fan, 2, 0)
    size = 0.5 * np.abs(_turning(others[0] - first, others[1] - first))
    near = np.abs(fan[..., 2].mean(axis=2)) <= reach * (1.0 + ON)
    pair, part = np.nonzero(near & (size > NOTHING * _areas(here)[:, None]))
    rule = fourth_degree()
    flat = np.einsum("qa,pax->pqx", rule.points, fan[pair, part, :, :2])
    place = corner[pair][:, None] + np.einsum("pqx,pxk->pqk", flat, axes[pair, :2])
    each = np.repeat(pair, len(rule.weights))
    area = size[pair, part, None] * rule.weights
    return CommonParts(
        guest[each] // len(own.divided), host[each] // len(other.divided),
        place.reshape(-1, 3), area.ravel(),
    )  # fmt: skip


def _turning(one: Floats, other: Floats) -> Floats:
    """Return x1 y2 - y1 x2 of vectors, shape (…)."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def _left_of(polygons: Floats, start: Floats, end: Floats) -> Floats:
    """Return the parts of convex polygons to the left of lines, with some corners repeated.

    Each side gives its first corner, if that is to the left, and its point on the line. What
    is left out repeats the corner before. (I. E. Sutherland, G. W. Hodgman, Commun. ACM 17:32,
    1974.)

    Args:
        polygons: Corners, of which the first two coordinates count [m], shape (p, n, 3).
        start, end: Points of each line [m], shape (p, 2).

    Returns:
        Shape (p, 2 n, 3); all corners are the same where nothing is to the left.
    """
    count = polygons.shape[1]
    side = _turning((end - start)[:, None], polygons[..., :2] - start[:, None])
    inside, after = side >= 0.0, np.roll(polygons, -1, axis=1)
    beyond = np.roll(side, -1, axis=1)
    crosses = inside != (beyond >= 0.0)
    way = np.where(crosses, side / np.where(crosses, side - beyond, 1.0), 0.0)
    points = np.stack([polygons, polygons + way[..., None] * (after - polygons)], axis=2)
    kept = np.stack([inside, crosses], axis=2).reshape(len(polygons), 2 * count)
    points = points.reshape(len(polygons), 2 * count, 3)
    last = np.maximum.accumulate(np.where(kept, np.arange(kept.shape[1]), -1), axis=1)
    last = np.where(last < 0, last[:, -1:], last)
    return (
        np.take_along_axis(points, np.maximum(last, 0)[..., None], axis=1)
        * kept.any(axis=1)[:, None, None]
    )
