"""A block of cells: a crystal with springs as bonds, or cubes with diagonals.

Sites lie on a fine grid of whole numbers, ``divisions`` to a cell, which makes "nearest",
"second" and "third neighbour" exact statements about squared distances on that grid.
"""

from itertools import product
from typing import Annotated, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.fields import Lengths, LengthsIfAny, OneOf, Points, PointsIfAny
from tissuec.core.structs import replace
from tissuec.meshes.generators import MESHES, Mesh
from tissuec.meshes.generators.joining import (
    Pairs,
    graded_line,
    require_fine_part,
    require_limits,
    springs,
)

Triple = tuple[int, int, int]


class Crystal(Struct, frozen=True):
    """Sites of a cell, and distances of their neighbours.

    Attributes:
        divisions: Steps of the fine grid in one cell edge.
        sites: Sites of one cell on the fine grid.
        shells: Squared distance of nearest, second and third neighbours, in fine steps.
        neighbours: How many of each an inner site has.
        braced: Whether nearest neighbours are joined across every other cell as well: the cells
            whose numbers along x, y and z, from 0 on, have an even sum.
    """

    divisions: int
    sites: tuple[Triple, ...]
    shells: Triple
    neighbours: Triple
    braced: bool = False

    @property
    def period(self) -> int:
        """Return after how many cells springs repeat."""
        return 2 if self.braced else 1


_FACE_CENTRED = ((0, 0, 0), (0, 2, 2), (2, 0, 2), (2, 2, 0))
CRYSTALS = {
    "sodium chloride": Crystal(1, ((0, 0, 0),), (1, 2, 3), (6, 12, 8)),
    "caesium chloride": Crystal(2, ((0, 0, 0), (1, 1, 1)), (3, 4, 8), (8, 6, 12)),
    "diamond": Crystal(
        4,
        _FACE_CENTRED + tuple((x + 1, y + 1, z + 1) for x, y, z in _FACE_CENTRED),
        (3, 8, 11),
        (4, 12, 12),
    ),
    "braced cubes": Crystal(1, ((0, 0, 0),), (1, 2, 3), (10, 12, 4), braced=True),
}
REACH = ("nearest neighbours", "second neighbours", "third neighbours")
MOST_FINE = 1_000_000  # fine cells along a side
LARGEST = 2**53  # cells along a side; up to here each whole number is a float of its own
_MARGIN = 3  # the longest component of a third neighbour, in fine steps


