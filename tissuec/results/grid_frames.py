"""Frames in a result file: a VTKHDF grid with steps, whose *parts* are sets of cells.

Points of all frames stand one after another in one table, and so do the numbers at points and
cells; the group ``Steps`` says where each frame begins. Cells are written once per topology (a
*part*), to which the steps refer. The cells follow from which springs exist (`/tissuec/parts`),
and only VTK reads them. (VTK file formats, section VTKHDF, version 2.2.)
"""

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.network import Floats, Network
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.alive import read_alive, row_bytes
from tissuec.results.datasets import CHUNK, DatasetSpec
from tissuec.results.fields import FieldChannel
from tissuec.results.frame_columns import POINTS, POSITION, FrameColumns, part_columns
from tissuec.results.hdf5 import set_attribute
from tissuec.results.mesh import CellGrid, DrawnMesh, RecordedMesh
from tissuec.results.recording import Recording
from tissuec.results.schema import CELL_TABLE, PARTS, ROOT
from tissuec.results.store import ColumnTable, GrowingDataset, SomeRows, Store


class GridFrames:
    """The group ``/VTKHDF`` of a result file, written from the start or gone on with.

    Attributes:
        columns: Of the frames.
        parts: Their topologies.
    """

    def __init__(
        self, store: Store, network: Network, recording: Recording, mesh: RecordedMesh
    ):
        self.mesh, self._volumes = mesh, recording.cells
        self.columns = columns = FrameColumns(recording, mesh)
        self._store = store
        fresh = "VTKHDF" not in store.file
        if fresh:
            write_head(store.group(ROOT))
        self.parts = Parts(store, network, mesh)
        self._numbers = {one: store.column(data) for one, data in columns.numbers.items()}
        self._whole = {one: store.column(data) for one, data in columns.whole.items()}
        self._node_id = store.column(columns.node_id)
        self._steps = ColumnTable(store, columns.steps)
        if fresh:
            store.append({self._node_id: network.node_ids[mesh.nodes]})

    @property
    def count(self) -> int:
        """Return how many frames there are, those that wait included."""
        return self._steps["Values"].rows

    def last_time(self) -> float:
        """Return the time of the last frame in the file [s]; minus infinity if it has none."""
        return self._steps.last("Values")

    def append(
        self, drawing: DrawnMesh, time: Floats, numbers: Mapping[FieldChannel, NDArray[Any]]
    ) -> None:
        """Add frames that all show the same.

        Args:
            drawing: What they show.
            time: [s], shape (frame,).
            numbers: Of nodes, lines, triangles or cells by channel, in its unit, shape (frame,
                node, …) or alike.
        """
        self.parts.draw(drawing)
        grid, points = drawing.grid, drawing.cells.points
        steps = {"Values": time, **self._offsets(len(grid), points, len(time))}
        if (more := points - self._node_id.rows) > 0:
            self._store.append({self._node_id: np.full(more, -1)})
        rows: dict[GrowingDataset, ArrayLike | SomeRows] = {
            self._steps[name]: data for name, data in steps.items()
        }
        for channel, column in self._numbers.items():
            data, row = numbers[channel], channel.row
            if channel.at == "cell":
                assert self._volumes is not None
                rows[self._whole[channel]] = data.reshape(-1)
                data = np.nan_to_num(self._volumes.at_nodes(data, self.mesh.nodes))
                if drawing.mesh.cut is not None:
                    data = drawing.mesh.cut.beside(data, channel)
            if channel.at in POINTS or data.shape[1] == len(grid):
                rows[column] = data.reshape(-1, *row)
            else:
                rows[column] = SomeRows(data, grid.rows[channel.at].start, len(grid))
        self._store.append(rows)

    def _offsets(self, cells: int, count: int, frames: int) -> dict[str, NDArray[Any]]:
        """Return the rows of ``Steps`` for frames that are about to be added.

        Args:
            cells, count: How many cells and points each of them has.
        """
        points = self._numbers[POSITION].rows + count * np.arange(frames)
        same = np.zeros(frames, dtype=np.int64)
        return {
            **self.parts.offsets(frames),
            "PointOffsets": points,
            "node_id": same,
            **dict.fromkeys(self.mesh.labels, same + self.parts.first_cell),
            **{
                one.stored: points
                if one.at in POINTS
                else self._numbers[one].rows + cells * np.arange(frames)
                for one in self.columns.channels
                if one.stored in self._steps
            },
        }

    def show(self) -> None:
        """Let readers see the frames, after their rows were handed to HDF5."""
        self._store.label(f"{ROOT}/Steps", NSteps=self.count)


