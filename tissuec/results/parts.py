"""Topologies in the file: each *part* of the VTKHDF group is one set of cells."""

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.network import Indices
from tissuec.results import access
from tissuec.results.mesh import Cells
from tissuec.results.store import Column, Store

KINDS = ("Vertices", "Lines", "Polygons", "Strips")
SPRINGS = "/tissuec/lines/spring"  # network number of every line, all parts one after another
_TEXTS = {
    "NumberOfCells": "cells of each part",
    "NumberOfConnectivityIds": "point numbers of each part",
    "Offsets": "where each cell begins in Connectivity; one entry more than cells",
    "Connectivity": "points of the cells",
}


class Parts:
    """The parts of a file, written from the start or gone on with.

    Attributes:
        count: How many there are, those that wait included.
        drawn: The cells of the last one.
        first_cells: How many cells of each kind stand before the last one.
        first_ids: How many point numbers of each kind stand before the last one.
    """

    def __init__(self, store: Store, nodes: int, spring_ids: Indices):
        self._store = store
        self._nodes = nodes
        self._ids = spring_ids
        column = store.column
        self._points = column("/VTKHDF/NumberOfPoints", "i8", "points of each part")
        self._cells = {
            kind: {
                name: column(f"/VTKHDF/{kind}/{name}", "i8", f"{text} ({kind})")
                for name, text in _TEXTS.items()
            }
            for kind in KINDS
        }
        self._spring_id = column(
            "/VTKHDF/CellData/spring_id", "i8", "id of each line's spring; -1 at other cells"
        )
        self._springs = column(SPRINGS, "i8", "network number of each line's spring")
        self.drawn: Cells | None = None
        if self.count:
            self.drawn = read_cells(store.file, self.count - 1)
            self._locate_last()

    @property
    def count(self) -> int:
        return self._points.rows

    @property
    def first_identity(self) -> int:
        """Return where the ids of the last part begin."""
        assert self.drawn is not None
        return self._spring_id.rows - self.drawn.total

    def add(self, cells: Cells) -> None:
        """Append a part that draws ``cells``."""
        rows: dict[Column, ArrayLike] = {self._points: [self._nodes]}
        for columns, table in zip(self._cells.values(), _tables(cells), strict=True):
            rows[columns["NumberOfCells"]] = [len(table)]
            rows[columns["NumberOfConnectivityIds"]] = [table.size]
            rows[columns["Offsets"]] = np.arange(len(table) + 1) * table.shape[1]
            rows[columns["Connectivity"]] = table.reshape(-1)
        identities = np.full(cells.total, -1, dtype=np.int64)
        identities[cells.line_rows] = self._ids[cells.springs]
        rows[self._spring_id] = identities
        rows[self._springs] = cells.springs
        self._store.append(rows)
        self.drawn = cells
        self._locate_last()

    def _locate_last(self) -> None:
        assert self.drawn is not None
        self.first_cells: list[int] = []
        self.first_ids: list[int] = []
        for columns, table in zip(self._cells.values(), _tables(self.drawn), strict=True):
            # Every part has one offset more than it has cells.
            before = columns["Offsets"].rows - self.count - len(table)
            self.first_cells.append(before)
            self.first_ids.append(columns["Connectivity"].rows - table.size)


def read_cells(file: h5py.File, part: int) -> Cells:
    """Return what the part number ``part`` of ``file`` draws."""
    vertices, lines, triangles = (
        _read_table(access.group(file, f"VTKHDF/{kind}"), part, width)
        for kind, width in zip(KINDS, (1, 2, 3), strict=False)
    )
    first = int(access.dataset(file, "VTKHDF/Lines/NumberOfCells")[:part].sum())
    return Cells(
        vertices, lines, triangles, access.dataset(file, SPRINGS)[first : first + len(lines)]
    )


def _read_table(group: h5py.Group, part: int, width: int) -> NDArray:
    counts = access.dataset(group, "NumberOfConnectivityIds")[: part + 1]
    first = int(counts[:part].sum())
    return access.dataset(group, "Connectivity")[first : first + counts[part]].reshape(
        -1, width
    )


def _tables(cells: Cells) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Return the point numbers of the cells of each of `KINDS`."""
    return cells.vertices, cells.lines, cells.triangles, np.zeros((0, 3), dtype=np.int64)
