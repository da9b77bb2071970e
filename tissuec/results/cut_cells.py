"""Parts of cut elements in frames and in result files."""

from typing import Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.cut_cells import CutCells, WeightedSums
from tissuec.model.network import Indices, Network
from tissuec.results import access
from tissuec.results.access import Contents, ResultGroup
from tissuec.results.element_cells import PIECE, ElementCells
from tissuec.results.fields import FieldChannel
from tissuec.results.schema import CUT_CELLS
from tissuec.results.store import ColumnTable, Store


class RecordedCutCells(Struct, frozen=True, eq=False):
    """The part of a table of cut cells that frames show.

    Points are numbered as in frames: recorded nodes, followed by riding points.

    Attributes:
        riding: Which riding points of the table these are, ascending, shape (point,).
        sums: What they are, by rows of recorded nodes.
        parts, wholes: Of each recorded part, its place and that of the element that it is a
            part of, among the recorded elements, shape (part,).
        pieces: Tetrahedra of these parts.
        items: The place of the part of each of them among the recorded elements, shape
            (tetrahedron,).
        triangles: Of the outer surface and of cut faces, shape (triangle, 3).
        borders: The part that each bounds, an entity, shape (triangle,).
        cuts: The cut that each is a face of, see ``CutCells``, shape (triangle,).
        are_bare: Which of them bound parts whose tetrahedra are not shown, shape (triangle,).
    """

    riding: Indices
    sums: WeightedSums
    parts: Indices
    wholes: Indices
    pieces: ElementCells
    items: Indices
    triangles: Indices
    borders: Indices
    cuts: Indices
    are_bare: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        table: CutCells,
        nodes: NDArray[np.integer],
        items: Indices,
        solids: ElementCells,
    ) -> Self:
        """Return the recorded part of a table.

        Args:
            table: All of it.
            nodes: Network numbers of the recorded nodes, ascending, shape (node,).
            items: The place of each entity among the recorded elements, or -1, shape
                (entity,).
            solids: The recorded elements that are whole, the first ones of these places.
        """
        row = np.full(table.nodes + len(table.points), -1)
        row[nodes] = np.arange(len(nodes))
        is_shown = np.logical_and.reduceat(
            row[table.points.hosts] >= 0, table.points.first[:-1]
        )
        riding = np.flatnonzero(is_shown)
        sums = table.points.some(is_shown)
        sums = WeightedSums(sums.first, row[sums.hosts], sums.weights)
        row[table.nodes + riding] = len(nodes) + np.arange(len(riding))
        own = items[table.parts] >= 0
        parts, wholes = items[table.parts[own]], items[table.wholes[own]]
        within = items[table.owners] >= 0
        of = items[table.owners[within]]
        order = np.argsort(parts)
        whole = wholes[order[np.searchsorted(parts, of, sorter=order)]]
        pieces = ElementCells(
            np.full(len(of), PIECE, dtype=np.uint8),
            row[table.corners[within]].reshape(-1),
            table.owners[within],
            solids.region[whole], solids.tissue[whole], solids.fibres[whole],
        )  # fmt: skip
        faces = row[table.triangles]
        seen = (faces >= 0).all(axis=1)
        borders = table.borders[seen]
        return cls(
            riding, sums, parts, wholes, pieces, of, faces[seen], borders,
            table.cuts[seen], items[borders] < 0,
        )  # fmt: skip

    def beside(self, values: NDArray[Any], channel: FieldChannel) -> NDArray[Any]:
        """Return numbers of nodes with those of riding points behind them.

        They are weighted sums. Forces have none: those at nodes add up to the whole.

        Args:
            values: Of recorded nodes in the unit of the channel, shape (frame, node, …).
            channel: What they are.

        Returns:
            Of points, shape (frame, point, …).
        """
        if channel.adds_up:
            riding = np.zeros((len(values), len(self.sums), *values.shape[2:]))
        else:
            riding = self.sums.weighted(values.swapaxes(0, 1)).swapaxes(0, 1)
        return np.concatenate([values, riding.astype(values.dtype)], axis=1)


class CutCellTable:
    """The table of cut cells of a file, written as it grows.

    The datasets are made with the first part: most scenes cut no elements.

    Attributes:
        content: What was given; None before the first part.
    """

    def __init__(self, store: Store, network: Network):
        self._store = store
        self._table: ColumnTable | None = None
        self.content = read_cut_cells(store.content, network)
        if self.content is not None:
            self._table = ColumnTable(store, CUT_CELLS)

    def extend(self, table: CutCells | None) -> bool:
        """Add what a table has behind the rows that are there; return whether it has any.

        Raises:
            ValueError: It has fewer rows than there are.
        """
        former = self.content
        if table is None or table is former:
            return False
        now = _rows(table)
        begin = (
            {} if former is None else {name: len(one) for name, one in _rows(former).items()}
        )
        if any(len(now[name]) < first for name, first in begin.items()):
            raise ValueError("a table of cut cells only grows")
        more = {name: each[begin.get(name, 0) :] for name, each in now.items()}
        if not any(map(len, more.values())):
            return False
        self.content = table
        self._table = self._table or ColumnTable(self._store, CUT_CELLS)
        self._table.append(more)
        return True


def _rows(table: CutCells) -> dict[str, NDArray[Any]]:
    """Return the columns of a table by the names of datasets."""
    points = {"hosts": table.points.hosts, "weights": table.points.weights}
    names = [name for name in CUT_CELLS if name not in ("host_count", *points)]
    return {
        "host_count": table.points.counts,
        **points,
        **{name: getattr(table, name) for name in names},
    }


def read_cut_cells(file: ResultGroup, network: Network) -> CutCells | None:
    """Return the parts of all cells that were cut; None without any."""
    if CUT_CELLS.path not in file:
        return None
    found = Contents(file, CUT_CELLS).whole
    points = (found.pop(name) for name in ("host_count", "hosts", "weights"))
    with access.reading(file.file, CUT_CELLS.path):
        return CutCells(nodes=network.node_count, points=WeightedSums.of(*points), **found)
