"""Enclosed volumes: closed surfaces that keep their volume by pressure.

A cell of drawn volume V0 that encloses V and should enclose Vt stores

    E = ½ K (V - Vt)² / V0,

K being its bulk modulus. Its pressure is p = -dE/dV = K (Vt - V) / V0, and the force on a node
is p ∂V/∂x. Faces have four corners a, b, c, d, in turn as seen from outside; they are the ruled
surfaces between opposite sides, which is the mean of both ways to split them into triangles.
With s = a + b + c + d, p = c - a and q = d - b,

    V = Σ s · (p × q) / 24,    ∂V/∂s = p × q / 24,    ∂V/∂p = q × s / 24,    ∂V/∂q = s × p / 24.

Cells that share a face share its surface, so that nothing is lost between them. A triangle is a
face whose last two corners are one, for which V is a · (b × c) / 6.

A body of tetrahedra has one cell for each node: a quarter of each tetrahedron around it, as
medians divide it. It grows by a quarter of what all of these tetrahedra grow by, so that their
surface tells. Volumes of single tetrahedra are too many for the nodes that would keep them: the
body would lock (J. Bonet, A. J. Burton, Comm. Num. Meth. Eng. 14:437, 1998). Parallelograms in
its surface count as faces of four corners, so that pressure acts on these as traction does on a
solid (see ``matter.solid``): thirds of triangles would bulge it at one diagonal.
"""

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, cast

import numpy as np
from msgspec.structs import replace

from tissuec.core.arrays import counted_up, cross, cross_matrices
from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Span
from tissuec.forces.effects import Resisting
from tissuec.forces.enclosed.kept_volumes import KeptVolumes
from tissuec.forces.enclosed.rims import where_open
from tissuec.forces.enclosed.volume_kernel import CellTable, press
from tissuec.forces.fields import Items
from tissuec.forces.matrices import ForceDerivatives, assembled
from tissuec.geometry.edges import parallelograms
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.model.topology import springs_between

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix, csr_matrix

LARGE = 96  # unknowns that a volume acts on: its part of a sparse matrix would fill it


