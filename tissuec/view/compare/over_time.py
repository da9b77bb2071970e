"""What two runs have over time: logs and energies at common times, and events.

Where both logs have the same times, these are compared; otherwise both at the times of either,
with straight lines between the rows.

Events that only one of two runs has, or that differ in time.

Events are the same where kind and cause are; then those of one kind that are left over, in
their order, such as a motion that was written anew. Each spring that breaks is an event.
"""

from collections import deque
from collections.abc import Callable, Hashable, Iterator

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices
from tissuec.results.tables import Log
from tissuec.results.trajectory import Trajectory
from tissuec.view.compare.matching import MatchedIndices, match_entities
from tissuec.view.compare.sides import Side

AXES = ("x", "y", "z")


class LogDifference(Struct, frozen=True):
    """The largest difference of a log.

    Attributes:
        name: Of the log, or such as "kinetic energy".
        unit: Of its numbers.
        difference: The largest; of vectors the length of the difference.
        time: When [s].
        column: Where, such as the id of a spring; "" for vectors and single numbers.
        scale: The largest size in either.
        moments: How many were compared.
        interpolated: Whether their times differ.
        missing: At how many moments only one of them is a number.
        first, last: Between which times both have rows [s].
    """

    name: str
    unit: str
    difference: float
    time: float
    column: str
    scale: float
    moments: int
    interpolated: bool
    missing: int
    first: float
    last: float

    @property
    def relative(self) -> float:
        """Return the difference relative to the largest size; 0 where all is 0."""
        return self.difference / self.scale if self.difference else 0.0

    @property
    def is_same(self) -> bool:
        """Return whether no number differs."""
        return not self.difference and not self.missing


class Curves(Struct, frozen=True):
    """All logs.

    Attributes:
        both: Those that both have, in the order of a.
        only_a, only_b: Names of the others, and of columns that one alone has.
        apart: Names of logs that have no time, or no column, in common.
    """

    both: tuple[LogDifference, ...]
    only_a: tuple[str, ...]
    only_b: tuple[str, ...]
    apart: tuple[str, ...]

    @property
    def is_same(self) -> bool:
        """Return whether both have the same logs, and these the same numbers."""
        names = self.only_a or self.only_b or self.apart
        return not names and all(curve.is_same for curve in self.both)


def compare_curves(a: Trajectory, b: Trajectory) -> Curves:
    """Return how the logs and energies of two runs differ."""
    here, there = dict(_logs(a)), dict(_logs(b))
    both: list[LogDifference] = []
    apart: list[str] = []
    only_a, only_b = _alone(here, there), _alone(there, here)
    for name in (name for name in here if name in there):
        one, other = here[name], there[name]
        only_a += _alone_columns(name, one, other)
        only_b += _alone_columns(name, other, one)
        found = [curve for curve in compare_logs(name, one, other) if curve is not None]
        both += found
        apart += [] if found else [name]
    return Curves(tuple(both), tuple(only_a), tuple(only_b), tuple(apart))


def _logs(trajectory: Trajectory) -> Iterator[tuple[str, Log]]:
    yield from trajectory.logs.items()
    if trajectory.energies is not None:
        yield "energies", trajectory.energies


def _alone(here: dict[str, Log], there: dict[str, Log]) -> list[str]:
    return [name for name in here if name not in there]


def _alone_columns(name: str, one: Log, other: Log) -> list[str]:
    return [f"{name}: {column}" for column in one.columns if column not in other.columns]


def compare_logs(name: str, a: Log, b: Log) -> Iterator[LogDifference | None]:
    """Yield the curves of a log: one, but a curve for each energy."""
    columns = [column for column in a.columns if column in b.columns]
    if not columns or not len(a.time) or not len(b.time):
        return
    times, values_a, values_b = _aligned(a, b, columns)
    if not len(times):
        return
    interpolated = not are_same(a.time, b.time)
    if name == "energies":
        for place, column in enumerate(columns):
            pair = values_a[:, place, None], values_b[:, place, None]
            yield _curve(f"{column} energy", a.unit, times, *pair, [""], interpolated)
        return
    if tuple(columns) == AXES:
        yield _curve(name, a.unit, times, values_a, values_b, [""], interpolated, vector=True)
        return
    heads = list(map(str, columns)) if len(columns) > 1 else [""]
    yield _curve(name, a.unit, times, values_a, values_b, heads, interpolated)


