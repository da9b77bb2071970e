"""Smooth surfaces in the file, written and read: a grid with steps for each body.

A group ``/tissuec/surfaces/NAME`` has the layout of ``/VTKHDF``, with as many points as the
surface has: a torn one has fewer triangles and, at times, fewer points than the whole one.
"""

import json
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.geometry.surfaces import SURFACES as MEMBERS
from tissuec.geometry.surfaces.skin import BodySkin, Refinement, Skin
from tissuec.model.network import Floats, Indices, Network, numbers_in
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.datasets import DatasetSpec
from tissuec.results.finite import check_finite, check_shape, check_times
from tissuec.results.frame_columns import steps_of
from tissuec.results.grid_frames import CellTables, read_triangles, write_head
from tissuec.results.hdf5 import copy_to
from tissuec.results.mesh import CellGrid
from tissuec.results.recording import SurfaceChannel
from tissuec.results.schema import CELL_TABLE, SURFACES
from tissuec.results.store import ColumnTable, GrowingDataset, Store, member_name, sized

SURFACE_ROOT = SURFACES.path.rpartition("/")[0]
_MOST_AT_ONCE = 1 << 17  # points: 3 MB of positions
_CHUNK_ROWS = 8192


class SurfaceTable:
    """One smooth surface over time, written from the start or gone on with.

    Args:
        number: Its place in the scene's order.
        single: Whether positions are four-byte numbers.

    Raises:
        ValueError: The network has no such body.
    """

    def __init__(
        self,
        store: Store,
        network: Network,
        channel: SurfaceChannel,
        *,
        number: int,
        single: bool,
    ):
        datasets = SURFACES.of(body=member_name(channel.body))
        self.path = datasets["Points"].path.rpartition("/")[0]
        self._store, self._network = store, network
        self._kind = "f4" if single else "f8"
        body = next((body for body in network.bodies if body.name == channel.body), None)
        if body is None:
            raise ValueError(
                f'there is no body "{channel.body}" whose surface could be computed'
            )
        self._body = BodySkin.of(network, body)
        self._smoothing = MEMBERS[channel.kind](**channel.entries)
        self._begin(datasets, channel, number)
        self._last_time = self._columns.last("Values")
        self._drawn: Indices | None = None
        if self._cells.count:
            self._drawn = read_triangles(store.content, self.path, self._cells.count - 1)
            self._cells.locate(CellGrid.of_triangles(self._drawn))
        self._skin: Skin | None = None
        self._map: Refinement | None = None

    def _begin(
        self, datasets: Mapping[str, DatasetSpec], channel: SurfaceChannel, number: int
    ) -> None:
        if self.path not in self._store.file:
            group = self._store.group(self.path)
            write_head(group)
            entries = json.dumps(dict(channel.entries))
            self._store.label(
                self.path, name=channel.body, number=number, kind=channel.kind, entries=entries
            )
        size = self._body.size(self._smoothing.subdivisions)
        cells = {name: sized(datasets[name], size) for name in CELL_TABLE}
        self._cells = CellTables(self._store, cells)
        self._columns = ColumnTable(self._store, steps_of(datasets))
        points = datasets["Points"].of(kind=self._kind, chunk=min(_CHUNK_ROWS, 16 * size))
        self._points = self._store.column(points)

    def set_topology(self, alive: NDArray[np.bool_]) -> None:
        """Set which springs exist in the frames to come, shape (spring,)."""
        skin = self._body.at(alive)
        if self._skin is None or not skin.same_as(self._skin):
            self._skin, self._map = skin, None
        if not self._cells.count:  # a surface without any frame opens in viewers, too
            self._draw(self._refinement())

    def batches(self, frames: int) -> Iterator[slice]:
        """Yield which frames to add at once, so that they fit into little memory."""
        size = max(1, _MOST_AT_ONCE // max(1, self._refinement().points))
        return (slice(first, first + size) for first in range(0, frames, size))

    def append(self, time: ArrayLike, position: ArrayLike) -> None:
        """Add frames of the network; see `ResultWriter.surface`.

        Args:
            time: Times [s], shape (frame,).
            position: Of all nodes [m], shape (frame, node, 3).
        """
        times = check_times(time, after=self._last_time)
        position = np.asarray(position)
        check_shape(position, (len(times), self._network.node_count, 3), "position")
        nodes = position[:, self._body.nodes]
        numbers = numbers_in(self._body.nodes)
        with np.errstate(over="ignore"):
            kept = nodes.astype(self._kind, copy=False)
        check_finite(kept, "position", times, self._network, numbers, "node")
        refinement = self._refinement()
        self._draw(refinement)
        points = refinement.at(nodes)
        frames, size = points.shape[:2]
        steps = {
            **self._cells.offsets(frames),
            "PointOffsets": self._points.rows + size * np.arange(frames),
            "Values": times,
        }
        rows: dict[GrowingDataset, ArrayLike] = {
            self._columns[name]: steps[name] for name in steps
        }
        self._store.append(rows | {self._points: points.reshape(-1, 3)})
        self._last_time = float(times[-1])

    def _refinement(self) -> Refinement:
        if self._skin is None:
            raise ValueError("state the topology before the first frame")
        if self._map is None:
            self._map = self._smoothing.refine(self._skin)
        return self._map

    def _draw(self, refinement: Refinement) -> None:
        """Begin a part, unless the last one has the same triangles."""
        if self._drawn is None or not np.array_equal(self._drawn, refinement.triangles):
            self._cells.add(refinement.points, CellGrid.of_triangles(refinement.triangles))
            self._drawn = refinement.triangles

    def show(self) -> None:
        """Let readers see the frames, after their rows were handed to HDF5."""
        self._store.label(f"{self.path}/Steps", NSteps=self._columns["Values"].rows)


def read_surfaces(file: ResultGroup) -> dict[str, SurfaceChannel]:
    """Return the surfaces in ``file`` by their paths, in the order of the scene."""
    if SURFACE_ROOT not in file:
        return {}
    return {
        group.path: SurfaceChannel(
            access.attribute(group, "name", str),
            access.attribute(group, "kind", str),
            _entries(group),
        )
        for group in access.groups(access.group(file, SURFACE_ROOT))
    }


def _entries(group: ResultGroup) -> dict[str, Any]:
    with access.reading(group.file, group.path):
        return dict(json.loads(access.attribute(group, "entries", str)))


class SurfaceSeries:
    """A smooth surface over time.

    Attributes:
        name: The body.
        kind: How it is drawn, such as "loop subdivision".
        entries: What the scene says about it, or leaves to the kind: subdivisions, …
        path: Its group in the file.
    """

    def __init__(self, file: ResultGroup, path: str):
        channel = read_surfaces(file)[path]
        self.name, self.kind = channel.body, channel.kind
        self.entries, self.path = channel.entries, path
        self._file = file
        self._steps: dict[str, Indices] = {}

    @cached_property
    def times(self) -> Floats:
        """Times of the frames [s], shape (frame,)."""
        steps = access.group(self._file, f"{self.path}/Steps")
        return access.array(steps, "Values")[: access.attribute(steps, "NSteps", int)]

    @cached_property
    def parts(self) -> Indices:
        """Number of the topology of each frame, shape (frame,); it only ascends."""
        return access.array(self._file, f"{self.path}/Steps/PartOffsets")[: len(self)]

    def __len__(self) -> int:
        return len(self.times)

    def position(self, frame: int) -> NDArray[Any]:
        """Return the points in a frame [m], shape (point, 3)."""
        first, part = self._step("PointOffsets", frame), self._step("PartOffsets", frame)
        count = int(access.array(self._file, f"{self.path}/NumberOfPoints")[part])
        return access.dataset(self._file, f"{self.path}/Points").finite(first, first + count)

    def triangles(self, frame: int) -> Indices:
        """Return the triangles in a frame, as its points, shape (triangle, 3)."""
        return read_triangles(self._file, self.path, self._step("PartOffsets", frame))

    def copy_to(self, file: h5py.File, name: str) -> None:
        """Copy all frames into another file."""
        with access.reading(self._file.file, self.path):
            copy_to(self._file.raw, self.path, file, name)

    def _step(self, name: str, frame: int) -> int:
        if not -len(self) <= frame < len(self):
            raise IndexError(f"frame {frame} of {len(self)}")
        if name not in self._steps:
            self._steps[name] = access.array(self._file, f"{self.path}/Steps/{name}")
        return int(self._steps[name][frame % len(self)])


class Surfaces(Mapping[str, SurfaceSeries]):
    """All smooth surfaces of a file by the names of their bodies, in the order of the scene."""

    def __init__(self, file: ResultGroup):
        self._file = file
        self._paths = {channel.body: path for path, channel in read_surfaces(file).items()}

    def __getitem__(self, name: str) -> SurfaceSeries:
        return SurfaceSeries(self._file, self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)
