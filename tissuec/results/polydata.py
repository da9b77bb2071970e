"""Frames as VTKHDF PolyData with steps, which VTK 9.3 and ParaView 5.12 and later open.

Points of all frames stand one after another in one table, and so do the numbers at points and
cells; the group ``Steps`` says where each frame begins. Lines and polygons are written once per
topology (a *part*), to which the steps refer. Cell data stand in the order vertices, lines,
polygons, strips. (VTK file formats, section VTKHDF, version 2.2.)
"""

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.network import Floats, Network
from tissuec.results.field_table import CELLS
from tissuec.results.fields import FieldChannel
from tissuec.results.hdf5 import set_attribute
from tissuec.results.mesh import Cells, RecordedMesh
from tissuec.results.parts import ROOT, Parts
from tissuec.results.recording import Recording
from tissuec.results.store import GrowingDataset, Store

POINTS = ("node", "cell")  # of what points have numbers: of cells, the means around them
FRAME_ROWS = 8192  # 200 kB of vectors: the fastest of those tried for 100 000 nodes
_CHUNK_FRAMES = 64
_EACH = "each node, frame after frame"


def frames_of_a_chunk(nodes: int) -> int:
    """Return how many frames are written, and allocated in the file, at once."""
    return min(_CHUNK_FRAMES, max(1, FRAME_ROWS // max(1, nodes)))


class PolyDataFrames:
    """The group ``/VTKHDF`` of a result file, written from the start or gone on with."""

    def __init__(
        self, store: Store, network: Network, recording: Recording, mesh: RecordedMesh
    ):
        self.mesh, self._channels, self._volumes = mesh, recording.fields, recording.cells
        self.kind = np.dtype("f4" if recording.single else "f8")
        count = len(mesh.nodes)
        self.batch = frames_of_a_chunk(count)  # frames
        self._store = store
        fresh = "VTKHDF" not in store.file
        if fresh:
            write_head(store.group(ROOT))
        self.parts = Parts(store, count, network.springs.ids, mesh.springs)
        self._frame_columns(max(1, count), max(1, len(mesh.springs) + len(mesh.triangles)))
        self._steps = self._step_columns()
        if fresh:
            store.append({self._node_id: network.node_ids[mesh.nodes]})

    @property
    def count(self) -> int:
        """Return how many frames there are, those that wait included."""
        return self._steps["Values"].rows

    def last_time(self) -> float:
        """Return the time of the last frame in the file [s]; minus infinity if it has none."""
        values = self._steps["Values"].dataset
        return float(values[-1]) if len(values) else -np.inf

    def _frame_columns(self, nodes: int, cells: int) -> None:
        def points(name: str, unit: str, text: str, row: tuple[int, ...]) -> GrowingDataset:
            chunk = min(nodes * self.batch, FRAME_ROWS)
            return self._store.column(
                f"/VTKHDF/{name}",
                self.kind,
                text,
                unit=unit,
                row=row,
                chunk=chunk,
                in_parts=True,
            )

        self._position = points("Points", "m", f"position of {_EACH}", (3,))
        self._velocity = points("PointData/velocity", "m/s", f"velocity of {_EACH}", (3,))
        self._numbers = {
            one: points(f"PointData/{one.stored}", one.unit, _text_of(one), one.row)
            if one.at in POINTS
            else self._store.column(
                f"/VTKHDF/CellData/{one.stored}",
                self.kind,
                _text_of(one),
                unit=one.unit,
                chunk=min(cells * self.batch, 3 * FRAME_ROWS),
                in_parts=True,
            )
            for one in self._channels
        }
        self._whole = {
            one: self._cell_column(one) for one in self._channels if one.at == "cell"
        }
        self._node_id = self._store.column(
            "/VTKHDF/PointData/node_id", "i8", "id of each node, the same in all frames"
        )

    def _cell_column(self, channel: FieldChannel) -> GrowingDataset:
        """Return the column of the numbers of cells, of which points have the means."""
        assert self._volumes is not None
        chunk = min(self._volumes.total * self.batch, 3 * FRAME_ROWS)
        text = f"{channel.text}, frame after frame"
        return self._store.column(
            f"{CELLS}/{channel.key}", self.kind, text, unit=channel.unit, chunk=chunk,
            in_parts=True,
        )  # fmt: skip

    def _step_columns(self) -> dict[str, GrowingDataset]:
        steps = step_columns(self._store, ROOT)
        data = [("Point", "velocity"), ("Point", "node_id"), ("Cell", "spring_id")]
        data += [
            ("Point" if one.at in POINTS else "Cell", one.stored) for one in self._channels
        ]
        for group, name in data:
            path = f"{ROOT}/Steps/{group}DataOffsets/{name}"
            text = f"where each frame begins in {group}Data/{name}"
            steps[name] = self._store.column(path, "i8", text)
        return steps

    def append(
        self,
        cells: Cells,
        time: Floats,
        position: NDArray[Any],
        velocity: NDArray[Any],
        numbers: Mapping[FieldChannel, NDArray[Any]],
    ) -> None:
        """Add frames that all show ``cells``.

        Args:
            cells: What is drawn.
            time: [s], shape (frame,).
            position: Of the mesh's nodes [m], shape (frame, node, 3).
            velocity: Of these [m/s], shape (frame, node, 3).
            numbers: Of nodes, lines, triangles or cells by field, in its unit, shape (frame,
                node, …) or alike.
        """
        if not cells.same_as(self.parts.drawn):
            self.parts.draw(cells)
        steps = {"Values": time, **self._offsets(cells.total, len(time))}
        rows: dict[GrowingDataset, ArrayLike] = {
            self._steps[name]: data for name, data in steps.items()
        }
        rows[self._position] = position.reshape(-1, 3)
        rows[self._velocity] = velocity.reshape(-1, 3)
        for channel, data in numbers.items():
            shown = self._at_points_or_cells(channel, data, cells)
            rows[self._numbers[channel]] = shown.reshape(-1, *channel.row)
            if channel.at == "cell":
                rows[self._whole[channel]] = data.reshape(-1)
        self._store.append(rows)

    def _at_points_or_cells(
        self, channel: FieldChannel, data: NDArray[Any], cells: Cells
    ) -> NDArray[Any]:
        """Return the numbers of a field at points, or at all cells of VTK."""
        if channel.at == "node":
            return data
        if channel.at == "cell":
            assert self._volumes is not None
            return np.nan_to_num(self._volumes.at_nodes(data, self.mesh.nodes))
        every = np.zeros((len(data), cells.total), dtype=self.kind)
        every[:, cells.line_rows if channel.at == "spring" else cells.triangle_rows] = data
        return every

    def _offsets(self, cells: int, frames: int) -> dict[str, NDArray[Any]]:
        """Return the rows of ``Steps`` for frames that are about to be added."""
        nodes = len(self.mesh.nodes)
        points = nodes * np.arange(self.count, self.count + frames)
        same = np.zeros(frames, dtype=np.int64)
        return {
            "PartOffsets": same + (self.parts.count - 1),
            "NumberOfParts": same + 1,
            "PointOffsets": points,
            "CellOffsets": np.tile(self.parts.first_cells, (frames, 1)),
            "ConnectivityIdOffsets": np.tile(self.parts.first_ids, (frames, 1)),
            "velocity": points,
            "node_id": same,
            **{
                one.stored: points
                if one.at in POINTS
                else self._numbers[one].rows + cells * np.arange(frames)
                for one in self._channels
            },
            "spring_id": same + self.parts.first_identity,
        }

    def show(self) -> None:
        """Let readers see the frames, after their rows were handed to HDF5."""
        self._store.label(f"{ROOT}/Steps", NSteps=self.count)


def _text_of(channel: FieldChannel) -> str:
    """Return the description of a field's numbers in VTK."""
    if channel.at == "node":
        return f"{channel.text}, frame after frame"
    elsewhere = "nodes without cells" if channel.at == "cell" else "other cells"
    text = channel.at_nodes if channel.at == "cell" else channel.text
    return f"{text}, frame after frame; 0 at {elsewhere}"


def step_columns(store: Store, root: str) -> dict[str, GrowingDataset]:
    """Return the times of the frames of a PolyData group, and where each begins."""
    column = store.column
    steps = {"Values": column(f"{root}/Steps/Values", "f8", "time of each frame", unit="s")}
    for name in ("PartOffsets", "NumberOfParts", "PointOffsets"):
        steps[name] = column(f"{root}/Steps/{name}", "i8", f"{name} of each frame")
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        text = f"{name} of each frame: vertices, lines, polygons, strips"
        steps[name] = column(f"{root}/Steps/{name}", "i8", text, row=(4,))
    return steps


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
