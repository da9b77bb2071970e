"""Enclosed volumes: closed surfaces that keep their volume by pressure.

A cell of drawn volume V0 that encloses V and should enclose Vt stores

    E = ½ K (V - Vt)² / V0,

K being its bulk modulus. Its pressure is p = -dE/dV = K (Vt - V) / V0, and the force on a node
is p ∂V/∂x. Faces have four corners a, b, c, d, in turn as seen from outside; they are the ruled
surfaces between opposite sides, which is the mean of both ways to split them into triangles.
With s = a + b + c + d, p = c - a and q = d - b,

    V = Σ s · (p × q) / 24.

Cells that share a face share its surface, so that nothing is lost between them. A triangle is a
face whose last two corners are one, for which V is a · (b × c) / 6.
"""

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations

import numpy as np

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Vector
from tissuec.core.arrays import counted_up
from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.enclosed.kept_volumes import KeptVolumes
from tissuec.forces.enclosed.rims import where_open
from tissuec.forces.grouped_items import NO_POINTS, GroupedItems
from tissuec.geometry.edges import volume
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import BodyPart, Floats, Indices, Network


def _face(x: Sequence[Vector], p: Numbers) -> Sequence[Number]:
    """Return the volume under a face."""
    a, b, c, d = x
    return [autodiff.dot(a + b + c + d, autodiff.cross(c - a, d - b)) / 24.0]


def _cell(sums: Vector, seen: Vector, p: Numbers) -> Number:
    """Return the energy of a cell, whose target is V0 (1 + amount)."""
    more = sums[0] - p.drawn * (1.0 + p.amount)
    return 0.5 * p.modulus / p.drawn * more**2


class Enclosure(KeptVolumes, frozen=True):
    """The enclosed volumes of one body; its items are cells.

    Attributes:
        corners: Nodes of the faces, cell by cell, shape (face, 4); a triangle names its last
            corner twice.
        first: Where each cell begins among them and, last, where all end, shape (cell + 1,).
    """

    item_shares = staticmethod(_face)
    group_energy = staticmethod(_cell)
    learnt = ("modulus", "drawn")

    corners: Indices
    first: Indices

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
        corners, first, walls, walled = _surfaces(network, part)
        drawn = np.zeros(len(first) - 1)
        found = cls(walls, walled, part.name, drawn, modulus, (), span, corners, first)
        return replace(found, drawn=found.volumes(network.position))

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the volume of {self.name}", "volume", self, self.span)

    def volumes(self, position: Floats) -> Floats:
        """Return the enclosed volumes [m³], shape (…, cell)."""
        return self.sums(position)[0]

    @cached_property
    def grouped(self) -> GroupedItems:
        """Return the faces, each cell seen from one of its nodes."""
        seen = self.corners[self.first[:-1], 0]
        own = {"drawn": self.drawn, "modulus": self.modulus}
        return GroupedItems(self.corners, self.first, seen, NO_POINTS, {}, own)

    def only(self, items: Indices) -> "Enclosure":
        """Return some cells, with the walls of all."""
        counts = np.diff(self.first)[items]
        faces = np.repeat(self.first[items], counts) + counted_up(counts)
        first, drawn = np.append(0, np.cumsum(counts)), self.drawn[items]
        return replace(self, corners=self.corners[faces], first=first, drawn=drawn)


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
    drawn = volume(network.position, triangles)
    if drawn < 0.0:
        triangles = triangles[:, ::-1]
    if drawn == 0.0 or not np.isfinite(drawn):
        raise ValueError(f"the surface of {part.name} encloses nothing")
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    walls = np.unique(network.pairs.between(edges)[0])
    if (elements := network.skin_elements_of(part)) is not None:
        walls = np.append(walls, elements[elements >= 0])
    first = np.array([0, len(triangles)])
    return triangles[:, [0, 1, 2, 2]], first, walls, np.zeros_like(walls)


@kept_on_owner(8)
def _surfaces(network: Network, part: BodyPart) -> tuple[Indices, Indices, Indices, Indices]:
    """Return corners, ``first``, walls and their cells; kept, as checks also need them."""
    return _cells(network, part) or _surface(network, part)


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
    walls, which = network.pairs.between(members[:, pairs].reshape(-1, 2))
    return faces.reshape(-1, 4), sides * np.arange(count + 1), walls, which // len(pairs)
