"""How large a result file will be, from what it has room for.

HDF5 allocates whole chunks, and for each column that has any a table of where these are. Both
sides of events are counted, and the topologies after cuts; how often springs rupture is not
known before, nor whether a run takes so long that it keeps a checkpoint. By how much
compression makes frames smaller depends on the motion: 11 to 73 % in the shipped scenes. The
size of a compressed file is therefore that without compression, which it does not exceed.
"""

from collections.abc import Iterator
from math import ceil, floor
from typing import NamedTuple

from msgspec.structs import astuple

from tissuec.model.network import Network
from tissuec.results.alive import row_bytes
from tissuec.results.datasets import DatasetSpec
from tissuec.results.frame_columns import FrameColumns, part_columns
from tissuec.results.frames import MOST_EVENTS, SideColumns
from tissuec.results.mesh import mesh_of
from tissuec.results.recording import LogChannel, Recording
from tissuec.results.schema import (
    EDGES,
    ERRORS,
    LOGS,
    NETWORK,
    ORIGINS_OF,
    PARTICLES,
    PARTS,
    RECORDING,
    TOOL_FRAMES,
)
from tissuec.results.store import LARGE
from tissuec.results.tables import ENERGY, datasets_of
from tissuec.script.plan import Output, SurfaceOutput

EMPTY_FILE = 119_000  # bytes of groups, attributes and first rows, measured
ORIGINS = {"node": 1, "spring": 5}  # arrays of the network whose origins are written
PACKED = {
    "node": 17,
    "spring": 2,
    "edge": 1,
}  # bytes of a large one, whose numbers repeat, measured
TREE = 2_400  # bytes of a table of places
TREE_CHUNKS = 48  # that it has room for, as they come
LOG = 2_700  # bytes of a group with three columns without rows
JUMPS = 4_850  # bytes of the columns of a log's jumps without rows, and of their group


class ForeseenEvents(NamedTuple):
    """What is expected to happen after the start.

    Attributes:
        times: At how many moments.
        cuts: How many of them remove springs.
    """

    times: int
    cuts: int


def file_size(
    network: Network,
    recording: Recording,
    output: Output,
    duration: float,
    events: ForeseenEvents,
) -> int:
    """Return the approximate size of the result file of a run before compression [bytes].

    Args:
        recording: What is recorded.
        output: How often it is recorded.
        duration: Of the run [s].
        events: What happens in it.
    """
    total = EMPTY_FILE
    for axis, count in (
        ("node", network.node_count),
        ("spring", network.spring_count),
        ("edge", len(network.edges)),
        ("line", network.line_count),
        ("triangle", len(network.skin)),
    ):
        total += count * (_bytes_of(axis) if count < LARGE else PACKED.get(axis, 0))
    columns = FrameColumns(recording, mesh_of(network, recording))
    solids = columns.mesh.all_solids
    total += sum(_packed(each.nbytes, len(each)) for each in astuple(solids))
    total += sum(_frames(network, columns, moments(duration, output.every), 1 + events.cuts))
    total += sum(_sides(network, columns, min(events.times, MOST_EVENTS)))
    for log, channel in zip(output.logs, recording.logs, strict=True):
        total += _log(moments(duration, log.every), channel)
    if recording.energies:
        total += _log(moments(duration, output.energy), ENERGY)
    for surface in output.surfaces:
        total += _surface(network, surface, duration, 4 if recording.single else 8)
    return total


def _packed(size: int, rows: int) -> int:
    """Return about how many of so many bytes are written of so many rows of a list."""
    return size if rows < LARGE else size // 20


def _bytes_of(axis: str) -> int:
    """Return the bytes that each node, spring, edge, line or triangle of the network has."""
    groups = (NETWORK, EDGES, RECORDING, PARTICLES)
    arrays = (one for group in groups for one in group.values() if one.axes[:1] == (axis,))
    origins = ORIGINS.get(axis, 0) * ORIGINS_OF["{array}"].row_bytes
    return sum(one.row_bytes for one in arrays) + origins


def moments(duration: float, every: float) -> int:
    """Return how often something is recorded, both ends included; 0 if never."""
    return floor(duration / every * (1.0 + 1e-12)) + 1 if every < float("inf") else 0


def column(rows: int, dataset: DatasetSpec) -> int:
    """Return the size of a column with so many rows [bytes]."""
    chunks = ceil(rows / dataset.chunk)
    return chunks * dataset.chunk * dataset.row_bytes + ceil(chunks / TREE_CHUNKS) * TREE


def _frames(network: Network, columns: FrameColumns, frames: int, parts: int) -> Iterator[int]:
    """Yield the bytes of the columns that hold frames.

    Args:
        frames: How many there are.
        parts: How many topologies they have.
    """
    nodes = len(columns.mesh.nodes)
    if not frames or not nodes:
        return
    for dataset, rows in columns.rows():
        yield column(rows * frames, dataset)
    tools = TOOL_FRAMES["position"].of(kind=columns.kind)
    yield column((network.node_count - network.body_nodes) * frames, tools)
    for dataset in (ERRORS["time"], ERRORS["value"]) * 2:  # and those of the companion run
        yield column(frames, dataset)
    yield column(nodes, columns.node_id)
    yield column(parts * row_bytes(network), PARTS["alive"])
    for dataset, rows in part_columns(columns.mesh).values():
        size = column(parts * rows, dataset)
        yield _packed(size, rows) if dataset.packed else size


def _sides(network: Network, columns: FrameColumns, events: int) -> Iterator[int]:
    """Yield the bytes of the columns that hold both sides of so many events."""
    if events and len(columns.mesh.nodes):
        for dataset, rows in SideColumns(network, columns).rows():
            yield column(2 * events * rows, dataset)


def _log(rows: int, channel: LogChannel) -> int:
    log = datasets_of(LOGS, channel)
    jumps = JUMPS if channel.has_jumps else 0
    return LOG + jumps + column(rows, log["time"]) + column(rows, log["value"])


def _surface(network: Network, surface: SurfaceOutput, duration: float, word: int) -> int:
    """Return about what a smooth surface takes, of half as many points as triangles."""
    (body,) = (body for body in network.bodies if body.name == surface.body)
    triangles = len(network.skin_of(body)) * 4**surface.smoothing.subdivisions
    return triangles // 2 * 3 * word * moments(duration, surface.every) + triangles * 3 * 8
