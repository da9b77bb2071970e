"""Future events of a run, in order, and lists of times that differ by more than rounding."""

import heapq
from bisect import bisect_left, insort
from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import Self

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.model.network import Floats
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs import Action, LoggedEvent

_ADDED, _WRITTEN, _FOLLOWING = 0, 1, 2  # which comes first at one time


class ActionQueue(Struct, eq=False):
    """Actions at times.

    At one time, those come first that an action added, then those that are written with a time,
    then those that follow a trigger. So it does not matter when a written one is entered.

    Attributes:
        near: Times that differ by less are one time [s].
        last: Time from which added actions are left out [s]: in a static run, what lasts until
            the end still acts in the equilibrium there.
        entries: A heap of time [s], rank, number, and action; an action of None only requests a
            step to land there.
        written: Times of the script, ascending [s]; an added time near one of them is it.
        count: How many entries there were.
        ended: What ended the run, once something has.
    """

    near: float
    last: float = inf
    entries: list[tuple[float, int, int, Action | None]] = field(
        default_factory=list[tuple[float, int, int, Action | None]]
    )
    written: list[float] = field(default_factory=list[float])
    count: int = 0
    ended: LoggedEvent | None = None

    @classmethod
    def of(cls, plan: Plan) -> Self:
        """Return the script of a plan, all of which is still to come."""
        simulation = plan.simulation
        near = SAME * simulation.duration
        queue = cls(near, simulation.duration - near if simulation.is_static else inf)
        queue.write(plan.events)
        return queue

    def add(self, time: float, action: Action) -> None:
        """Add an action, such as the end of a motion, at a time [s]."""
        if time < self.last:
            self._enter(time, _ADDED, action)

    def land(self, times: Floats) -> None:
        """Request that steps land on times [s]."""
        for time in times:
            self._enter(float(time), _ADDED, None)

    def end(self, ended: LoggedEvent) -> None:
        """End the run after everything that happens at the present time."""
        self.ended = ended

    def write(self, events: Sequence[ScheduledAction]) -> None:
        """Add written events to the script, their times counted from 0 s."""
        for event in events:
            insort(self.written, event.time)
        for event in events:
            self._enter(event.time, _WRITTEN, event.action)

    def follow(self, events: Iterable[ScheduledAction], start: float) -> None:
        """Add the events of a trigger, their times counted from ``start`` [s]."""
        for event in events:
            self._enter(start + event.time, _FOLLOWING, event.action)

    @property
    def next(self) -> float:
        """Return the time of the next entry [s]; infinite without one."""
        return self.entries[0][0] if self.entries else inf

    def due(self, time: float) -> Iterator[Action]:
        """Remove and yield the actions at a time, also those added meanwhile."""
        while self.next <= time + self.near:
            action = heapq.heappop(self.entries)[3]
            if action is not None:
                yield action

    def _enter(self, time: float, rank: int, action: Action | None) -> None:
        place = bisect_left(self.written, time - self.near)
        if place < len(self.written) and self.written[place] <= time + self.near:
            time = self.written[place]
        heapq.heappush(self.entries, (time, rank, self.count, action))
        self.count += 1


SAME = 1e-12
"""Times closer than this part of the duration are one time."""


def join_times(times: Floats, anchors: Floats, near: float) -> Floats:
    """Return distinct times in ascending order.

    Of times that are nearly the same the first counts, or the last anchor that is among them.

    Args:
        times: [s], shape (time,), in any order.
        anchors: Times that are taken as they are, such as those of events [s].
        near: Largest difference between times that are one [s].
    """
    times = np.sort(times)
    if not len(times):
        return times
    times = times[np.concatenate([[True], np.diff(times) > near])]
    places = np.minimum(np.searchsorted(times, anchors - near), len(times) - 1)
    is_there = np.abs(times[places] - anchors) <= near
    times[places[is_there]] = anchors[is_there]
    return times


def rows_at(times: Floats, wanted: Floats, near: float) -> NDArray[np.bool_]:
    """Return which times are among the wanted ones, shape (time,).

    Args:
        times: Distinct and ascending [s]; holds every wanted time, up to ``near``.
        wanted: [s], shape (wanted,).
        near: Largest difference between times that are one [s].
    """
    chosen = np.zeros(len(times), dtype=bool)
    places = np.searchsorted(times, wanted - 2.0 * near)
    chosen[places[places < len(times)]] = True
    return chosen


def rows_within(times: Floats, start: float, stop: float, near: float) -> NDArray[np.bool_]:
    """Return which times lie in a closed interval, shape (time,).

    Args:
        times: Times [s], shape (time,).
        start: Start of the interval [s].
        stop: End of the interval [s].
        near: Largest difference between times that are considered equal [s].
    """
    return (times >= start - 2.0 * near) & (times <= stop + 2.0 * near)
