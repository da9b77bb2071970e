"""Frames in a result file: VTKHDF PolyData with steps, whose *parts* are sets of cells.

Points of all frames stand one after another in one table, and so do the numbers at points and
cells; the group ``Steps`` says where each frame begins. Lines and polygons are written once per
topology (a *part*), to which the steps refer. Cell data stand in the order vertices, lines,
polygons, strips. (VTK file formats, section VTKHDF, version 2.2.)

De Buyl, Colberg and Höfling, "H5MD: a structured, efficient, and portable file format for
molecular data", Comput. Phys. Commun. 185 (2014) 1546. The views are virtual datasets, whose
size is fixed: they are made when a file is closed, and removed when its run resumes. Their
``unit`` is an attribute of the group of each quantity: MDAnalysis refuses a ``value`` whose own
``unit`` is metres or newtons, even if it need not convert it.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.core.version import __version__
from tissuec.model.network import Floats, Indices, Network
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.datasets import DatasetSpec
from tissuec.results.fields import FieldChannel
from tissuec.results.frame_columns import MOTION, POINTS, FrameColumns, column_of
from tissuec.results.hdf5 import add_virtual, set_attribute
from tissuec.results.mesh import Cells, RecordedMesh
from tissuec.results.recording import Recording
from tissuec.results.schema import CELL_TABLE, FRAMES, KINDS, LINES, PARTICLES, ROOT
from tissuec.results.store import LARGE, ColumnTable, GrowingDataset, Store, describe


class PolyDataFrames:
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
        self.parts = Parts(store, len(mesh.nodes), network.springs.ids, mesh.springs)
        self._numbers = {one: store.column(data) for one, data in columns.numbers.items()}
        self._whole = {one: store.column(data) for one, data in columns.whole.items()}
        node_id = store.column(columns.node_id)
        self._steps = ColumnTable(store, columns.steps)
        if fresh:
            store.append({node_id: network.node_ids[mesh.nodes]})

    @property
    def count(self) -> int:
        """Return how many frames there are, those that wait included."""
        return self._steps["Values"].rows

    def last_time(self) -> float:
        """Return the time of the last frame in the file [s]; minus infinity if it has none."""
        return self._steps.last("Values")

    def append(
        self, cells: Cells, time: Floats, numbers: Mapping[FieldChannel, NDArray[Any]]
    ) -> None:
        """Add frames that all show ``cells``.

        Args:
            cells: What is drawn.
            time: [s], shape (frame,).
            numbers: Of nodes, lines, triangles or cells by channel, in its unit, shape (frame,
                node, …) or alike.
        """
        if not cells.same_as(self.parts.drawn):
            self.parts.draw(cells)
        steps = {"Values": time, **self._offsets(cells.total, len(time))}
        rows: dict[GrowingDataset, ArrayLike] = {
            self._steps[name]: data for name, data in steps.items()
        }
        for channel, data in numbers.items():
            shown = self._at_points_or_cells(channel, data, cells)
            rows[self._numbers[channel]] = shown.reshape(-1, *channel.row)
            if channel.at == "cell":
                rows[self._whole[channel]] = data.reshape(-1)
        self._store.append(rows)

    def _at_points_or_cells(
        self, channel: FieldChannel, data: NDArray[Any], cells: Cells
    ) -> NDArray[Any]:
        """Return the numbers of a channel at points, or at all cells of VTK."""
        if channel.at == "node":
            return data
        if channel.at == "cell":
            assert self._volumes is not None
            return np.nan_to_num(self._volumes.at_nodes(data, self.mesh.nodes))
        every = np.zeros((len(data), cells.total), dtype=self.columns.kind)
        every[:, cells.line_rows if channel.at == "spring" else cells.triangle_rows] = data
        return every

    def _offsets(self, cells: int, frames: int) -> dict[str, NDArray[Any]]:
        """Return the rows of ``Steps`` for frames that are about to be added."""
        points = len(self.mesh.nodes) * np.arange(self.count, self.count + frames)
        same = np.zeros(frames, dtype=np.int64)
        return {
            "PartOffsets": same + (self.parts.count - 1),
            "NumberOfParts": same + 1,
            "PointOffsets": points,
            "CellOffsets": np.tile(self.parts.first_cells, (frames, 1)),
            "ConnectivityIdOffsets": np.tile(self.parts.first_ids, (frames, 1)),
            "node_id": same,
            "spring_id": same + self.parts.first_identity,
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


def write_type(group: h5py.Group, kind: str) -> None:
    """Write which type of data set a group is."""
    set_attribute(group, "Version", np.array([2, 2], dtype="i8"))
    # Of fixed length: VTK 9.3 does not read a text of variable length here.
    set_attribute(group, "Type", kind.encode(), h5py.string_dtype("ascii", len(kind)))


def write_head(group: h5py.Group) -> None:
    """Make an empty group one of PolyData with steps."""
    write_type(group, "PolyData")
    for name in ("PointData", "CellData", "FieldData"):
        group.create_group(name)
    set_attribute(group.create_group("Steps"), "NSteps", 0, "i8")


GROUPS = ("h5md", "particles")


def add_views(
    file: h5py.File,
    fields: Iterable[FieldChannel],
    *,
    author: str,
    mass: np.ndarray,
    ids: np.ndarray,
) -> None:
    """Add the H5MD view of all frames of ``file``.

    Args:
        file: A result file, all of whose frames are shown.
        fields: What its frames contain; those of nodes are shown.
        author: Who made it, for readers; need not be known.
        mass: Masses of the nodes shown [kg], shape (node,).
        ids: Their ids, shape (node,).
    """
    remove_views(file)
    _write_head(file.create_group("h5md"), author)
    particles = file.create_group("particles/all")
    box = particles.create_group("box")
    box.attrs["dimension"] = 3
    set_attribute(box, "boundary", ["none"] * 3, h5py.string_dtype("ascii", 4))
    for name, data in (("mass", mass), ("id", ids)):
        _add(particles, PARTICLES[name], name, data)
    steps: Any = file["VTKHDF/Steps"]
    frames, nodes = int(steps.attrs["NSteps"]), len(mass)
    if not frames or not nodes:
        return  # HDF5 has no virtual datasets without content
    step = np.arange(frames)
    for channel in (*MOTION, *(one for one in fields if one.at == "node")):
        view = particles.create_group(channel.key)
        view.attrs["unit"] = channel.unit
        source: Any = file[column_of(channel).path]
        value = add_virtual(view, "value", source, (frames, nodes, *channel.row))
        declared = PARTICLES["{field}/value"].of(field=channel.key, unit=channel.unit)
        value.attrs["description"] = declared.text
        view["time"] = steps["Values"]  # the same dataset under a second name
        _add(view, PARTICLES["{field}/step"], "step", step)


def remove_views(file: h5py.File) -> None:
    """Remove the H5MD view, if there is one."""
    for name in GROUPS:
        if name in file:
            del file[name]


def _add(group: h5py.Group, declared: DatasetSpec, name: str, data: np.ndarray) -> None:
    describe(group.create_dataset(name, data=data), declared.unit, declared.text)


def _write_head(group: h5py.Group, author: str) -> None:
    group.attrs["version"] = np.array([1, 1])
    group.create_group("author").attrs["name"] = author
    creator = group.create_group("creator")
    creator.attrs["name"] = "tissuec"
    creator.attrs["version"] = __version__


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