class Enclosure(KeptVolumes, frozen=True):
    """The enclosed volumes of one body; its items are cells.

    Attributes:
        corners: Nodes of the faces, cell by cell, shape (face, 4); a triangle names its last
            corner twice.
        first: Where each cell begins among them and, last, where all end, shape (cell + 1,).
        share: The part of the volume within its faces that belongs to a cell, and by which the
            cell grows.
    """

    corners: Indices
    first: Indices
    share: float = 1.0

    @classmethod
    def of(cls, network: Network, name: str, modulus: float, span: Span) -> "Enclosure":
        """Return the enclosed volumes of a body: its cells, or its surface if it has no cells.

        Args:
            name: Name of the body.
            modulus: Bulk modulus K [Pa].
            span: The sentence in the source.

        Raises:
            ValueError: It has neither, or a surface that is open or encloses nothing; or it is
                made of elements, which resist changes of volume by themselves.
        """
        part = next((b for b in network.bodies if b.name.lower() == name.lower()), None)
        if part is None:
            raise ValueError(f"{name} is not a body")
        if part.is_made_of_elements and not part.is_wall:
            raise ValueError(
                f"the elements of {part.name} already resist changes of volume by the "
                "Poisson's ratio of its tissue, which can be up to 0.4999"
            )
        share = 1.0 if part.tetrahedra is None else 0.25
        corners, first, walls, walled = _surfaces(network, part)
        drawn = share * _volumes(network.position, corners, first)
        return cls(walls, walled, part.name, drawn, modulus, (), span, corners, first, share)

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the volume of {self.name}", "volume", self, self.span)

    @property
    def owner(self) -> Indices:
        """Return the cell of each face, shape (face,)."""
        return np.repeat(np.arange(self.item_count), np.diff(self.first))

    def volumes(self, position: Floats) -> Floats:
        """Return the enclosed volumes [m³], shape (…, cell).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return self.share * _volumes(position, self.corners, self.first)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        pressure = self.pressures(time, position)
        return (0.5 * pressure * pressure * self.drawn / self.modulus).sum(axis=-1)

    def gradient(self, position: Floats) -> Floats:
        """Return ∂V/∂x of each cell by its corners [m²], shape (…, face, 4, 3)."""
        s, p, q = _spans(position, self.corners, self.first)
        by_s, by_p, by_q = cross(p, q), cross(q, s), cross(s, p)
        parts = (by_s - by_p, by_s - by_q, by_s + by_p, by_s + by_q)
        return np.stack(parts, axis=-2) * (self.share / 24.0)

    def resistance(self, position: Floats, number: Indices, size: int) -> "csr_matrix":
        """Return √(K/V0) ∂V/∂x of each cell [(N/m)^½], shape (3 size, cell).

        Args:
            position: Of all nodes [m], shape (node, 3).
            number: Of each node of the scene among those that may move, -1 for others.
            size: Number of nodes that may move.
        """
        from scipy.sparse import csr_matrix, diags

        rows = 3 * number[self.corners][..., None] + np.arange(3)
        cells = np.broadcast_to(self.owner[:, None, None], rows.shape)
        moves = rows >= 0
        entries = self.gradient(position)[moves], (rows[moves], cells[moves])
        ways = csr_matrix(entries, shape=(3 * size, self.item_count))
        return csr_matrix(ways @ diags(np.sqrt(self.modulus / self.drawn)))

    def bending(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> "csr_matrix":
        """Return the stiffness of pressure on surfaces that turn, -Σ p ∂²V/∂x∂x [N/m].

        With [c] d = c × d, the second derivatives of 24 V are [q] by p and s, [p] by s and q,
        and [s] by q and p, of opposite sign the other way round. Arguments and shape are those
        of ``matrix``.

        Args:
            time: Time [s].
            position: Of all nodes [m], shape (node, 3).
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
        """
        from scipy.sparse import csr_matrix

        s, p, q = (cross_matrices(part) for part in _spans(position, self.corners, self.first))
        turns = np.einsum("kij,kfxy->fixjy", _TURNS, np.stack([q, p, s]))
        pressure = self.share * self.pressures(time, position)
        values = -pressure[self.owner, None, None, None, None] * turns
        return csr_matrix(assembled(values, number[self.corners], size))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return Σ K/V0 ∂V/∂x ∂V/∂xᵀ, and ``bending`` if ``exact``; see ``Field``."""
        from scipy.sparse import coo_matrix, csr_matrix

        sparse, wide = self.split(time, position, number, size, exact=exact)
        ways = csr_matrix(wide)
        return coo_matrix(sparse + ways @ ways.T)

    def split(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "tuple[coo_matrix, Floats]":
        """Return ``matrix`` with large cells apart: each is a column of ``resistance``."""
        from scipy.sparse import coo_matrix, csc_matrix

        ways = csc_matrix(self.resistance(position, number, size))
        is_large = np.diff(ways.indptr) > LARGE
        total = ways[:, ~is_large] @ ways[:, ~is_large].T
        if exact:
            total = total + self.bending(time, position, number, size)
        return coo_matrix(total), ways[:, is_large].toarray()

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        return float((np.abs(self.pressures(time, position)) * self.drawn).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return self.modulus * float(np.abs(self.gradient(position)).max())

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the stiffness of volumes, Σ K/V0 ∂V/∂x ∂V/∂xᵀ [N/m]; see ``Field``."""
        sides, owner = self.gradient(position), self.owner
        modulus = self.modulus / self.drawn

        def resist(moved: Floats, to: Floats) -> None:
            swell = np.einsum("fkc,fkc->f", sides, moved[self.corners])
            pressure = modulus * np.bincount(owner, swell, self.item_count)
            np.add.at(to, self.corners, pressure[owner, None, None] * sides)

        return resist

    # --- for the engine ---------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return press

    def items(self, place: Indices) -> Items:
        """Return the nodes of the cells."""
        return Items(place[self.corners].ravel(), 4 * self.first)

    def only(self, items: Indices) -> "Enclosure":
        """Return some cells, with the walls of all."""
        counts = np.diff(self.first)[items]
        faces = np.repeat(self.first[items], counts) + counted_up(counts)
        first, drawn = np.append(0, np.cumsum(counts)), self.drawn[items]
        return replace(self, corners=self.corners[faces], first=first, drawn=drawn)

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> CellTable:
        """Return all that is within the faces of cells: what grows by more is kept by less."""
        return CellTable(
            acts=acts,
            corners=np.ascontiguousarray(place[self.corners]),
            first=self.first.astype(np.int64),
            drawn=self.drawn / self.share,
            modulus=np.full(self.item_count, self.share * self.modulus),
            share=self.share,
        )

    @property
    def derivatives(self) -> ForceDerivatives:
        """Return the derivatives, also by the bulk modulus and drawn volumes."""
        from tissuec.forces.enclosed.volume_derivatives_kernel import pull_volumes, push_volumes

        return ForceDerivatives(("modulus", "drawn"), pull_volumes, push_volumes)


def open_edges(corners: Indices) -> Indices:
    """Return the edges that do not belong to exactly two triangles in opposite directions.

    Args:
        corners: Nodes of the triangles, shape (triangle, 3).

    Returns:
        Node pairs, shape (edge, 2).
    """
    edges = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if not len(edges):
        return edges
    size = int(edges.max()) + 1
    there, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    found, count = np.unique(there, return_counts=True)
    single = np.isin(there, found[count == 1])
    return edges[~(single & np.isin(back, there))]


def _surface(network: Network, part: BodyPart) -> tuple[Indices, Indices, Indices, Indices]:
    """Return corners, ``first``, walls and their cell of the one cell inside a surface.

    Raises:
        ValueError: There is no surface, or it is open or encloses nothing.
    """
    triangles = network.skin_of(part)
    loose = open_edges(triangles)
    if not len(triangles):
        raise ValueError(f"{part.name} has no surface")
    if len(loose):
        raise ValueError(f"the surface of {part.name} is open: {where_open(network, loose)}")
    first = np.array([0, len(triangles)])
    drawn = _volumes(network.position, triangles[:, [0, 1, 2, 2]], first)[0]
    if drawn < 0.0:
        triangles = triangles[:, ::-1]
    if drawn == 0.0 or not np.isfinite(drawn):
        raise ValueError(f"the surface of {part.name} encloses nothing")
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    walls = np.unique(springs_between(network.springs.ends, edges)[0])
    if (marks := network.skin_marks_of(part)) is not None:
        walls = np.append(walls, marks[marks >= 0])
    return triangles[:, [0, 1, 2, 2]], first, walls, np.zeros_like(walls)


@kept_on_owner(8)
def _surfaces(network: Network, part: BodyPart) -> tuple[Indices, Indices, Indices, Indices]:
    """Return corners, ``first``, walls and their cells; kept, as checks also need them."""
    return _cells(network, part) or _patches(network, part) or _surface(network, part)


def _cells(
    network: Network, part: BodyPart
) -> tuple[Indices, Indices, Indices, Indices] | None:
    """Return corners, ``first``, walls and their cells of a body of cells, None without."""
    if part.cells is None:
        return None
    faces, inner = (nodes.astype(np.int64) + part.nodes.start for nodes in part.cells())
    count, sides = len(faces), faces.shape[1]
    # All cells are alike, so that what is one node in the first is one in each.
    corners = faces.reshape(count, -1)
    once = np.sort(np.unique(corners[0], return_index=True)[1])
    members = np.concatenate([corners[:, once], inner], axis=1)
    pairs = np.array(list(combinations(range(members.shape[1]), 2)), dtype=np.int64)
    walls, which = springs_between(network.springs.ends, members[:, pairs].reshape(-1, 2))
    return faces.reshape(-1, 4), sides * np.arange(count + 1), walls, which // len(pairs)


def _patches(
    network: Network, part: BodyPart
) -> tuple[Indices, Indices, Indices, Indices] | None:
    """Return corners, ``first``, walls and their cells of a body of tetrahedra, None without.

    There is a cell for each node that has tetrahedra.
    """
    if part.tetrahedra is None:
        return None
    nodes = part.tetrahedra.astype(np.int64) + part.nodes.start
    a, b, c, d = network.position[nodes].swapaxes(0, 1)
    turned = np.einsum("ij,ij->i", cross(b - a, c - a), d - a) < 0.0
    nodes[turned] = nodes[turned][:, [0, 2, 1, 3]]
    opposite = nodes[:, _OPPOSITE].reshape(-1, 3)
    _, where, count = np.unique(
        np.sort(opposite, axis=1), axis=0, return_index=True, return_counts=True
    )
    outside = opposite[where[count == 1]]
    quads, _ = parallelograms(network.position, outside)
    # A surface between a parallelogram and its triangles, which enclose nothing as drawn.
    between = np.concatenate([quads, quads[:, [0, 3, 1, 1]], quads[:, [1, 3, 2, 2]]])
    # Seen from its node, faces through it enclose nothing; they close the surface.
    faces = np.concatenate(
        [
            *(np.roll(outside, -k, axis=1)[:, _TRIANGLE] for k in range(3)),
            opposite[:, _TRIANGLE],
            *(between for _ in range(4)),
        ]
    )
    owner = np.concatenate(
        [outside.T.ravel(), nodes.ravel(), *(np.tile(corner, 3) for corner in quads.T)]
    )
    order = np.argsort(owner, kind="stable")
    _, first = np.unique(owner[order], return_index=True)
    pairs = nodes[:, list(combinations(range(4), 2))]  # (tetrahedron, 6, 2)
    size = network.position.shape[0]
    keys = np.sort(pairs, axis=2) @ np.array([size, 1])
    all_owners = np.repeat(nodes, 6, axis=1), np.tile(keys, (1, 4))
    walled, keys = np.unique(np.stack([each.ravel() for each in all_owners]), axis=1)
    walls, which = springs_between(
        network.springs.ends, np.stack(np.divmod(keys, size), axis=1)
    )
    cell = cast(Indices, np.searchsorted(owner[order][first], walled[which]))
    return faces[order], np.append(first, len(faces)), walls, cell


_TRIANGLE = [0, 1, 2, 2]  # as a face of four corners
#: Corners of the face opposite each corner of a tetrahedron, in turn as seen from outside.
_OPPOSITE = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


def _spans(position: Floats, corners: Indices, first: Indices) -> Sequence[Floats]:
    """Return s, p and q of faces, as seen from the first corner of their cell."""
    origin = np.repeat(corners[first[:-1], 0], np.diff(first))
    a, b, c, d = (position[..., corners[:, k], :] - position[..., origin, :] for k in range(4))
    return a + b + c + d, c - a, d - b


def _volumes(position: Floats, corners: Indices, first: Indices) -> Floats:
    s, p, q = _spans(position, corners, first)
    # In the order of faces in memory, so that a sum does not depend on how many there are.
    parts = np.ascontiguousarray(np.einsum("...k,...k->...", s, cross(p, q)) / 24.0)
    return np.add.reduceat(parts, first[:-1], axis=-1)


# How s, p and q depend on the four corners, and from it how [q], [p] and [s] enter between two.
_S, _P, _Q = np.array([[1, 1, 1, 1], [-1, 0, 1, 0], [0, -1, 0, 1]], dtype=float)
_TURNS = (
    np.stack(
        [np.outer(one, two) - np.outer(two, one) for one, two in ((_P, _S), (_S, _Q), (_Q, _P))]
    )
    / 24.0
)
