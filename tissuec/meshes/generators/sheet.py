"""A flat sheet: rows and columns of nodes in any plane, such as a patch of skin."""

from typing import Annotated, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.fields import OneOf, Position, Whole
from tissuec.core.structs import replace
from tissuec.meshes.generators import MESHES, Mesh
from tissuec.meshes.generators.joining import (
    Pairs,
    grid_pairs,
    grid_triangles,
    require_limits,
    springs,
)
from tissuec.model.network import Grid


@MESHES.member("sheet")
class Sheet(Struct, frozen=True, eq=False):
    """A parallelogram of ``columns`` times ``rows`` nodes, numbered row by row.

    It starts at ``corner``. Columns follow one another along the first edge, rows along the
    second. Its skin faces in the direction (first edge) x (second edge).

    Attributes:
        corner: The corner at which both edges begin.
        first_edge: Vector from the corner to the end of the first row.
        second_edge: Vector from the corner to the end of the first column.
        columns: Number of columns of nodes, counted along the first edge.
        rows: Number of rows of nodes, counted along the second edge.
        diagonals: Springs across the faces: none, one or both of each face.
        second_neighbours: Whether springs that span two cells resist bending.
    """

    corner: Position
    first_edge: Position
    second_edge: Position
    columns: Annotated[int, Whole(at_least=2)]
    rows: Annotated[int, Whole(at_least=2)]
    diagonals: Annotated[str, OneOf(("none", "one", "both"))] = "none"
    second_neighbours: Annotated[str, OneOf(("no", "yes"))] = "no"

    def __post_init__(self) -> None:
        require_limits(self)
        first, second = (
            np.asarray(edge, dtype=np.float64) for edge in (self.first_edge, self.second_edge)
        )
        for name, edge in (("first edge", first), ("second edge", second)):
            if not edge.any():
                raise ValueError(f'"{name}" must have a length')
        first, second = first / np.abs(first).max(), second / np.abs(second).max()
        # Below this angle rows would coincide to the precision of a position.
        if np.linalg.norm(np.cross(first, second)) < 1e-9:
            raise ValueError('"first edge" and "second edge" must not be parallel')

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        return replace(self, columns=2 * self.columns - 1, rows=2 * self.rows - 1)

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        columns, rows = self.columns, self.rows
        count = (columns - 1) * rows + columns * (rows - 1)
        count += ("none", "one", "both").index(self.diagonals) * (columns - 1) * (rows - 1)
        if self.second_neighbours == "yes":
            count += (columns - 2) * rows + columns * (rows - 2)
        return columns * rows, count

    def build(self) -> Mesh:
        """Return nodes, springs, and the surface as triangles."""
        shape = (self.rows, self.columns)
        pairs = [grid_pairs(shape, step) for step in self._steps()]
        ends = springs(self.rows * self.columns, *pairs)
        return Mesh(
            self._position(), ends, grid_triangles(shape), grid=Grid(*shape, closed=False)
        )

    def _steps(self) -> list[tuple[int, int]]:
        """Return how far springs reach, as (rows, columns)."""
        steps = [(0, 1), (1, 0)]
        steps += [(1, 1), (1, -1)][: ("none", "one", "both").index(self.diagonals)]
        if self.second_neighbours == "yes":
            steps += [(0, 2), (2, 0)]
        return steps

    def second_neighbours_of_surface(self) -> Pairs:
        """Return the pairs that bending springs join, two steps along rows or columns.

        The shape is (spring, 2).
        """
        steps = ([(0, 2)] if self.columns > 2 else []) + ([(2, 0)] if self.rows > 2 else [])
        pairs = [grid_pairs((self.rows, self.columns), step) for step in steps]
        return np.concatenate([np.zeros((0, 2), dtype=np.int64), *pairs])

    def _position(self) -> NDArray[np.float64]:
        corner = np.asarray(self.corner, dtype=np.float64)
        row = np.linspace(0.0, 1.0, self.columns)[:, None] * np.asarray(self.first_edge)
        column = np.linspace(0.0, 1.0, self.rows)[:, None] * np.asarray(self.second_edge)
        return (corner + column[:, None, :] + row).reshape(-1, 3)
