"""How large a result file will be, from what it has room for.

HDF5 allocates whole chunks, and for each column that has any a table of where these are. Both
sides of events are counted, and the topologies after cuts; how often springs rupture is not
known before. By how much compression makes frames smaller depends on
the motion: 11 to 73 % in the shipped scenes. The size of a compressed file is therefore that
without compression, which it does not exceed.
"""

from collections.abc import Iterator
from math import ceil, floor
from typing import NamedTuple

from tissuec.model.network import Network
from tissuec.results.fields import Place
from tissuec.results.mesh import RecordedMesh
from tissuec.results.polydata import FRAME_ROWS, POINTS, frames_of_a_chunk
from tissuec.results.recording import ENERGIES, MOST_JUMPING, Recording
from tissuec.results.sides import MOST_EVENTS, side_rows_of_a_chunk
from tissuec.results.store import CHUNK, LARGE
from tissuec.results.tables import rows_of_a_chunk
from tissuec.results.tools import TOOL_CHUNK
from tissuec.script.plan import Output, SurfaceOutput

EMPTY_FILE = 145_000  # bytes of groups, attributes and first rows, measured
NODE, SPRING, TRIANGLE = 100, 84, 12  # bytes of the network
PACKED_NODE, PACKED_SPRING = 17, 2  # of a large one, whose numbers repeat themselves, measured
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
        network: The network.
        recording: What is recorded.
        output: How often it is recorded.
        duration: Of the run [s].
        events: What happens in it.
    """
    total = EMPTY_FILE
    for size, packed, count in (
        (NODE, PACKED_NODE, network.node_count),
        (SPRING, PACKED_SPRING, network.spring_count),
        (TRIANGLE, 0, len(network.skin)),
    ):
        total += count * (size if count < LARGE else packed)
    mesh = RecordedMesh.of(network, recording.nodes, recording.springs)
    word = 4 if recording.single else 8
    fields = _Fields(recording, mesh, word)
    total += sum(_frames(network, fields, moments(duration, output.every), 1 + events.cuts))
    total += sum(_sides(network, fields, min(events.times, MOST_EVENTS)))
    for log, channel in zip(output.logs, recording.logs, strict=True):
        total += _log(moments(duration, log.every), len(channel.columns))
    if recording.energies:
        total += _log(moments(duration, output.energy), len(ENERGIES))
    for surface in output.surfaces:
        total += _surface(network, surface, duration, word)
    return total


def moments(duration: float, every: float) -> int:
    """Return how often something is recorded, both ends included; 0 if never."""
    return floor(duration / every * (1.0 + 1e-12)) + 1 if every < float("inf") else 0


def column(rows: int, row: int, chunk: int) -> int:
    """Return the size of a column [bytes].

    Args:
        rows: Number of rows.
        row: Size of a row [bytes].
        chunk: Rows that are allocated at once.
    """
    chunks = ceil(rows / chunk)
    return chunks * chunk * row + ceil(chunks / TREE_CHUNKS) * TREE


class _Fields(NamedTuple):
    """What is recorded of the net; ``word`` is the size of a number [bytes]."""

    recording: Recording
    mesh: RecordedMesh
    word: int

    def places(self, at: Place) -> int:
        """Return how many nodes, springs, triangles or cells have numbers."""
        if at == "cell":
            return 0 if self.recording.cells is None else self.recording.cells.total
        shown = {"node": "nodes", "spring": "springs", "triangle": "triangles"}
        return len(getattr(self.mesh, shown[at]))


def _frames(network: Network, fields: _Fields, frames: int, parts: int) -> Iterator[int]:
    """Yield the bytes of the columns that hold frames.

    Args:
        network: The network.
        fields: What is recorded.
        frames: How many.
        parts: How many topologies they have.
    """
    mesh, word, places = fields.mesh, fields.word, fields.places
    nodes, lines, triangles = len(mesh.nodes), len(mesh.springs), len(mesh.triangles)
    if not frames or not nodes:
        return
    cells = lines + triangles
    batch = frames_of_a_chunk(nodes)
    channels = fields.recording.fields
    for width in (3, 3, *(one.width for one in channels if one.at in POINTS)):
        yield column(nodes * frames, width * word, min(nodes * batch, FRAME_ROWS))
    of_cells = [places("cell") for one in channels if one.at == "cell"]
    for rows in (*of_cells, *(cells for one in channels if one.at not in POINTS)):
        yield column(rows * frames, word, min(rows * batch, 3 * FRAME_ROWS) or 1)
    tools = network.node_count - network.body_nodes
    yield column(tools * frames, 3 * word, TOOL_CHUNK)
    for _ in range(7 + len(channels) + 4):  # of the steps; of two estimates of the error
        yield column(frames, 8, CHUNK)
    for _ in range(2):
        yield column(frames, 4 * 8, CHUNK)
    yield column(nodes, 8, CHUNK)
    if lines < LARGE:
        for rows in (cells, lines, 2 * lines, lines, 3 * triangles, triangles):
            yield column(parts * rows, 8, CHUNK)


def _sides(network: Network, fields: _Fields, events: int) -> Iterator[int]:
    """Yield the bytes of the columns that hold both sides of events.

    Args:
        network: The network.
        fields: What is recorded.
        events: How many.
    """
    word, tools = fields.word, network.node_count - network.body_nodes
    if events and fields.places("node"):
        nodes = fields.places("node") + tools
        for rows, row in (
            *((nodes, 3 * word) for _ in ("position", "velocity")),
            *(
                (fields.places(one.at) + tools * (one.at == "node"), one.width * word)
                for one in fields.recording.fields
            ),
            (network.spring_count // 8 + 1, 1),
        ):
            yield column(2 * events * rows, row, side_rows_of_a_chunk(rows))


def _log(rows: int, width: int) -> int:
    jumps = JUMPS if width <= MOST_JUMPING else 0
    return (
        LOG + jumps + column(rows, 8, CHUNK) + column(rows, 8 * width, rows_of_a_chunk(width))
    )


def _surface(network: Network, surface: SurfaceOutput, duration: float, word: int) -> int:
    """Return about what a smooth surface takes, of half as many points as triangles."""
    (body,) = (body for body in network.bodies if body.name == surface.body)
    triangles = len(network.skin_of(body)) * 4**surface.smoothing.subdivisions
    return triangles // 2 * 3 * word * moments(duration, surface.every) + triangles * 3 * 8
