"""Distances of the same nodes in two runs, compared with both tolerances.

A run that keeps its tolerance τ is no further than τ · d from the true motion, where d is the
largest displacement so far. Two runs of one scene may therefore be τa da + τb db apart.

Runs with the same times are compared at these. Otherwise both are compared at the times of
either, and between two frames a node is on the cubic that has the stored positions and
velocities of both (Hermite, Sur la formule d'interpolation de Lagrange, 1878). What that leaves
open is reported: how far the frames around are from the cubic between their neighbours, which
spans twice the time.
"""

from collections.abc import Iterator
from functools import cached_property
from typing import Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices
from tissuec.results.trajectory import Trajectory
from tissuec.script.verbs.end import KIND as END
from tissuec.view.compare.matching import MatchedIndices
from tissuec.view.compare.over_time import are_same, common, nearest, nearness

Verdict = Literal["agree", "differ", "cannot tell", "nothing promised"]
MOST_NUMBERS = 3_000_000  # that are read at once


class MotionDifference(Struct, frozen=True, eq=False):
    """Distances of common nodes.

    Attributes:
        times: When they were compared [s], shape (time,).
        distance: The largest of all nodes then [m], shape (time,).
        node: Whose it is, as a number in the network of a, shape (time,).
        scale_a, scale_b: Largest displacement in either run until then [m], shape (time,).
        tolerance_a, tolerance_b: What was promised; None where nothing was.
        nodes: How many nodes were compared.
        nodes_a, nodes_b: How many the frames show.
        span_a, span_b: First and last time of the frames [s].
        is_whole: Whether both have the same nodes and come to the same end.
        interpolated: Whether their times differ.
        open: How far off what was compared may be [m]: cubics, and single precision; (time,).
    """

    times: Floats
    distance: Floats
    node: Indices
    scale_a: Floats
    scale_b: Floats
    tolerance_a: float | None
    tolerance_b: float | None
    nodes: int
    nodes_a: int
    nodes_b: int
    span_a: tuple[float, float]
    span_b: tuple[float, float]
    is_whole: bool
    interpolated: bool
    open: Floats

    @property
    def worst(self) -> int:
        """Return the row at which nodes are furthest apart."""
        return int(np.argmax(self.distance))

    @property
    def largest(self) -> float:
        """Return the largest distance [m]."""
        return float(self.distance.max())

    @property
    def relative(self) -> Floats:
        """Return distances divided by the largest displacement so far, dimensionless.

        The shape is (time,).
        """
        return self.distance / np.maximum(self.scale_a, self.scale_b)

    @property
    def allowed(self) -> Floats | None:
        """Return how far both promises let nodes be apart [m], shape (time,)."""
        if self.tolerance_a is None or self.tolerance_b is None:
            return None
        return self.tolerance_a * self.scale_a + self.tolerance_b * self.scale_b

    @property
    def parting(self) -> float | None:
        """Return the first time at which they are certainly further apart than that [s]."""
        if self.allowed is None:
            return None
        beyond = np.flatnonzero(self.distance > self.allowed + self.open)
        return float(self.times[beyond[0]]) if len(beyond) else None

    @property
    def verdict(self) -> Verdict:
        """Return whether both can be right."""
        if self.allowed is None:
            return "nothing promised"
        if self.parting is not None:
            return "differ"
        return "agree" if bool((self.distance <= self.allowed).all()) else "cannot tell"

    @property
    def is_same(self) -> bool:
        """Return whether both are one motion, to the last bit."""
        return self.is_whole and not self.interpolated and not self.largest


def compare_motions(
    a: Trajectory, b: Trajectory, nodes: MatchedIndices
) -> MotionDifference | str:
    """Return how far the nodes of two runs are apart, or why they cannot be compared."""
    shown = np.isin(nodes.a, a.nodes) & np.isin(nodes.b, b.nodes)
    one = _Frames(a, np.searchsorted(a.nodes, nodes.a[shown]))
    other = _Frames(b, np.searchsorted(b.nodes, nodes.b[shown]))
    for name, profile in (("a", one), ("b", other)):
        if not profile.shape[0] or not profile.shape[1]:
            return f"{name} has no frames"
    if not shown.any():
        return "the frames of both have no common node"
    interpolated = not are_same(one.times, other.times)
    times = common(one.times, other.times) if interpolated else one.times
    if not len(times):
        return "they have no common time"
    distance, node = np.zeros(len(times)), np.zeros(len(times), dtype=np.int64)
    for rows in _batches(len(times), int(shown.sum())):
        apart = np.linalg.norm(one.at(times[rows]) - other.at(times[rows]), axis=-1)
        node[rows] = nodes.a[shown][apart.argmax(axis=1)]
        distance[rows] = apart.max(axis=1)
    return MotionDifference(
        times, distance, node, one.displacement(times), other.displacement(times),
        _tolerance(a), _tolerance(b), int(shown.sum()), one.shape[1], other.shape[1],
        one.span, other.span, _is_whole(one, other, int(shown.sum())), interpolated,
        one.open(times) + other.open(times),
    )  # fmt: skip


