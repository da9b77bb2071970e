"""The columns of frames, which the writer makes and the predicted size counts.

Besides the fields of a recording, frames have positions and velocities: channels of nodes like
any other.
"""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from tissuec.results.datasets import DatasetSpec
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.mesh import RecordedMesh
from tissuec.results.recording import Recording
from tissuec.results.schema import CELLS, FRAMES, SIDES, STEPS

POSITION = FieldChannel(
    "position", "node", "m", 3, "position of each node", "position", signed=True
)
VELOCITY = FieldChannel(
    "velocity", "node", "m/s", 3, "velocity of each node", "velocity", signed=True
)
MOTION = (POSITION, VELOCITY)
POINTS = ("node", "cell")  # of what points have numbers: of cells, the means around them
FRAME_ROWS = 8192  # 200 kB of vectors: the fastest of those tried for 100 000 nodes
_CHUNK_FRAMES = 64


class FrameColumns:
    """The columns of the frames of a recording, with the rows that are allocated at once.

    Attributes:
        mesh: What frames can show.
        kind: Type of the numbers of frames.
        batch: How many frames are written, and allocated in the file, at once.
        channels: What frames contain: positions, velocities and fields.
        numbers: Numbers at points or at all cells of VTK, by channel.
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
        }
        rows = min(self.places("cell").size * self.batch, 3 * FRAME_ROWS) or 1
        self.whole = {
            one: CELLS["{field}"].of(
                field=one.key, what=one.text, unit=one.unit, kind=self.kind, chunk=rows
            )
            for one in self.channels
            if one.at == "cell"
        }
        begins = [("Point", "velocity"), ("Point", "node_id"), ("Cell", "spring_id")]
        begins += [("Point" if c.at in POINTS else "Cell", c.stored) for c in recording.fields]
        self.steps = steps_of(FRAMES) | {
            name: FRAMES[f"Steps/{at}DataOffsets/{{field}}"].of(field=name)
            for at, name in begins
        }
        self.node_id = FRAMES["PointData/node_id"]

    def _chunk(self, channel: FieldChannel) -> int:
        if channel.at in POINTS:
            return min(max(1, len(self.mesh.nodes)) * self.batch, FRAME_ROWS)
        return min(max(1, self.cells) * self.batch, 3 * FRAME_ROWS)

    @property
    def cells(self) -> int:
        """Return how many lines and triangles frames can show."""
        return len(self.mesh.springs) + len(self.mesh.triangles)

    def places(self, at: Place) -> NDArray[np.integer]:
        """Return the network numbers of what is recorded, shape (place,)."""
        match at:
            case "node":
                return self.mesh.nodes
            case "spring":
                return self.mesh.springs
            case "triangle":
                return self.mesh.faces
            case "cell":
                return np.arange(0 if self._volumes is None else self._volumes.total)

    def rows(self) -> Iterator[tuple[DatasetSpec, int]]:
        """Yield the columns with about as many rows as each frame has."""
        for channel, column in self.numbers.items():
            yield column, len(self.mesh.nodes) if channel.at in POINTS else self.cells
        for column in self.whole.values():
            yield column, self.places("cell").size
        for column in self.steps.values():
            yield column, 1


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
    """Return the columns of a group of PolyData that say where each frame begins."""
    return {name: group[f"Steps/{name}"] for name in STEPS}
