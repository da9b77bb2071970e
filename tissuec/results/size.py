"""How large a result file will be, from what it has room for.

HDF5 allocates whole chunks, and for each column that has any a table of where these are. Events
and cuts add to it, and compression takes away: only what is known before the run is counted.
"""

from collections.abc import Iterator
from math import ceil, floor

from tissuec.model.network import Network
from tissuec.results.mesh import RecordedMesh
from tissuec.results.polydata import FRAME_ROWS, frames_of_a_chunk
from tissuec.results.recording import ENERGIES, MOST_JUMPING, Recording
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


def file_size(network: Network, recording: Recording, output: Output, duration: float) -> int:
    """Return the approximate size of the result file of a run before compression [bytes].

    Args:
        network: The network.
        recording: What is recorded.
        output: How often it is recorded.
        duration: Of the run [s].
    """
    total = EMPTY_FILE
    for size, packed, count in (
        (NODE, PACKED_NODE, network.node_count),
        (SPRING, PACKED_SPRING, network.spring_count),
        (TRIANGLE, 0, len(network.skin)),
    ):
        total += count * (size if count < LARGE else packed)
    total += sum(_frames(network, recording, moments(duration, output.every)))
    for log, channel in zip(output.logs, recording.logs, strict=True):
        total += _log(moments(duration, log.every), len(channel.columns))
    if recording.energies:
        total += _log(moments(duration, output.energy), len(ENERGIES))
    for surface in output.surfaces:
        total += _surface(network, surface, duration, 4 if recording.single else 8)
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


def _frames(network: Network, recording: Recording, frames: int) -> Iterator[int]:
    """Yield the bytes of the columns that hold frames."""
    mesh = RecordedMesh.of(network, recording.nodes, recording.springs)
    nodes, lines, triangles = len(mesh.nodes), len(mesh.springs), len(mesh.triangles)
    if not frames or not nodes:
        return
    word, cells = 4 if recording.single else 8, lines + triangles
    batch = frames_of_a_chunk(nodes)
    for _ in ("position", "velocity", "force"):
        yield column(nodes * frames, 3 * word, min(nodes * batch, FRAME_ROWS))
    yield column(cells * frames, word, min(cells * batch, 3 * FRAME_ROWS) or 1)
    tools = network.node_count - network.body_nodes
    yield column(tools * frames, 3 * word, TOOL_CHUNK)
    for _ in range(9 + 4):  # of the steps; of two estimates of the error
        yield column(frames, 8, CHUNK)
    for _ in range(2):
        yield column(frames, 4 * 8, CHUNK)
    yield column(nodes, 8, CHUNK)
    if lines < LARGE:
        for rows in (cells, lines, 2 * lines, lines, 3 * triangles, triangles):
            yield column(rows, 8, CHUNK)


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