class _Frames:
    """The motion of some nodes of a run.

    Args:
        rows: The nodes, as rows of the frames.
    """

    def __init__(self, trajectory: Trajectory, rows: Indices):
        self.trajectory, self.rows = trajectory, rows
        self.times = trajectory.times
        self.shape = trajectory.position.shape[:2]

    @property
    def span(self) -> tuple[float, float]:
        return float(self.times[0]), float(self.times[-1])

    def at(self, times: Floats) -> Floats:
        """Return positions at times within the span [m], shape (time, node, 3)."""
        place, exact = self._placed(times)
        if exact.all():
            return self.trajectory.position[place][:, self.rows].astype(float)
        before = np.clip(np.searchsorted(self.times, times) - 1, 0, len(self.times) - 2)
        found = self._cubic(before, before + 1, times)
        if exact.any():
            found[exact] = self.trajectory.position[place[exact]][:, self.rows]
        return found

    def _placed(self, times: Floats) -> tuple[Indices, NDArray[np.bool_]]:
        """Return the nearest frame of each time, and whether it is of that very time."""
        return nearest(self.times, times, nearness(self.times))

    def displacement(self, times: Floats) -> Floats:
        """Return the largest displacement of any node until each time [m], shape (time,)."""
        late = times + nearness(self.times)
        return self._moved[np.searchsorted(self.times, late, side="right") - 1]

    def open(self, times: Floats) -> Floats:
        """Return how far off positions at times may be [m], shape (time,)."""
        _, exact = self._placed(times)
        if exact.all():
            return np.full(len(times), self._rounding)
        before = np.clip(np.searchsorted(self.times, times) - 1, 0, len(self.times) - 2)
        bent = np.maximum(self._bends[before], self._bends[before + 1])
        return self._rounding + np.where(exact, 0.0, bent)

    @cached_property
    def _moved(self) -> Floats:
        from tissuec.engine.run_arrays import FLOOR

        position = self.trajectory.position
        first, moved = position[0].astype(float), np.zeros(len(self.times))
        for rows in _batches(len(self.times), self.shape[1]):
            moved[rows] = np.linalg.norm(position[rows] - first, axis=-1).max(axis=1)
        floor = FLOOR * (self.trajectory.network.extent or 1.0)
        return np.maximum.accumulate(np.maximum(moved, floor))

    @cached_property
    def _rounding(self) -> float:
        """How far off positions are for being stored in single precision, at most [m]."""
        position = self.trajectory.position
        if position.dtype == np.float64:
            return 0.0
        return float(np.abs(position[:]).max() * np.finfo(position.dtype).eps)

    @cached_property
    def _bends(self) -> Floats:
        """How far each frame is from the cubic between its neighbours [m], shape (frame,)."""
        count = len(self.times)
        bends = np.zeros(count)
        for rows in _batches(count - 2, len(self.rows)):
            number = np.arange(1, count - 1)[rows]
            guess = self._cubic(number - 1, number + 1, self.times[number])
            there = self.trajectory.position[number][:, self.rows]
            bends[number] = np.linalg.norm(guess - there, axis=-1).max(axis=1)
        if count > 2:
            bends[0], bends[-1] = bends[1], bends[-2]
        return bends if count > 2 else np.full(count, np.inf)

    def _cubic(self, before: Indices, after: Indices, times: Floats) -> Floats:
        """Return positions between frames, from positions and velocities of both."""
        low = self.times[before]
        step = self.times[after] - low
        p = ((times - low) / step)[:, None, None]
        h = step[:, None, None]
        x, v = self.trajectory.position, self.trajectory.velocity
        x0, v0 = (array[before][:, self.rows].astype(float) for array in (x, v))
        x1, v1 = (array[after][:, self.rows].astype(float) for array in (x, v))
        rise = x1 - x0
        return x0 + p * (
            h * v0 + p * (3.0 * rise - h * (2.0 * v0 + v1) + p * (h * (v0 + v1) - 2.0 * rise))
        )


def _is_whole(a: _Frames, b: _Frames, common: int) -> bool:
    """Return whether all nodes of both were compared, until the end of both.

    Frames at other intervals may end at other times, though the runs do not.
    """
    ends = [profile.times[-1:] for profile in (a, b)]
    runs = [profile.trajectory for profile in (a, b)]
    done = all(run.finished and all(e.kind != END for e in run.events) for run in runs)
    durations = {run.manifest.get("duration") for run in runs}
    ended = are_same(*ends) or (done and len(durations) == 1)
    return common == a.shape[1] == b.shape[1] and ended


def _batches(count: int, nodes: int) -> Iterator[slice]:
    """Yield stretches of so many frames that their numbers fit into memory."""
    size = max(1, MOST_NUMBERS // (3 * max(nodes, 1)))
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))


def _tolerance(trajectory: Trajectory) -> float | None:
    return trajectory.manifest.get("tolerance")