GRID = "UnstructuredGrid"


def write_type(group: h5py.Group, kind: str) -> None:
    """Write which type of data set a group is."""
    set_attribute(group, "Version", np.array([2, 2], dtype="i8"))
    # Of fixed length: VTK 9.3 does not read a text of variable length here.
    set_attribute(group, "Type", kind.encode(), h5py.string_dtype("ascii", len(kind)))


def write_head(group: h5py.Group) -> None:
    """Make an empty group a grid with steps."""
    write_type(group, GRID)
    for name in ("PointData", "CellData", "FieldData"):
        group.create_group(name)
    set_attribute(group.create_group("Steps"), "NSteps", 0, "i8")


class CellTables:
    """The cells of all parts of one grid, written from the start or gone on with.

    Args:
        store: The file.
        datasets: Of the group.

    Attributes:
        first_cell: How many cells stand before the last part.
        first_id: How many point numbers stand before the last part.
    """

    def __init__(self, store: Store, datasets: Mapping[str, DatasetSpec]):
        self._table = ColumnTable(store, {name: datasets[name] for name in CELL_TABLE})
        self.first_cell = self.first_id = 0

    @property
    def count(self) -> int:
        """Return how many parts there are, those that wait included."""
        return self._table["NumberOfPoints"].rows

    def add(self, points: int, grid: CellGrid) -> None:
        """Append a part of so many points."""
        self._table.append(grid.table(points))
        self.locate(grid)

    def locate(self, grid: CellGrid) -> None:
        """Set the attributes to the start of the last part, which is given."""
        self.first_cell = self._table["Types"].rows - len(grid)
        self.first_id = self._table["Connectivity"].rows - len(grid.points)

    def offsets(self, frames: int) -> dict[str, NDArray[Any]]:
        """Return rows of ``Steps``: where the cells of the last part are, shape (frame,).

        They are places without a unit.
        """
        same = np.zeros(frames, dtype=np.int64)
        return {
            "PartOffsets": same + (self.count - 1),
            "NumberOfParts": same + 1,
            "CellOffsets": same + self.first_cell,
            "ConnectivityIdOffsets": same + self.first_id,
        }


class Parts(CellTables):
    """The parts of the frames of a net.

    Attributes:
        drawn: What the last one shows.
    """

    def __init__(self, store: Store, network: Network, mesh: RecordedMesh):
        columns = {name: one for name, (one, _) in part_columns(mesh).items()}
        super().__init__(store, columns)
        self._store = store
        self._labels = {name: store.column(columns[f"CellData/{name}"]) for name in mesh.labels}
        self._alive = store.column(PARTS["alive"].of(chunk=max(CHUNK, row_bytes(network))))
        self.drawn: DrawnMesh | None = None
        if self.count:
            alive = alive_in(store.content, self.count - 1, network)
            points = int(self._table["NumberOfPoints"].dataset[-1])
            self.drawn = DrawnMesh(mesh, mesh.cells(alive, points), alive)
            self.locate(self.drawn.grid)

    def draw(self, drawing: DrawnMesh) -> None:
        """Begin a part, unless the last one shows the same."""
        if self.drawn is not None and drawing.cells.same_as(self.drawn.cells):
            return
        self.drawn = drawing
        self.add(drawing.cells.points, drawing.grid)
        labels = {self._labels[name]: each for name, each in drawing.labels.items()}
        self._store.append({**labels, self._alive: np.packbits(drawing.alive)})


def alive_in(file: ResultGroup, part: int, network: Network) -> NDArray[np.bool_]:
    """Return which springs of a network exist in a part of a file, shape (spring,)."""
    return read_alive(file, PARTS["alive"], part, network)


def read_triangles(file: ResultGroup, root: str, part: int) -> NDArray[Any]:
    """Return the cells of a part of a grid of triangles, indices of shape (triangle, 3).

    Args:
        file: The file; the result has no unit.
        root: Path of the grid.
        part: Number of the part.
    """
    path = f"{root}/Connectivity"
    points = int(access.array(file, f"{root}/NumberOfPoints")[part])
    counts = access.array(file, f"{root}/NumberOfConnectivityIds")[: part + 1]
    first = int(counts[:part].sum())
    cells = access.dataset(file, path)[first : first + int(counts[part])]
    if len(cells) < counts[part] or ((cells < 0) | (cells >= points)).any():
        access.damaged(file.file, f'"{path}" names points that there are not')
    return cells.reshape(-1, 3)
