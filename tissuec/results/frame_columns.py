"""The columns of frames that are written and counted, and arrays over frames that are read.

Besides the fields of a recording, frames have positions and velocities: channels of nodes like
any other.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Indices
from tissuec.results.access import Dataset, attribute, damaged
from tissuec.results.datasets import DatasetSpec
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.finite import all_numbers
from tissuec.results.mesh import RecordedMesh
from tissuec.results.recording import Recording
from tissuec.results.schema import CELL_TABLE, CELLS, FRAMES, SIDES, STEPS
from tissuec.results.store import sized

POSITION = FieldChannel(
    "position", "node", "m", 3, "position of each node", "position", signed=True
)
VELOCITY = FieldChannel(
    "velocity", "node", "m/s", 3, "velocity of each node", "velocity", signed=True
)
MOTION = (POSITION, VELOCITY)
POINTS = ("node", "cell")  # of what points have numbers: of cells, the means around them
CELL_PLACES: tuple[Place, ...] = ("spring", "triangle", "element")  # in the order of cells
LEAST_CHUNK = 256
FRAME_ROWS = 8192  # 200 kB of vectors: the fastest of those tried for 100 000 nodes
_CHUNK_FRAMES = 64


class FrameColumns:
    """The columns of the frames of a recording, with the rows that are allocated at once.

    Attributes:
        mesh: What frames can show.
        kind: Type of the numbers of frames.
        batch: How many frames are written, and allocated in the file, at once.
        channels: What frames contain: positions, velocities and fields.
        numbers: Numbers at points or at all cells of VTK, by channel; none of springs where
            VTK shows solid elements and no lines.
        whole: Numbers of the cells of volumes, of which points have the means, by channel.
        steps: Where each frame begins in the other columns, by the name of the column.
    """

    def __init__(self, recording: Recording, mesh: RecordedMesh):
        self._volumes, self.mesh = recording.cells, mesh
        self.kind = "f4" if recording.single else "f8"
        self.channels = (*MOTION, *recording.fields)
        self.batch = min(_CHUNK_FRAMES, max(1, FRAME_ROWS // max(1, len(mesh.nodes))))
        self.numbers = {
            one: column_of(one).of(kind=self.kind, chunk=self._chunk(one))
            for one in self.channels
            if one.at != "spring" or "spring_id" in mesh.labels
        }
        rows = min(self.places("cell").size * self.batch, 3 * FRAME_ROWS) or 1
        self.whole = {
            one: CELLS["{field}"].of(
                field=one.key, what=one.text, unit=one.unit, kind=self.kind, chunk=rows
            )
            for one in self.channels
            if one.at == "cell"
        }
        begins = [("Point", "velocity"), ("Point", "node_id")]
        begins += [("Cell", name) for name in mesh.labels]
        others = (one for one in recording.fields if one in self.numbers)
        begins += [("Point" if one.at in POINTS else "Cell", one.stored) for one in others]
        self.steps = steps_of(FRAMES) | {
            name: FRAMES[f"Steps/{at}DataOffsets/{{field}}"].of(field=name)
            for at, name in begins
        }
        self.node_id = FRAMES["PointData/node_id"]

    def _chunk(self, channel: FieldChannel) -> int:
        if channel.at in POINTS:
            return min(max(1, len(self.mesh.nodes)) * self.batch, FRAME_ROWS)
        own, every = self.mesh.drawn(channel.at), sum(map(self.mesh.drawn, CELL_PLACES))
        # Rows of other cells, which are 0, take no room where they fill a chunk.
        rows = every * self.batch if own == every else max(own, LEAST_CHUNK)
        return min(max(1, rows), 3 * FRAME_ROWS)

    def places(self, at: Place) -> NDArray[np.integer]:
        """Return the network numbers of what is recorded, shape (place,)."""
        if at == "cell":
            return np.arange(0 if self._volumes is None else self._volumes.total)
        return self.mesh.numbers(at)

    def rows(self) -> Iterator[tuple[DatasetSpec, int]]:
        """Yield the columns with about as many rows as each frame has."""
        every = sum(map(self.mesh.drawn, CELL_PLACES))
        for channel, column in self.numbers.items():
            rows = len(self.mesh.nodes)
            if channel.at not in POINTS:  # around those of a frame, chunks are full of zeros
                own = self.mesh.drawn(channel.at)
                rows = min(every, own + column.chunk if own else 0)
            yield column, rows
        for column in self.whole.values():
            yield column, self.places("cell").size
        for column in self.steps.values():
            yield column, 1


def part_columns(mesh: RecordedMesh) -> dict[str, tuple[DatasetSpec, int]]:
    """Return the columns of parts by name, with about as many rows as each part has."""
    lines, triangles, elements = map(mesh.drawn, CELL_PLACES)
    cells = lines + triangles + elements
    points = 2 * lines + 3 * triangles + len(mesh.solids.nodes)
    rows = dict.fromkeys(CELL_TABLE, 1) | {"Types": cells, "Offsets": cells + 1}
    rows |= {"Connectivity": points} | {f"CellData/{name}": cells for name in mesh.labels}
    return {name: (sized(FRAMES[name], count), count) for name, count in rows.items()}


def column_of(channel: FieldChannel) -> DatasetSpec:
    """Return the dataset of frames that VTK shows a channel by."""
    if channel == POSITION:
        return FRAMES["Points"]
    data = "PointData" if channel.at in POINTS else "CellData"
    of_cells = channel.at == "cell"
    return FRAMES[f"{data}/{{field}}"].of(
        field=channel.stored,
        what=channel.at_nodes if of_cells else channel.text,
        elsewhere="; 0 at nodes without cells" if of_cells else "",
        unit=channel.unit,
        row=channel.row,
    )


def side_of(channel: FieldChannel) -> DatasetSpec:
    """Return the dataset of a channel just before and just after events."""
    more = {"node": ", then of the nodes of tools", "cell": ""}
    text = f"{channel.name} of each recorded {channel.at}"
    return SIDES["{field}"].of(
        field=channel.key,
        what=f"{text}{more.get(channel.at, ', 0 once it is gone')}",
        unit=channel.unit,
        row=channel.row,
    )


def steps_of(group: Mapping[str, DatasetSpec]) -> dict[str, DatasetSpec]:
    """Return the columns of a grid that say where each frame begins."""
    return {name: group[f"Steps/{name}"] for name in STEPS}


Numbers: TypeAlias = NDArray[np.floating]  # in single or double precision


class OverFrames:
    """An array whose first axis is that of the frames, read when indexed.

    Takes the indices that NumPy takes; only the frames that the first of them chooses are read.

    Attributes:
        shape: Frames first.
        dtype: Of the numbers, as they are stored.
        unit: Their unit.
    """

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype, unit: str):
        self.shape, self.dtype, self.unit = shape, dtype, unit

    @property
    def ndim(self) -> int:
        """Return the number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Numbers:
        several = isinstance(index, tuple) and len(cast("tuple[Any, ...]", index)) > 0
        first, *rest = cast("tuple[Any, ...]", index if several else (index,))
        if first is Ellipsis or first is None or isinstance(first, tuple):
            return self._read(0, len(self))[index]
        chosen = np.arange(len(self))[first]
        frames = self._gather(chosen.reshape(-1))
        if isinstance(first, slice):
            return frames[(slice(None), *rest)]
        return frames[(np.arange(chosen.size).reshape(chosen.shape)[()], *rest)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Numbers:
        return np.asarray(self[:], dtype=dtype)

    def __repr__(self) -> str:
        size = " x ".join(map(str, self.shape))
        return f"<{size} numbers [{self.unit}], {self.dtype}, read when indexed>"

    def _gather(self, chosen: Indices) -> Numbers:
        """Return frames by number, read at once where they lie close together."""
        low, high = (int(chosen.min()), int(chosen.max()) + 1) if chosen.size else (0, 0)
        if high - low <= 4 * chosen.size:
            return self._read(low, high)[chosen - low]
        return np.concatenate([self._read(frame, frame + 1) for frame in chosen])

    def _read(self, low: int, high: int) -> Numbers:
        """Return the frames from ``low`` to before ``high``."""
        raise NotImplementedError


class Frames(OverFrames):
    """Numbers of what is in all frames, such as nodes, over time, read when indexed.

    Args:
        dataset: The numbers, one frame after the other.
        frames: How many frames there are.
        nodes: How many rows each of them has.
        row: Shape of a row.
        first: Where each frame begins, if others are between them, shape (frame,).
    """

    def __init__(
        self, dataset: Dataset, frames: int, nodes: int, row: tuple[int, ...] = (3,),
        first: Indices | None = None,
    ):  # fmt: skip
        unit = attribute(dataset, "unit", str)
        super().__init__((frames, nodes, *row), dataset.dtype, unit)
        self._dataset, self._first = dataset, first

    def _read(self, low: int, high: int) -> Numbers:
        nodes = self.shape[1]
        if self._first is not None:
            begins = self._first[low:high].tolist()
            rows = [self._dataset.finite(begin, begin + nodes) for begin in begins]
            return np.stack(rows) if rows else np.zeros((0, *self.shape[1:]), self.dtype)
        rows = self._dataset.finite(low * nodes, high * nodes)
        return rows.reshape(high - low, *self.shape[1:])


class Drawn(NamedTuple):
    """What a frame shows of the springs, triangles or elements that have numbers.

    Attributes:
        total: How many cells it has.
        rows: Which of these have the numbers.
        items: Whose numbers they are, ascending, shape (shown,).
    """

    total: int
    rows: slice
    items: Indices


class CellFrames(OverFrames):
    """Numbers of springs, triangles or elements, shape (frame, item, …), read when indexed.

    They are not a number (NaN) from the frame on in which one of these is gone.

    Args:
        channel: Whose numbers they are.
        dtype: Their type.
        dataset: Those of all cells of each frame, one frame after the other; None where VTK
            shows none of the items.
        first: Where those of each frame begin, shape (frame,).
        parts: The topology of each frame, ascending, shape (frame,).
        items: How many springs, triangles or elements are recorded.
        drawn: Gives what a frame shows.
    """

    def __init__(
        self,
        channel: FieldChannel,
        dtype: np.dtype,
        dataset: Dataset | None,
        first: Indices,
        parts: Indices,
        items: int,
        drawn: Callable[[int], Drawn],
    ):
        super().__init__((len(first), items, *channel.row), dtype, channel.unit)
        self._dataset, self._drawn = dataset, drawn
        self._first, self._parts = first, parts

    def shown(self, frame: int) -> tuple[Numbers, Indices]:
        """Return the numbers of what exists in a frame, and whose they are, shape (shown, …).

        Args:
            frame: Its number, which may count from the end.
        """
        drawn, first = self._drawn(frame), int(self._first[frame])
        numbers = np.zeros((0, *self.shape[2:]), dtype=self.dtype)
        if self._dataset is not None:
            numbers = self._dataset.finite(first + drawn.rows.start, first + drawn.rows.stop)
        return numbers, drawn.items

    def _read(self, low: int, high: int) -> Numbers:
        found = np.full((high - low, *self.shape[1:]), np.nan, dtype=self.dtype)
        while low < high:
            # As many frames as have the same cells; their numbers are contiguous.
            stop = min(
                high, int(np.searchsorted(self._parts, int(self._parts[low]), side="right"))
            )
            drawn, start = self._drawn(low), int(self._first[low])
            place = slice(len(found) - (high - low), len(found) - (high - stop))
            if self._dataset is not None:
                rows = self._dataset[start : start + (stop - low) * drawn.total]
                numbers = rows.reshape(stop - low, drawn.total, *self.shape[2:])[:, drawn.rows]
                if not all_numbers(numbers):
                    damaged(self._dataset.file, f'"{self._dataset.path}" is incomplete')
                found[place, drawn.items] = numbers
            low = stop
        return found