@MESHES.member("lattice")
class Lattice(Struct, frozen=True, eq=False):
    """A block of whole crystal cells, with nodes on all six faces and eight corners.

    ========================  =====================  =====================  ================
    kind                      nearest neighbours     second neighbours add  third ones add
    ========================  =====================  =====================  ================
    sodium chloride           cell edges             face diagonals         body diagonals
    caesium chloride          half body diagonals    cell edges             face diagonals
    diamond                   quarter diagonals,     half face diagonals    12 longer springs
                              four at each node
    braced cubes              cell edges, and the    face diagonals         the other body
                              body diagonals of                             diagonals
                              every other cell
    ========================  =====================  =====================  ================

    Braced cubes have ten springs at an inner node: six edges, and four diagonals towards the
    corners of a tetrahedron. Cells are braced like the black squares of a chessboard, beginning
    with the cell at the lowest corner of the box. (A. Nürnberger, A. Radetzky, R. Kruse, SPIE
    Medical Imaging 1998, figure 2 (b): cubes with diagonals and ten springs at an inner node.
    The paper does not say which diagonals; this choice treats the three axes equally.)

    With nearest neighbours only, all kinds are floppy: some deformations stretch no spring.
    With second neighbours they are stiff, except for caesium chloride in a bar of one cell by
    one.

    The surface cuts bonds. A node with fewer than two springs left (a corner of a caesium
    chloride block; an edge or a corner of a diamond block) is also joined to its second
    neighbours, so that no node hangs on a single spring.

    Nodes are numbered along z first, then along y, then along x.

    In a body of elements, cells can differ by direction: ``cell = (4, 4, 1) mm``. They can also
    be finer in a part: within the fine box, their edges are at most as long as the fine cell.
    Away from it, cells grow by factors of up to 1.5 until they have the usual length. Planes of
    nodes extend through the whole block, so cells beside the fine box are fine in one or two
    directions as well. With a fine box, the sides of the block can have any length. To refine a
    layer at a face, let the fine box be the layer, and the fine cell small across it only.

    Attributes:
        kind: The crystal: sodium chloride (cubic), caesium chloride (body-centred), diamond or
            braced cubes.
        cell: Edge of the cubic cell, or of those of elements along x, y and z; each side of the
            box is a whole number of cells.
        box: Two opposite corners of the block.
        reach: Reach of the springs: nearest, second or third neighbours.
        fine_cell: Largest edge of a cell in the fine box, or edges along x, y and z, for
            elements.
        fine_box: Two opposite corners of the part with finer cells.
    """

    kind: Annotated[str, OneOf(tuple(CRYSTALS))]
    cell: Lengths
    box: Points
    reach: Annotated[str, OneOf(REACH)] = "nearest neighbours"
    fine_cell: LengthsIfAny = None
    fine_box: PointsIfAny = None

    def __post_init__(self) -> None:
        require_limits(self)
        require_fine_part(self.fine_cell, self.fine_box, self.cell)
        self.cells()

    @property
    def corners(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the lowest and the highest corner of the box [m], each of shape (3,)."""
        one, other = (np.asarray(corner, dtype=np.float64) for corner in self.box)
        return np.minimum(one, other), np.maximum(one, other)

    @property
    def edges(self) -> NDArray[np.float64]:
        """Return the usual edges of a cell along x, y and z [m], shape (3,)."""
        return np.broadcast_to(np.asarray(self.cell, dtype=np.float64), 3)

    def cells(self) -> Triple:
        """Return the number of cells along x, y and z.

        Raises:
            ValueError: A side of the box is not a whole number of cells, or of more cells than
                can be counted.
        """
        if self.fine_cell is not None:
            x, y, z = (len(line) - 1 for line in self._graded_lines())
            return x, y, z
        low, high = self.corners
        with np.errstate(over="ignore"):
            length = high - low
            count = np.maximum(np.rint(length / self.edges), 1.0)
        if np.any(count > LARGEST):
            raise ValueError('"cell" is too small for the "box": it gives too many cells')
        # A billionth is far above rounding of sizes and far below any size someone means. The
        # second part is the rounding of coordinates far away from the origin.
        allowed = 1e-9 * length + 4.0 * np.spacing(np.maximum(np.abs(low), np.abs(high)))
        misfits = np.abs(length - count * self.edges) > allowed
        sides = zip("xyz", length.tolist(), self.edges.tolist(), misfits, strict=True)
        for axis, side, edge, misfit in sides:
            if misfit:
                raise ValueError(_misfit(axis, side, edge))
        return int(count[0]), int(count[1]), int(count[2])

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        fine = None if self.fine_cell is None else np.multiply(0.5, self.fine_cell)
        return replace(self, cell=np.multiply(0.5, self.cell), fine_cell=fine)

    def size(self) -> tuple[int, int]:
        """Return the number of nodes, and of springs as if no bond were cut at the surface."""
        crystal, cells = CRYSTALS[self.kind], self.cells()
        nodes = 0
        for site in crystal.sites:
            x, y, z = (n + (s == 0) for n, s in zip(cells, site, strict=True))
            nodes += x * y * z
        joined = nodes * sum(crystal.neighbours[: REACH.index(self.reach) + 1]) // 2
        on_edges = 4 * sum(cells) + 8
        return nodes, joined + on_edges * crystal.neighbours[1]

    def build(self) -> Mesh:
        """Return nodes, springs, and the surface with its normals pointing outwards.

        Raises:
            ValueError: There are finer cells, or cells that differ by direction, which springs
                cannot have.
        """
        if self.fine_cell is not None:
            raise ValueError('"fine cell" is for bodies made of elements')
        if np.ndim(self.cell):
            raise ValueError(
                'a "cell" that differs by direction is for bodies made of elements'
            )
        return self._mesh()

    def _mesh(self) -> Mesh:
        crystal, cells = CRYSTALS[self.kind], self.cells()
        number = _numbered(crystal, cells)
        place = np.flatnonzero(number.ravel() >= 0)
        shells = crystal.shells[: REACH.index(self.reach) + 1]
        pairs = _pairs(number, place, shells)
        if crystal.braced and self.reach != "third neighbours":
            pairs = np.concatenate((pairs, _braces(number, place)))
        if self.reach == "nearest neighbours":
            degree = np.bincount(pairs.ravel(), minlength=len(place))
            second = _pairs(number, place, crystal.shells[1:2])
            pairs = np.concatenate((pairs, second[(degree < 2)[second].any(axis=1)]))
        position = self._position(crystal, cells, np.unravel_index(place, number.shape))
        return Mesh(
            position,
            springs(len(place), pairs),
            _skin(crystal, number),
            volume=_volume(position, *self.corners),
        )

    def cell_nodes(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return the nodes of the cubic cells: on their faces, and inside.

        Faces have four corners each, or of diamond four triangles round the node in the middle.
        They face outwards; a triangle names its last node twice. Cells are numbered along z
        first, then y, then x.

        Returns:
            Nodes of the faces, shape (cell, face, 4), and inside, shape (cell, inner).
        """
        crystal, cells = CRYSTALS[self.kind], self.cells()
        number = _numbered(crystal, cells)[(slice(_MARGIN, -_MARGIN),) * 3]
        step = crystal.divisions

        def at(*site: int) -> NDArray[np.int32]:
            """Return the node of each cell at a place of the fine grid, -1 for none."""
            parts = (
                slice(s, s + step * (n - 1) + 1, step) for s, n in zip(site, cells, strict=True)
            )
            return number[tuple(parts)].ravel()

        faces: list[NDArray[np.int32]] = []
        for axis, high in product(range(3), (False, True)):
            turns = [(0, 0), (1, 0), (1, 1), (0, 1)]
            around = [
                at(*np.roll((high * step, u * step, v * step), axis).tolist())
                for u, v in (turns if high else turns[::-1])
            ]
            middle = at(*np.roll((high * step, step // 2, step // 2), axis).tolist())
            if step > 1 and middle[0] >= 0:
                triangles = [(around[k], around[(k + 1) % 4], middle, middle) for k in range(4)]
                faces += [np.stack(triangle, axis=1) for triangle in triangles]
            else:
                faces.append(np.stack(around, axis=1))
        inside = [at(*site) for site in crystal.sites if min(site) > 0]
        none = np.zeros((len(faces[0]), 0), dtype=np.int32)
        inner = np.stack(inside, axis=1) if inside else none
        return np.stack(faces, axis=1), inner

    @property
    def is_solid(self) -> bool:
        """Return whether it encloses volume: always."""
        return True

    def element_size(self) -> tuple[int, int]:
        """Return the number of corners of cells, and about that of their edges."""
        return self._cubes.size()

    def build_elements(self) -> Mesh:
        """Return the cubic cells as hexahedra, in the order of ``cell_nodes``."""
        from tissuec.meshes.elements import mesh_of_cells

        cubes, (x, y, z) = self._cubes._mesh(), self.cells()
        number = np.arange(len(cubes.position)).reshape(x + 1, y + 1, z + 1)
        around = [(0, 0), (1, 0), (1, 1), (0, 1)]
        corners = [
            number[i : i + x, j : j + y, k : k + z].ravel() for k in (0, 1) for i, j in around
        ]
        none = np.zeros((0, 4), dtype=np.int64)
        bricks = {"hexahedron": np.stack(corners, axis=1)}
        ways = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        sheets = [number.transpose(way).reshape(number.shape[way[0]], -1) for way in ways]
        mesh = mesh_of_cells(cubes.position, bricks, none, {})
        return replace(mesh, sheets=tuple(sheets))

    @property
    def _cubes(self) -> "Lattice":
        """Return the lattice whose nodes are the corners of the cells."""
        return replace(self, kind="sodium chloride", reach=REACH[0])

    def _graded_lines(self) -> list[NDArray[np.float64]]:
        """Return where planes of nodes are along x, y and z [m], with finer cells.

        Raises:
            ValueError: The fine box is outside of the box, or there are too many fine cells.
        """
        assert self.fine_box is not None and self.fine_cell is not None
        ends = np.stack(self.corners, axis=1)
        parts = np.sort(np.array(self.fine_box), axis=0).T
        fine = np.broadcast_to(self.fine_cell, 3)
        if np.any(np.ptp(np.clip(parts.T, *self.corners), axis=0) > MOST_FINE * fine):
            raise ValueError(
                '"fine cell" is too small for the "fine box": it gives too many cells'
            )
        found: list[NDArray[np.float64]] = []
        for own, part, usual, least in zip(ends, parts, self.edges, fine, strict=True):
            try:
                line = graded_line(tuple(own), tuple(part), usual, least)
            except ValueError:
                raise ValueError('"fine box" is outside of the "box"') from None
            found.append(line)
        return found

    def second_neighbours_of_surface(self) -> Pairs:
        """Refuse bending springs, because a solid bends against the springs inside.

        Raises:
            ValueError: Always.
        """
        raise ValueError(
            "a lattice is solid and resists bending by its inner springs; choose another "
            '"reach"'
        )

    def _position(
        self, crystal: Crystal, cells: Triple, index: tuple[NDArray[np.int64], ...]
    ) -> NDArray[np.float64]:
        if self.fine_cell is not None:
            lines = self._graded_lines()
        else:
            low, high = self.corners
            # Sampled between the corners: low + n * cell may miss the face by a rounding.
            lines = [
                np.linspace(float(low[axis]), float(high[axis]), n * crystal.divisions + 1)
                for axis, n in enumerate(cells)
            ]
        return np.stack(
            [line[i - _MARGIN] for line, i in zip(lines, index, strict=True)], axis=1
        )


def _misfit(axis: str, length: float, edge: float) -> str:
    def show(value: float) -> str:
        return units.show(value, units.LENGTH, digits=9)

    below = int(length / edge)
    fitting = [show(n * edge) for n in (below, below + 1) if n > 0]
    return (
        f'"box" is {show(length)} long in {axis}, which is not a whole number of cells '
        f'("cell" = {show(edge)}); {" or ".join(fitting)} would fit'
    )


def _numbered(crystal: Crystal, cells: Triple) -> NDArray[np.int32]:
    """Return the node number of each fine grid point, or -1, with a margin of -1 all round."""
    step = crystal.divisions
    fine = tuple(n * step + 1 + 2 * _MARGIN for n in cells)
    taken = np.zeros(fine, dtype=bool)
    for site in crystal.sites:
        taken[
            tuple(
                slice(_MARGIN + s, size - _MARGIN, step)
                for s, size in zip(site, fine, strict=True)
            )
        ] = True
    number = np.full(fine, -1, dtype=np.int32)
    number[taken] = np.arange(np.count_nonzero(taken), dtype=np.int32)
    return number


def _pairs(
    number: NDArray[np.int32], place: NDArray[np.int64], shells: tuple[int, ...]
) -> Pairs:
    """Return the pairs of nodes whose squared distance in fine steps is in ``shells``.

    Args:
        number: Node number of each fine grid point, from ``_numbered``.
        place: Flat index of each node in ``number``, shape (node,).
        shells: Squared distances.
    """
    flat, strides = number.ravel(), np.array(number.strides) // number.itemsize
    found: list[Pairs] = []
    for offset in product(range(-_MARGIN, _MARGIN + 1), repeat=3):
        # Of the two directions of a pair only the one towards the higher number is followed.
        # The margin keeps every step inside the array, so nothing has to be compared.
        if offset > (0, 0, 0) and sum(component**2 for component in offset) in shells:
            other = flat[place + int(strides @ offset)]
            first = np.flatnonzero(other >= 0)
            found.append(np.stack((first, other[first]), axis=1, dtype=np.int64))
    return np.concatenate(found)


def _braces(number: NDArray[np.int32], place: NDArray[np.int64]) -> Pairs:
    """Return the pairs of nodes across every other cell; arguments as ``_pairs``."""
    flat, strides = number.ravel(), np.array(number.strides) // number.itemsize
    site = np.stack(np.unravel_index(place, number.shape)) - _MARGIN
    found: list[Pairs] = []
    for offset in product((1,), (-1, 1), (-1, 1)):
        cell = site + np.minimum(offset, 0)[:, None]
        other = flat[place + int(strides @ offset)]
        first = np.flatnonzero((other >= 0) & (cell.sum(axis=0) % 2 == 0))
        found.append(np.stack((first, other[first]), axis=1, dtype=np.int64))
    return np.concatenate(found)


def _skin(crystal: Crystal, number: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the triangles of all six faces: two to a cell, or four round a centred node."""
    inner = number[(slice(_MARGIN, -_MARGIN),) * 3]
    step = crystal.divisions
    found: list[NDArray[np.int32]] = []
    for axis, outward in product(range(3), (False, True)):
        # The remaining axes in cyclic order, so that their cross product points along the axis.
        face = np.moveaxis(inner, (axis, (axis + 1) % 3, (axis + 2) % 3), (0, 1, 2))[-outward]
        grid = face[::step, ::step]
        around = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
        centre = face[step // 2 :: step, step // 2 :: step]
        if step > 1 and (centre >= 0).all():
            parts = [(around[k], around[(k + 1) % 4], centre) for k in range(4)]
        else:
            parts = [(around[0], around[1], around[2]), (around[0], around[2], around[3])]
        triangles = np.concatenate([np.stack(part, axis=-1).reshape(-1, 3) for part in parts])
        found.append(triangles if outward else triangles[:, ::-1])
    return np.concatenate(found).astype(np.int32)


def _volume(
    position: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the share of each site in the volume of a block of cells [m³], shape (node,).

    Sites in a face have half the share of those inside, in an edge a quarter, in a
    corner an eighth.
    """
    share = np.prod(np.where((position == low) | (position == high), 0.5, 1.0), axis=1)
    return np.asarray(share * (np.prod(high - low) / share.sum()))
