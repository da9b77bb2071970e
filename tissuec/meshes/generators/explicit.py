"""A net typed in as tables: node positions, and the node pair of each spring."""

from typing import Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.meshes.generators import MESHES, Mesh


class TableError(ValueError):
    """A row of a table is impossible.

    Attributes:
        table: Which table holds the row.
        row: The row at fault, counted from 0.
    """

    def __init__(self, table: Literal["nodes", "springs"], row: int, message: str):
        self.table = table
        self.row = row
        super().__init__(f"row {row + 1} of the table of {table} {message}")


@MESHES.member("explicit")
class ExplicitMesh(Struct, frozen=True, eq=False):
    """A net given by tables; nodes and springs have the order of their rows.

    It has no entries: ``table nodes of …`` and ``table springs of …`` fill it. Nodes may have
    no springs, and the net may have none at all. Two springs may join the same nodes. The net
    has no skin.

    Attributes:
        position: Node positions [m], shape (node, 3).
        ends: Node pair of each spring as row numbers from 0, shape (spring, 2).
    """

    position: NDArray[np.float64]
    ends: NDArray[np.integer]

    def __post_init__(self) -> None:
        _check_nodes(np.asarray(self.position))
        _check_springs(np.asarray(self.ends), len(self.position))

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        return len(self.position), len(self.ends)

    def build(self) -> Mesh:
        """Return copies of the tables, with the lower node of each spring first."""
        ends = np.sort(np.asarray(self.ends), axis=1).astype(np.int32)
        skin = np.empty((0, 3), dtype=np.int32)
        return Mesh(np.array(self.position, dtype=np.float64), ends.reshape(-1, 2), skin)


def _check_nodes(position: NDArray[np.float64]) -> None:
    if position.ndim != 2 or position.shape[1] != 3 or not len(position):
        raise ValueError(f'"position" must have the shape (node, 3), not {position.shape}')
    finite = np.isfinite(position).all(axis=1)
    if not finite.all():
        raise TableError("nodes", int(np.argmin(finite)), "has a coordinate that is not finite")


def _check_springs(ends: NDArray[np.integer], node_count: int) -> None:
    if ends.ndim != 2 or ends.shape[1] != 2:
        raise ValueError(f'"ends" must have the shape (spring, 2), not {ends.shape}')
    if not len(ends):
        return
    if not np.issubdtype(ends.dtype, np.integer):
        raise ValueError(f'"ends" must hold whole numbers, not {ends.dtype}')
    known = ((ends >= 0) & (ends < node_count)).all(axis=1)
    if not known.all():
        row = int(np.argmin(known))
        message = f"names a node outside 0 to {node_count - 1}: {ends[row, 0]}, {ends[row, 1]}"
        raise TableError("springs", row, message)
    itself = ends[:, 0] == ends[:, 1]
    if itself.any():
        raise TableError("springs", int(np.argmax(itself)), "joins a node to itself")
