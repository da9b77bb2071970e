"""Events that only one of two runs has, or that differ in time.

Events are the same where kind and cause are; then those of one kind that are left over, in
their order, such as a motion that was written anew. Each spring that breaks is an event.
"""

from collections import deque
from collections.abc import Callable, Hashable

from msgspec import Struct

from tissuec.model.network import Indices
from tissuec.view.compare.matching import MatchedIndices
from tissuec.view.compare.sides import Side

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
    """Return the events of both runs and those of only one."""
    left_a = _entries(a, springs.number(a.network.spring_count, "a"), odd=True)
    left_b = _entries(b, springs.number(b.network.spring_count, "b"), odd=False)
    both: list[MatchedEvent] = []
    for key in (_exactly, _alike, _of_kind):
        met, left_a, left_b = _meet(left_a, left_b, key)
        both += met
    both.sort(key=lambda meeting: (meeting.a.time, meeting.b.time))
    return EventComparison(tuple(both), tuple(left_a), tuple(left_b))


def _entries(side: Side, pair: Indices, *, odd: bool) -> list[EventEntry]:
    """Return events with the springs that both sides have numbered alike.

    Of elements that break, their marks are the springs.

    Args:
        side: The run.
        pair: The pair of each spring, -1 without.
        odd: Whether springs without one get odd numbers, or even ones, below zero.
    """
    found: list[EventEntry] = []
    for event in side.events:
        marks = [one for one in event.springs if one >= side.network.first_mark]
        concerned = marks or event.springs
        numbered = zip(pair[list(concerned)].tolist(), concerned, strict=True)
        springs = tuple(n if n >= 0 else -2 * s - 2 + odd for n, s in numbered)
        if event.kind not in BREAKING:
            found.append(
                EventEntry(event.time, event.kind, event.cause, tuple(sorted(springs)))
            )
            continue
        # What broke several elements names the first of them, which says nothing of the others.
        cause = "" if marks else event.cause
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
