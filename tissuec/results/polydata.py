"""Frames in a result file: VTKHDF PolyData with steps, and the same as views for H5MD.

Points of all frames stand one after another in one table, and so do the numbers at points and
cells; the group ``Steps`` says where each frame begins. Lines and polygons are written once per
topology (a *part*), to which the steps refer. Cell data stand in the order vertices, lines,
polygons, strips. (VTK file formats, section VTKHDF, version 2.2.)

De Buyl, Colberg and Höfling, "H5MD: a structured, efficient, and portable file format for
molecular data", Comput. Phys. Commun. 185 (2014) 1546. The views are virtual datasets, whose
size is fixed: they are made when a file is closed, and removed when its run resumes. Their
``unit`` stands at the group of each quantity: MDAnalysis refuses a ``value`` whose own ``unit``
is metres or newtons, whatever it is asked to convert.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.core.version import __version__
from tissuec.model.network import Floats, Network
from tissuec.results.datasets import DatasetSpec
from tissuec.results.fields import FieldChannel
from tissuec.results.frame_columns import MOTION, POINTS, FrameColumns, column_of
from tissuec.results.hdf5 import add_virtual, set_attribute
from tissuec.results.mesh import Cells, RecordedMesh
from tissuec.results.parts import Parts
from tissuec.results.recording import Recording
from tissuec.results.schema import PARTICLES, ROOT
from tissuec.results.store import ColumnTable, GrowingDataset, Store, describe


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
