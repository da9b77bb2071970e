"""Mesh generators: a member is a ``Struct`` of parameters with its ``build``."""

from collections.abc import Mapping
from typing import Protocol, Self, runtime_checkable

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.fields import LocatedFile
from tissuec.core.registry import Family
from tissuec.core.structs import replace
from tissuec.meshes.between import BetweenNodes
from tissuec.model.network import Grid

_ALIKE = 1e-6  # relative difference of lengths that are equal, far from the origin as well


class FileOrigin(Struct, frozen=True):
    """The file that a mesh was read from, and the SHA-256 digest of its bytes."""

    file: LocatedFile
    digest: str


class ElementMesh(Struct, frozen=True, eq=False):
    """Finite elements of one shape.

    Attributes:
        shape: Its name, as in ``geometry.elements.SHAPES``, or ``meshes.elements.TRIANGLE``.
        nodes: In the order of that shape, shape (element, node).
    """

    shape: str
    nodes: NDArray[np.int64]


class Mesh(Struct, frozen=True, eq=False):
    """Drawn topology, before any tissue: where nodes are and which springs join them.

    Attributes:
        position: Node positions [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2), lower index first.
        skin: Closed or open surface as triangles, for viewers, shape (triangle, 3); may be
            empty.
        grid: Arrangement of the nodes in rows and columns, if any; smooth surfaces follow it.
        volume: Of a solid, the share of each node [m³], shape (node,); None for surfaces.
        tetrahedra: That divide a solid, shape (tetrahedron, 4); None where there are none.
        elements: Of a body made of finite elements, shape by shape; its springs are their
            edges.
        groups: Nodes of the parts that a file names, by name, ascending.
        element_groups: Which elements belong to parts of volume cells that a file names, by
            name, shape (element,); of all other groups, those do that have all of their nodes.
        shares: By what the spring constant and the viscosity that the tissue gives are
            multiplied, shape (spring,); None where each spring gets them as they are.
        shared_by_area: Whether ``shares`` follow the areas of triangles, and not the volumes of
            tetrahedra.
        sheets: Layers of nodes of a block of cells, shape (sheet, line), for each direction in
            which layers can be moved along straight lines.
        on_shape: Places of nodes on the round shape [m], shape (node, 3), if cells were
            enlarged to have its volume; otherwise None.
        origin: Where it was read from; None for what is generated.
        remarks: What its author should know about it.
        between: Of elements from a file, nodes that are no corners [m].
    """

    position: NDArray[np.float64]
    ends: NDArray[np.int32]
    skin: NDArray[np.int32]
    groups: Mapping[str, NDArray[np.int64]] = field(
        default_factory=dict[str, NDArray[np.int64]]
    )
    shares: NDArray[np.float64] | None = None
    shared_by_area: bool = False
    origin: FileOrigin | None = None
    remarks: tuple[str, ...] = ()
    grid: Grid | None = None
    volume: NDArray[np.float64] | None = None
    tetrahedra: NDArray[np.int64] | None = None
    elements: tuple[ElementMesh, ...] = ()
    element_groups: Mapping[str, NDArray[np.bool_]] = field(
        default_factory=dict[str, NDArray[np.bool_]]
    )
    sheets: tuple[NDArray[np.int64], ...] = ()
    on_shape: NDArray[np.float64] | None = None
    between: BetweenNodes = field(default_factory=BetweenNodes.none)

    @property
    def even_grid(self) -> Grid | None:
        """Return the rows and columns if all of their cells are alike; None if they differ."""
        if self.grid is None:
            return None
        rows, columns, closed = self.grid
        place = self.position.reshape(rows, columns, 3)
        if closed:
            place = np.concatenate([place, place[:, :1]], axis=1)
        along, down = np.diff(place, axis=1), np.diff(place, axis=0)
        across = place[1:, 1:] - place[:-1, :-1]
        lengths = [np.linalg.norm(sides, axis=2) for sides in (along, down, across)]
        is_even = all(np.ptp(one) <= _ALIKE * one.max() for one in lengths)
        return self.grid if is_even else None

    def with_ends(self, ends: NDArray[np.int32]) -> "Mesh":
        """Return this mesh with other springs, given by node pairs of shape (spring, 2)."""
        return replace(self, ends=ends)


class Generator(Protocol):
    """Interface of members of ``MESHES``; their fields are entries in the language."""

    def build(self) -> Mesh:
        """Return the mesh."""
        ...

    def size(self) -> tuple[int, int]:
        """Return upper bounds of (nodes, springs) without building, to refuse absurd counts."""
        ...


@runtime_checkable
class Celled(Protocol):
    """A generator of solid bodies that are divided into cells."""

    def cell_nodes(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return nodes of faces, shape (cell, face, 4), and inside, shape (cell, inner)."""
        ...


@runtime_checkable
class Elemental(Protocol):
    """A generator of solid bodies that finite elements can divide."""

    @property
    def is_solid(self) -> bool:
        """Return whether it encloses volume, so that matter in it consists of elements."""
        ...

    def element_size(self) -> tuple[int, int]:
        """Return upper bounds of (nodes, edges) of ``build_elements``, as ``size`` does."""
        ...

    def build_elements(self) -> Mesh:
        """Return the mesh with elements; its node pairs are their edges."""
        ...


@runtime_checkable
class Refinable(Protocol):
    """A generator whose cells can be halved."""

    def refined(self) -> Self:
        """Return the generator of the same shape with cells half as long."""
        ...


@runtime_checkable
class Threaded(Protocol):
    """A generator of a thread: a chain of springs, in the order of its nodes, without a skin.

    The chain leads from node to node, and back to the first one if it is a loop.
    """

    def is_loop(self) -> bool:
        """Return whether the thread is closed."""
        ...

    def thread_radius(self) -> float:
        """Return how thick it is when it touches others [m]."""
        ...


def is_wall(mesh: Generator | None) -> bool:
    """Return whether a body of elements is a wall of triangles.

    Args:
        mesh: Of the body; None if it is explicit.
    """
    if mesh is None or isinstance(mesh, Threaded):
        return False
    return not (isinstance(mesh, Elemental) and mesh.is_solid)


MESHES: Family[type[Generator]] = Family("tissuec.meshes.generators", "mesh")