def _aligned(a: Log, b: Log, columns: list[str | int]) -> tuple[Floats, Floats, Floats]:
    """Return common times [s], and the rows of both there, shape (time, column)."""
    chosen = [[log.columns.index(column) for column in columns] for log in (a, b)]
    if are_same(a.time, b.time):
        return a.time, a.value[:, chosen[0]], b.value[:, chosen[1]]
    times = common(a.time, b.time)
    return times, _between(times, a, chosen[0]), _between(times, b, chosen[1])


def _between(times: Floats, log: Log, columns: list[int]) -> Floats:
    """Return a log at other times [s]; at the time of an event, what is after it."""
    known, rows = log.with_jumps()
    return np.stack([np.interp(times, known, rows[:, k]) for k in columns], axis=1)


def _curve(
    name: str, unit: str, times: Floats, a: Floats, b: Floats, columns: list[str],
    interpolated: bool, *, vector: bool = False,
) -> LogDifference:  # fmt: skip
    known_a, known_b = np.isfinite(a), np.isfinite(b)
    missing = int((known_a != known_b).any(axis=1).sum())
    known = known_a & known_b
    apart = np.where(known, np.subtract(b, a, where=known, out=np.zeros_like(a)), 0.0)
    size = np.maximum(np.abs(np.where(known_a, a, 0.0)), np.abs(np.where(known_b, b, 0.0)))
    if vector:
        lengths = [np.linalg.norm(np.where(k, v, 0.0), axis=1) for k, v in
                   ((known_a, a), (known_b, b))]  # fmt: skip
        apart, size = np.linalg.norm(apart, axis=1)[:, None], np.maximum(*lengths)
    row, column = np.unravel_index(np.argmax(np.abs(apart)), apart.shape)
    return LogDifference(
        name, unit, float(np.abs(apart[row, column])), float(times[row]), columns[column],
        float(size.max()), len(times), interpolated, missing,
        float(times[0]), float(times[-1]),
    )  # fmt: skip


SAME = 1e-9  # of the longer time: below, times differ by rounding alone


def nearness(*times: Floats) -> float:
    """Return the largest difference of times that are considered equal [s].

    Args:
        *times: Times [s], shape (time,) each.
    """
    return SAME * max((float(np.abs(one).max(initial=0.0)) for one in times), default=0.0)


def are_same(a: Floats, b: Floats) -> bool:
    """Return whether two lists of times [s], shape (time,), are equal but for rounding."""
    return len(a) == len(b) and bool((np.abs(a - b) <= nearness(a, b)).all())


def common(a: Floats, b: Floats) -> Floats:
    """Return the times of either within the span of both, each once [s], shape (time,)."""
    near = nearness(a, b)
    times = np.union1d(a, b)
    times = times[(times >= max(a[0], b[0]) - near) & (times <= min(a[-1], b[-1]) + near)]
    return times[np.diff(times, prepend=-np.inf) > near]


def nearest(times: Floats, wanted: Floats, near: float) -> tuple[Indices, NDArray[np.bool_]]:
    """Return the index of the nearest of some times, and whether both are equal.

    Args:
        times: Times [s], ascending, shape (time,).
        wanted: Times to look for [s], shape (n,).
        near: Largest difference of times that are considered equal [s].

    Returns:
        Indices and Booleans, shape (n,) each.
    """
    after = np.clip(np.searchsorted(times, wanted), 0, len(times) - 1)
    before = np.maximum(after - 1, 0)
    place = np.where(wanted - times[before] < times[after] - wanted, before, after)
    return place, np.abs(times[place] - wanted) <= near


BREAKING = ("rupture", "crush")  # of single springs, by themselves


class EventEntry(Struct, frozen=True):
    """An event, or one spring of it.

    Attributes:
        springs: Numbers of pairs, or below zero those that only one side has.
        spring: The network number of a spring that breaks; -1 otherwise.
    """

    time: float
    kind: str
    cause: str
    springs: tuple[int, ...]
    spring: int = -1


