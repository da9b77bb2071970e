"""The base of generators of solids of hexahedra, and cells of round ones without poles.

The core of a round solid is a lattice whose sides bulge; layers lead from its surface to the
circle or sphere.
"""

from abc import abstractmethod
from collections.abc import Sequence
from itertools import combinations, product
from math import prod
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
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

    @property
    def shape_volume(self) -> float | None:
        """The volume of the shape that is filled [m³]; None where it is not computed."""
        return None

    @abstractmethod
    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""

    @abstractmethod
    def cells(self, *, swollen: bool) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, corners of hexahedra, and nodes of named parts.

        Shapes (node, 3) [m] and (cell, 8), in the order of VTK or its mirror image.

        Args:
            swollen: Whether nodes lie so far outwards that the cells have the sections, or the
                volume, of the round shape, and not on its surface.
        """

    @property
    def sheets(self) -> tuple[Indices, ...]:
        """Sheets of nodes that can be moved along straight lines; see ``Mesh``."""
        return ()

    @property
    def on_shape(self) -> Floats | None:
        """Places of nodes on the round shape [m], shape (node, 3); None if not needed."""
        return None

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        nodes, edges, faces = self.counts()
        return nodes, edges + 2 * faces

    def element_size(self) -> tuple[int, int]:
        """Return the numbers of nodes and edges."""
        return self.counts()[:2]

    def build_elements(self) -> Mesh:
        """Return the cells as hexahedra that are as large as the shape."""
        return replace(self._mesh(swollen=True), sheets=self.sheets, on_shape=self.on_shape)

    def _mesh(self, *, swollen: bool) -> Mesh:
        from tissuec.meshes.elements import mesh_of_cells

        position, cells, groups = self.cells(swollen=swollen)
        none = np.zeros((0, 4), dtype=np.int64)
        return mesh_of_cells(position, {"hexahedron": cells}, none, groups)

    def build(self) -> Mesh:
        """Return a net of springs with the volume of the cells."""
        from tissuec.geometry.elements import SHAPES

        mesh = self._mesh(swollen=False)
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


#: Half the width of the core, by the radius; how far it bulges towards a circle, and the size
#: of that circle: angles and lengths of cells are then most even.
CORE, BULGE, BALL = 0.45, 0.5, 1.25


class RoundCells(NamedTuple):
    """Cells of the unit circle or ball, or of its part where some coordinates are positive.

    Attributes:
        core: Number of cells of the core along each axis, shape (2,) or (3,).
        layers: Number of layers around the core.
        positive: Along which axes only the positive half is drawn.
    """

    core: Sequence[int]
    layers: int
    positive: Sequence[bool]

    @classmethod
    def of(cls, radii: Sequence[float], cell: float, positive: Sequence[bool]) -> "RoundCells":
        """Return cells of about one size.

        Args:
            radii: Half the width along each axis [m].
            cell: Usual edge of a cell [m].
            positive: Along which axes only the positive half is drawn.
        """
        halves = [max(round(radius / (2.0 * cell)), 1) for radius in radii]
        core = [n if half else 2 * n for n, half in zip(halves, positive, strict=True)]
        return cls(core, max(round(float(np.mean(halves))), 1), tuple(positive))

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges, and faces with four sides."""
        inner = [
            n + 1 - (1 if half else 2) for n, half in zip(self.core, self.positive, strict=True)
        ]
        nodes, edges, faces = (self._parts(k, [n + 1 for n in self.core]) for k in range(3))
        # Those of the surface of the core: all but what lies inside.
        on, along, across = (
            whole - self._parts(k, inner) for k, whole in enumerate((nodes, edges, faces))
        )
        sides = across if len(self.core) == 3 else 0
        return (
            nodes + self.layers * on,
            edges + self.layers * (on + along),
            faces + self.layers * (along + sides),
        )

    def _parts(self, extent: int, points: Sequence[int]) -> int:
        """Return the number of nodes (0), edges (1) or faces (2) of a lattice.

        Args:
            extent: Number of axes along which a part extends.
            points: Number of nodes along each axis.
        """
        axes = range(len(self.core))
        return sum(
            prod(self.core[j] if j in some else points[j] for j in axes)
            for some in combinations(axes, extent)
        )

    def build(self, *, swollen: bool) -> tuple[Floats, Indices, Indices]:
        """Return places in the unit circle or ball, cells, and the nodes of its surface.

        Shapes (node, axis), (cell, 2 ** axis) with corners in the order of
        ``itertools.product``, and (n,).

        Args:
            swollen: Whether cells are as large as the circle or ball; see ``Hexahedral.cells``.
        """
        lows = [0.0 if half else -1.0 for half in self.positive]
        lines = [np.linspace(low, 1.0, n + 1) for low, n in zip(lows, self.core, strict=True)]
        lattice = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        number = np.arange(prod(lattice.shape[:-1])).reshape(lattice.shape[:-1])
        faces = self._faces(number)
        on = np.unique(faces)
        inner, outward = _bulging(lattice.reshape(-1, len(self.core)))
        place, cells, below = [inner], [_corners(number)], number.ravel()
        for layer in range(1, self.layers + 1):
            share = layer / self.layers
            place.append((1.0 - share) * inner[on] + share * outward[on])
            above = np.full(number.size, -1)
            above[on] = number.size + (layer - 1) * len(on) + np.arange(len(on))
            cells.append(np.concatenate([below[faces], above[faces]], axis=1))
            below = above
        found, corners = np.concatenate(place), np.concatenate(cells)
        if swollen:
            found *= (self._size / _size_of_cells(found[corners])) ** (1.0 / len(self.core))
        return found, corners, below[on]

    @property
    def _size(self) -> float:
        """Return the area of the circle or the volume of the ball, or of its part."""
        whole = np.pi if len(self.core) == 2 else 4.0 / 3.0 * np.pi
        return whole / 2.0 ** sum(self.positive)

    def _faces(self, number: NDArray[np.int64]) -> Indices:
        """Return the faces of the core that layers begin at, shape (face, corner)."""
        sides = [
            np.take(number, side, axis=axis)
            for axis, half in enumerate(self.positive)
            for side in ((-1,) if half else (0, -1))
        ]
        return np.concatenate([_corners(side) for side in sides])


