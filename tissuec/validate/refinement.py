"""How far results depend on the mesh: runs with cells that are halved again and again.

With errors c h^p of cells of length h, results q1 and q2 of two meshes, whose lengths have the
ratio r, give the limit q2 + (q2 - q1) / (r^p - 1); a third mesh gives p. (L. F. Richardson,
Phil. Trans. R. Soc. A 226:299, 1927; P. J. Roache, J. Fluids Eng. 116:405, 1994.)
"""

import time as clock
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from msgspec import Struct
from scipy.spatial import KDTree

from tissuec.compiler.compile import Compiled
from tissuec.core.arrays import SAME_PLACE, largest_side
from tissuec.core.signals import interruption
from tissuec.engine.execution.event_queue import SAME
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder, wishes
from tissuec.engine.execution.run import Outcome, run
from tissuec.model.network import Floats, Indices, Network
from tissuec.results.recording import LogChannel

ORDER = 2.0  # of elements with straight edges, where no third mesh measures it
LEAST_ORDER, MOST_ORDER = 0.5, 4.5  # beyond, the meshes are too coarse for an order
_ROUNDING = 1e-9  # of a quantity: smaller changes are rounding, and have no order


class MeshRun(Struct, frozen=True, eq=False):
    """A run with one of the meshes.

    Attributes:
        network: The net of the mesh.
        outcome: How the run ended.
        logs: Of each log with the same columns in all meshes, times [s] and rows, shapes (row,)
            and (row, column).
        wall_time: [s].
    """

    network: Network
    outcome: Outcome
    logs: dict[str, tuple[Floats, Floats]]
    wall_time: float

    @property
    def cells(self) -> int:
        """Number of elements."""
        return self.network.size.elements


class Dependence(Struct, frozen=True):
    """How a quantity depends on the mesh.

    Attributes:
        name: A log, or "displacement".
        unit: SI unit.
        values: Sizes with each mesh, when the first two differ most.
        change: Largest difference between the first mesh and the second one, relative to the
            largest value.
        order: Observed order of the error; None with two meshes, or where there is none.
        error: Estimated error of the first mesh, relative to the largest value.
        time: When the first two differ most [s].
    """

    name: str
    unit: str
    values: tuple[float, ...]
    change: float
    order: float | None
    error: float
    time: float


def mesh_run(compiled: Compiled, progress: Callable[[float], None]) -> MeshRun:
    """Return the run of a scene with one mesh; no file is written.

    Args:
        compiled: The scene.
        progress: Called with the simulated time [s].

    Raises:
        KeyboardInterrupt: The run was interrupted.
    """
    started = clock.monotonic()
    network, plan, memory = compiled.network, compiled.plan, MemoryRecording()
    outcome = run(network, plan, Recorder(network, plan, memory), progress=progress)
    if outcome.kind == "interrupted":
        raise interruption(outcome.signal)
    logs = {one.name: memory.log_arrays(one.name) for one in comparable_logs(compiled)}
    return MeshRun(network, outcome, logs, clock.monotonic() - started)


def comparable_logs(compiled: Compiled) -> Iterator[LogChannel]:
    """Yield the logs that have one number, or one vector, in any mesh."""
    for channel in wishes(compiled.network, compiled.plan).logs:
        if not any(isinstance(column, int) for column in channel.columns):
            yield channel


def dependences(compiled: Compiled, runs: Sequence[MeshRun]) -> list[Dependence]:
    """Return how displacements at the end, and logs, depend on the mesh.

    Args:
        compiled: The scene, with the first mesh.
        runs: With finer and finer meshes, at least two.
    """
    dimension = 3.0 if compiled.network.of_kind("elements") else 2.0
    ratios = [
        (fine.cells / coarse.cells) ** (1.0 / dimension) for coarse, fine in pairwise(runs)
    ]
    end = min(one.outcome.state.time for one in runs)
    moved = _displacements(runs)
    quantities = [("displacement", "m", np.full(len(moved[0]), end), moved)]
    for channel in comparable_logs(compiled):
        times, rows = _common([one.logs[channel.name] for one in runs], end)
        quantities.append((channel.name, channel.unit, times, rows))
    return [
        _dependence(name, unit, times, rows, ratios)
        for name, unit, times, rows in quantities
        if len(times)
    ]


def _displacements(runs: Sequence[MeshRun]) -> list[Floats]:
    """Return displacements at the end [m] of the nodes that all meshes have, (node, 3) each."""
    drawn = _drawn(runs[0].network)
    near, common = SAME_PLACE * largest_side(drawn[:, :3]), drawn[:, 3] >= 0.0
    places: list[Indices] = []
    for one in runs:
        distance, place = KDTree(_drawn(one.network)).query(drawn)
        common &= distance <= near
        places.append(np.asarray(place))
    return [
        (one.outcome.state.position - one.network.position)[place[common]]
        for one, place in zip(runs, places, strict=True)
    ]


def _drawn(network: Network) -> Floats:
    """Return the nodes of bodies as drawn, with the number of the body, shape (node, 4).

    Bodies in contact may have nodes at the same place. Copies in reserve for cuts have -1.
    """
    number = np.zeros((network.body_nodes, 1))
    for k, body in enumerate(network.bodies):
        number[body.nodes] = k
    for part in network.phantoms:
        number[part.reserved] = -1.0
    return np.concatenate([network.position[: network.body_nodes], number], axis=1)


def _common(logs: Sequence[tuple[Floats, Floats]], end: float) -> tuple[Floats, list[Floats]]:
    """Return times of numbers in all logs [s], (row,), and their rows, (row, column) each."""
    near = SAME * end
    times = logs[0][0]
    places = [np.searchsorted(own, times - near).clip(max=len(own) - 1) for own, _ in logs]
    common = times <= end + near
    for (own, rows), place in zip(logs, places, strict=True):
        common &= np.abs(own[place] - times) <= near
        common &= np.isfinite(rows[place]).all(axis=1)
    found = [rows[place[common]] for (_, rows), place in zip(logs, places, strict=True)]
    return times[common], found


def _dependence(
    name: str, unit: str, times: Floats, rows: Sequence[Floats], ratios: Sequence[float]
) -> Dependence:
    """Return how a quantity depends on the mesh.

    Args:
        times: Of rows [s], shape (row,).
        rows: Of each mesh, shape (row, column).
        ratios: How many times longer the cells of each mesh are than those of the next one.
    """
    scale = float(max(np.abs(row).max() for row in rows)) or 1.0
    changes = [np.linalg.norm(fine - coarse, axis=1) / scale for coarse, fine in pairwise(rows)]
    largest = [float(change.max()) for change in changes]
    order = None
    if len(changes) > 1 and min(largest[-2:]) > _ROUNDING:
        observed = float(np.log(largest[-2] / largest[-1]) / np.log(ratios[-1]))
        order = observed if LEAST_ORDER <= observed <= MOST_ORDER else None
    assumed = order or (ORDER if len(changes) == 1 else 1.0)
    limit = rows[-1] + (rows[-1] - rows[-2]) / (ratios[-1] ** assumed - 1.0)
    at = int(changes[0].argmax())
    there = [row[at] for row in rows]
    values = (float(np.linalg.norm(row)) if len(row) > 1 else float(row[0]) for row in there)
    error = float(np.linalg.norm(rows[0] - limit, axis=1).max()) / scale
    return Dependence(name, unit, tuple(values), largest[0], order, error, float(times[at]))