class MatchedEvent(Struct, frozen=True):
    """An event of both."""

    a: EventEntry
    b: EventEntry

    @property
    def shift(self) -> float:
        """Return by how much it is later in b [s]."""
        return self.b.time - self.a.time

    @property
    def is_same(self) -> bool:
        """Return whether nothing at all differs."""
        return (self.a.time, self.a.cause, self.a.springs) == (
            self.b.time,
            self.b.cause,
            self.b.springs,
        )


class EventComparison(Struct, frozen=True):
    """Events that both have, in the order of a, and those of one alone."""

    both: tuple[MatchedEvent, ...]
    only_a: tuple[EventEntry, ...]
    only_b: tuple[EventEntry, ...]

    @property
    def is_same(self) -> bool:
        """Return whether the same happened at the same times."""
        return not (self.only_a or self.only_b) and all(one.is_same for one in self.both)


def compare_events(a: Side, b: Side, springs: MatchedIndices) -> EventComparison:
    """Return the events of both runs and those of only one.

    Args:
        a, b: The runs.
        springs: As ``match_springs`` returns them.
    """
    springs = match_entities(a, b, springs)
    left_a = _entries(a, springs.number(a.network.entity_count, "a"), odd=True)
    left_b = _entries(b, springs.number(b.network.entity_count, "b"), odd=False)
    both: list[MatchedEvent] = []
    for key in (_exactly, _alike, _of_kind):
        met, left_a, left_b = _meet(left_a, left_b, key)
        both += met
    both.sort(key=lambda meeting: (meeting.a.time, meeting.b.time))
    return EventComparison(tuple(both), tuple(left_a), tuple(left_b))


def _entries(side: Side, pair: Indices, *, odd: bool) -> list[EventEntry]:
    """Return events with the springs that both sides have numbered alike.

    Of elements that break, these are the springs.

    Args:
        side: The run.
        pair: The pair of each spring, -1 without.
        odd: Whether springs without one get odd numbers, or even ones, below zero.
    """
    found: list[EventEntry] = []
    for event in side.events:
        elements = [one for one in event.springs if one >= side.network.line_count]
        concerned = elements or event.springs
        numbered = zip(pair[list(concerned)].tolist(), concerned, strict=True)
        springs = tuple(n if n >= 0 else -2 * s - 2 + odd for n, s in numbered)
        if event.kind not in BREAKING:
            found.append(
                EventEntry(event.time, event.kind, event.cause, tuple(sorted(springs)))
            )
            continue
        # What broke several elements names the first of them, which says nothing of the others.
        cause = "" if elements else event.cause
        for number, spring in zip(springs, concerned, strict=True):
            found.append(EventEntry(event.time, event.kind, cause, (number,), spring))
    return found


def _exactly(entry: EventEntry) -> Hashable:
    return entry.kind, entry.cause, entry.springs


def _alike(entry: EventEntry) -> Hashable:
    return None if entry.kind in BREAKING else (entry.kind, entry.cause)


def _of_kind(entry: EventEntry) -> Hashable:
    return None if entry.kind in (*BREAKING, "note") else entry.kind


def _meet(
    a: list[EventEntry], b: list[EventEntry], key: Callable[[EventEntry], Hashable]
) -> tuple[list[MatchedEvent], list[EventEntry], list[EventEntry]]:
    """Return pairs of events with the same key, in order, and what is left of both."""
    waiting: dict[Hashable, deque[EventEntry]] = {}
    for entry in b:
        waiting.setdefault(key(entry), deque()).append(entry)
    nobody = waiting.pop(None, deque())
    met: list[MatchedEvent] = []
    left: list[EventEntry] = []
    for entry in a:
        partners = waiting.get(key(entry))
        if partners:
            met.append(MatchedEvent(entry, partners.popleft()))
        else:
            left.append(entry)
    rest = {id(entry) for entries in (*waiting.values(), nobody) for entry in entries}
    return met, left, [entry for entry in b if id(entry) in rest]
