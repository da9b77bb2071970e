"""Evaluation of expectations during a run."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.engine.execution.doubts import DoubtMemory
from tissuec.engine.execution.effects import EffectMemory
from tissuec.engine.execution.event_queue import rows_at, rows_within
from tissuec.model.network import Floats
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Expectation

#: Takes the place of an expectation, times of samples [s], shape (row,), or None for a time
#: between samples, and the gaps of what it compares in SI units, shape (row, comparison).
Weigh: TypeAlias = Callable[[int, Floats | None, Floats], None]


class Failure(Struct, frozen=True):
    """The first time at which an expectation did not hold.

    Attributes:
        expectation: Its place in the plan.
        time: [s].
        measured: What was measured, such as "gap(oviduct) = 0.2 mm".
    """

    expectation: int
    time: float
    measured: str


class ExpectationMemory(Struct, eq=False):
    """State of a recorder that is needed to resume after an interruption.

    Attributes:
        next: The first sample that has not come yet.
        scale: Largest energy so far [J].
        pinned: Snapshots that expectations look back to, by their times [s].
        failures: By the place of the expectation.
        held: When an expectation was judged last [s] and what was measured then, by its place.
        doubts: What makes numbers of the run doubtful.
        effects: What orders have done.
    """

    next: int = 0
    scale: float = 0.0
    pinned: dict[float, Snapshot] = field(default_factory=dict[float, Snapshot])
    failures: dict[int, Failure] = field(default_factory=dict[int, Failure])
    held: dict[int, tuple[float, str]] = field(default_factory=dict[int, tuple[float, str]])
    doubts: DoubtMemory = field(default_factory=DoubtMemory)
    effects: EffectMemory = field(default_factory=EffectMemory)


class ExpectationMonitor:
    """Judges expectations at every sample within their intervals and at the ends.

    An interval ends before the events at its end and begins after those at its beginning.

    Args:
        times: All times of samples [s], shape (sample,).
        near: Largest difference between times that are one [s].
        weigh: Told by how much each expectation holds, wherever it is judged.
    """

    def __init__(
        self,
        expectations: tuple[Expectation, ...],
        times: Floats,
        near: float,
        weigh: Weigh | None = None,
    ):
        self.expectations, self.times, self.near = expectations, times, near
        self._weigh = weigh
        self._pinned_at = {
            time: int(np.argmax(rows_at(times, np.array([time]), near)))
            for expectation in expectations
            for time in expectation.pinned
        }
        self._due = [rows_within(times, e.start, e.stop, near) for e in expectations]
        self._last = [int(due.nonzero()[0].max(initial=-1)) for due in self._due]

    def due(self) -> tuple[NDArray[np.bool_], ...]:
        """Return at which samples each expectation is judged, shape (sample,) each."""
        return tuple(due.copy() for due in self._due)

    def set_due(self, due: tuple[NDArray[np.bool_], ...]) -> None:
        """Judge each expectation at some samples only, shape (sample,) each."""
        self._due = [one.copy() for one in due]

    def enter(self, time: float) -> None:
        """Exclude the samples from now on from the intervals that have ended."""
        for due, expectation in zip(self._due, self.expectations, strict=True):
            if self._lasts(expectation) and expectation.stop - self.near <= time:
                due[self.times >= expectation.stop - 2.0 * self.near] = False

    def leave(self, snapshot: Snapshot, memory: ExpectationMemory) -> None:
        """Judge the intervals that end at a snapshot, before its events."""
        for number, expectation in enumerate(self.expectations):
            ends_now = abs(expectation.stop - float(snapshot.time)) <= self.near
            if ends_now and self._lasts(expectation):
                self._judge(number, replace(snapshot, pinned=memory.pinned), memory, ends=True)

    def end(self, snapshot: Snapshot, memory: ExpectationMemory) -> None:
        """Judge the intervals that have begun: they end now.

        Args:
            snapshot: At the end of the run.
            memory: Results so far, changed in place.
        """
        for number, expectation in enumerate(self.expectations):
            time = float(snapshot.time)
            if expectation.start - self.near <= time <= expectation.stop:
                self._judge(number, replace(snapshot, pinned=memory.pinned), memory, ends=True)
                self._due[number][memory.next :] = False

    def sample(self, snapshot: Snapshot, rows: slice, memory: ExpectationMemory) -> None:
        """Evaluate expectations at a batch of samples.

        Args:
            snapshot: The batch.
            rows: Its place in ``times``.
            memory: Results so far, changed in place.
        """
        for time, place in self._pinned_at.items():
            if rows.start <= place < rows.stop:
                then = snapshot.pick(np.array([place - rows.start])).pick(
                    0
                )  # a copy of the state
                memory.pinned[time] = replace(then, pinned={})
        for number, due in enumerate(self._due):
            places = np.flatnonzero(due[rows])
            if not len(places) or number in memory.failures:
                continue
            ends = rows.start + places == self._last[number]
            holds = self._holds(number, snapshot.pick(places))
            # The measured value is reported for the first failure, and at the end.
            for place, is_last in zip(places[~holds | ends], ends[~holds | ends], strict=True):
                self._judge(number, snapshot.pick(int(place)), memory, ends=bool(is_last))

    def unreached(self, memory: ExpectationMemory) -> tuple[int, ...]:
        """Return the expectations that were not judged to their end, by their places.

        One that has failed is decided, however early.
        """
        return tuple(
            number
            for number, due in enumerate(self._due)
            if number not in memory.failures and due[memory.next :].any()
        )

    def _lasts(self, expectation: Expectation) -> bool:
        return expectation.start < expectation.stop - self.near

    def _judge(
        self, number: int, snapshot: Snapshot, memory: ExpectationMemory, *, ends: bool
    ) -> None:
        expectation = self.expectations[number]
        if number in memory.failures:
            return
        time = float(snapshot.time)
        if not self._holds(number, snapshot):
            memory.held.pop(number, None)
            memory.failures[number] = Failure(number, time, expectation.describe(snapshot))
        elif ends:
            memory.held[number] = time, expectation.describe(snapshot)

    def _holds(self, number: int, snapshot: Snapshot) -> NDArray[np.bool_]:
        """Return when an expectation holds, shape (…) as a batch of snapshots."""
        expectation, is_batch = self.expectations[number], np.ndim(snapshot.time) > 0
        compared, condition = expectation.compared, expectation.condition
        if self._weigh is None or compared is None:
            return condition.holds(snapshot) if is_batch else np.asarray(condition(snapshot))
        holds, gaps = compared.weighed(snapshot)
        time = np.asarray(snapshot.time) if is_batch else None
        self._weigh(number, time, np.atleast_2d(gaps))
        return holds
