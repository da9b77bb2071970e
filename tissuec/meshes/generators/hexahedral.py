"""The base of generators of solids of hexahedra."""

from abc import abstractmethod

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.geometry.edges import Floats, Indices
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.joining import Pairs, springs


class Hexahedral(Struct, frozen=True, eq=False):
    """A generator that gives nodes and hexahedra.

    A net of springs has springs along the edges of the cells and the diagonals of their faces.
    """

    @property
    def is_solid(self) -> bool:
        """Return whether the mesh encloses volume: always."""
        return True

    @abstractmethod
    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""

    @abstractmethod
    def cells(self) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, corners of hexahedra, and nodes of named parts.

        Shapes (node, 3) [m] and (cell, 8), in the order of VTK or its mirror image.
        """

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        nodes, edges, faces = self.counts()
        return nodes, edges + 2 * faces

    def element_size(self) -> tuple[int, int]:
        """Return the numbers of nodes and edges."""
        return self.counts()[:2]

    def build_elements(self) -> Mesh:
        """Return the cells as hexahedra."""
        from tissuec.meshes.elements import mesh_of_cells

        position, cells, groups = self.cells()
        none = np.zeros((0, 4), dtype=np.int64)
        return mesh_of_cells(position, {"hexahedron": cells}, none, groups)

    def build(self) -> Mesh:
        """Return a net of springs with the volume of the cells."""
        from tissuec.geometry.elements import SHAPES

        mesh = self.build_elements()
        quads = SHAPES["hexahedron"].triangles.reshape(6, 2, 3)
        across = np.concatenate(
            [quads[:, 0, [0, 2]], np.stack([quads[:, 0, 1], quads[:, 1, 2]], 1)]
        )
        pairs = mesh.elements[0].nodes[:, across].reshape(-1, 2)
        ends = springs(len(mesh.position), mesh.ends.astype(np.int64), pairs)
        return replace(mesh, ends=ends, elements=())

    def second_neighbours_of_surface(self) -> Pairs:
        """Refuse bending springs, because a solid bends against the springs inside.

        Raises:
            ValueError: Always; the shape is never returned.
        """
        raise ValueError(
            "bending springs are for surfaces; in a solid, the springs inside resist bending"
        )


def in_order_of_vtk(cells: NDArray[np.int64]) -> Indices:
    """Return hexahedra with corners in the order of ``itertools.product``, shape (n, 8)."""
    return np.ascontiguousarray(cells[:, [0, 4, 6, 2, 1, 5, 7, 3]])