def _size_of_cells(corners: Floats) -> float:
    """Return the area or volume of cells, in the order of ``RoundCells.build``."""
    from tissuec.geometry.elements import SHAPES

    if corners.shape[-1] == 3:
        order = in_order_of_vtk(np.arange(8)[None])[0]
        return float(np.abs(SHAPES["hexahedron"].volumes(corners[:, order])).sum())
    one, other = corners[:, 3] - corners[:, 0], corners[:, 2] - corners[:, 1]
    return float(0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum())


def _corners(number: NDArray[np.int64]) -> Indices:
    """Return the corners of the cells of a lattice, shape (cell, 2 ** axis)."""
    found = [
        number[tuple(slice(k, n - 1 + k) for k, n in zip(corner, number.shape, strict=True))]
        for corner in product((0, 1), repeat=number.ndim)
    ]
    return np.stack([part.ravel() for part in found], axis=1)


def _bulging(lattice: Floats) -> tuple[Floats, Floats]:
    """Return the places of the core, and unit vectors outwards, shape (node, axis) each.

    Args:
        lattice: Points of the square or cube from -1 to 1, shape (node, axis).
    """
    depth = np.abs(lattice).max(axis=1)[:, None]
    surface = lattice / np.where(depth > 0.0, depth, 1.0)
    # Equal angles between the lines of a side.
    outward = np.tan(0.25 * np.pi * surface)
    outward /= np.where(depth > 0.0, np.linalg.norm(outward, axis=1)[:, None], 1.0)
    share = BULGE * depth
    return CORE * depth * ((1.0 - share) * surface + share * BALL * outward), outward
