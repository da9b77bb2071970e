"""Topologies in the file: each *part* of the VTKHDF group is one set of cells."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.network import Indices
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.datasets import DatasetSpec
from tissuec.results.mesh import Cells
from tissuec.results.schema import CELL_TABLE, FRAMES, KINDS, LINES, ROOT
from tissuec.results.store import LARGE, ColumnTable, Store


class CellTables:
    """The cells of all parts of one PolyData group, written from the start or gone on with.

    Args:
        store: The file.
        datasets: Of the group.
        cells: About how many a part has.

    Attributes:
        first_cells: How many cells of each kind stand before the last part.
        first_ids: How many point numbers of each kind stand before the last part.
    """

    def __init__(self, store: Store, datasets: Mapping[str, DatasetSpec], cells: int):
        self._store = store
        names = ["NumberOfPoints", *(f"{kind}/{name}" for kind in KINDS for name in CELL_TABLE)]
        self._table = ColumnTable(
            store, {name: _sized(datasets[name], cells) for name in names}
        )
        self.first_cells: list[int] = []
        self.first_ids: list[int] = []

    @property
    def count(self) -> int:
        """Return how many parts there are, those that wait included."""
        return self._table["NumberOfPoints"].rows

    def add(self, points: int, *tables: NDArray[Any]) -> None:
        """Append a part.

        Args:
            points: Number of points.
            *tables: Point indices, without a unit, of the cells of one of `KINDS`, shape (cell,
                width).
        """
        rows: dict[str, ArrayLike] = {"NumberOfPoints": [points]}
        for kind, table in zip(KINDS, tables, strict=True):
            rows[f"{kind}/NumberOfCells"] = [len(table)]
            rows[f"{kind}/NumberOfConnectivityIds"] = [table.size]
            rows[f"{kind}/Offsets"] = np.arange(len(table) + 1) * table.shape[1]
            rows[f"{kind}/Connectivity"] = table.reshape(-1)
        self._table.append(rows)
        self.locate(*tables)

    def locate(self, *tables: NDArray[Any]) -> None:
        """Set the attributes to the start of the last part.

        Args:
            *tables: Point indices, without a unit, of the cells of this part, shape (cell,
                width).
        """
        self.first_cells, self.first_ids = [], []
        for kind, table in zip(KINDS, tables, strict=True):
            # Every part has one offset more than it has cells.
            offsets = self._table[f"{kind}/Offsets"].rows
            self.first_cells.append(offsets - self.count - len(table))
            self.first_ids.append(self._table[f"{kind}/Connectivity"].rows - table.size)


class Parts(CellTables):
    """The parts of the frames of a net.

    Attributes:
        drawn: The cells of the last one.
    """

    def __init__(
        self, store: Store, nodes: int, spring_ids: Indices, shown: NDArray[np.integer]
    ):
        super().__init__(store, FRAMES, len(shown))
        self._nodes = nodes
        self._ids = spring_ids
        spring_id, springs = FRAMES["CellData/spring_id"], LINES["spring"]
        self._spring_id = store.column(_sized(spring_id, len(shown)))
        self._springs = store.column(_sized(springs, len(shown)))
        self.drawn: Cells | None = None
        if self.count:
            self.drawn = read_cells(store.content, self.count - 1, shown)
            self.locate(*_tables(self.drawn))

    @property
    def first_identity(self) -> int:
        """Return where the ids of the last part begin."""
        assert self.drawn is not None
        return self._spring_id.rows - self.drawn.total

    def draw(self, cells: Cells) -> None:
        """Append a part that draws ``cells``."""
        self.add(self._nodes, *_tables(cells))
        identities = np.full(cells.total, -1, dtype=np.int64)
        identities[cells.line_rows] = self._ids[cells.springs]
        self._store.append({self._spring_id: identities, self._springs: cells.springs})
        self.drawn = cells


def _sized(dataset: DatasetSpec, cells: int) -> DatasetSpec:
    """Return a column with the rows that are allocated at once for so many cells."""
    return dataset.of(chunk=LARGE) if dataset.packed and cells >= LARGE else dataset


def read_cells(file: ResultGroup, part: int, springs: NDArray[np.integer]) -> Cells:
    """Return the cells that a part of a file draws.

    Args:
        file: The file.
        part: Number of the part.
        springs: Ascending numbers of the springs that are recorded, shape (spring,).
    """
    vertices, lines, triangles = (
        read_table(file, ROOT, kind, part, width)
        for kind, width in zip(KINDS, (1, 2, 3), strict=False)
    )
    first = int(access.array(file, f"{ROOT}/Lines/NumberOfCells")[:part].sum())
    springs_of_lines = access.dataset(file, LINES["spring"].path)
    drawn = springs_of_lines[first : first + len(lines)]
    if len(drawn) < len(lines) or not np.isin(drawn, springs).all():
        access.damaged(file.file, f'"{springs_of_lines.path}" names springs that there are not')
    return Cells(vertices, lines, triangles, drawn)


def read_table(file: ResultGroup, root: str, kind: str, part: int, width: int) -> NDArray[Any]:
    """Return the points of the cells of one kind in a part, indices of shape (cell, width).

    Args:
        file: The file; the result has no unit.
        root: Path of the PolyData group.
        kind: Kind of cells.
        part: Number of the part.
        width: Points of a cell.
    """
    path = f"{root}/{kind}/Connectivity"
    points = int(access.array(file, f"{root}/NumberOfPoints")[part])
    counts = access.array(file, f"{root}/{kind}/NumberOfConnectivityIds")[: part + 1]
    first = int(counts[:part].sum())
    cells = access.dataset(file, path)[first : first + int(counts[part])]
    if len(cells) < counts[part] or ((cells < 0) | (cells >= points)).any():
        access.damaged(file.file, f'"{path}" names points that there are not')
    return cells.reshape(-1, width)


def _tables(cells: Cells) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return the point numbers of the cells of each of `KINDS`."""
    return cells.vertices, cells.lines, cells.triangles, np.zeros((0, 3), dtype=np.int64)
