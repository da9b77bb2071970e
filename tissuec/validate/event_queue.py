"""The reference's own queue of future actions and of times at which steps end."""

from collections.abc import Iterator, Sequence

import numpy as np

from tissuec.model.network import Floats
from tissuec.script.plan import ScheduledAction
from tissuec.script.verbs import Action, LoggedEvent

_ENTERED, _WRITTEN = 0, 1


class ReferenceQueue:
    """Actions in the order of time; those that actions add come before written ones.

    Args:
        events: The script, its times counted from 0 s.
        near: Times that differ by no more than this are one time [s].
        last: Time from which ends of actions count as after the run [s].
    """

    def __init__(self, events: Sequence[ScheduledAction], near: float, last: float = np.inf):
        self._near, self._last = near, last
        self._written = sorted({event.time for event in events})
        self._rows: list[tuple[float, int, int, Action | None]] = []
        self._entered = 0
        self.script(events, 0.0)

    def add(self, time: float, action: Action) -> None:
        """Enter an action at a time [s]."""
        if time < self._last - self._near:
            self._enter(time, _ENTERED, action)

    def land(self, times: Floats) -> None:
        """Enter times at which a derivative jumps [s]."""
        for time in times:
            self._enter(float(time), _ENTERED, None)

    def end(self, ended: LoggedEvent) -> None:
        """Ignore what ends the run: a reference lasts as long as it is asked for."""

    def script(self, events: Sequence[ScheduledAction], start: float) -> None:
        """Enter written events, counted from a start [s]."""
        for event in events:
            self._enter(start + event.time, _WRITTEN, event.action)

    @property
    def next(self) -> float:
        """Return the time of what comes next [s]; infinite if nothing does."""
        return self._rows[0][0] if self._rows else float("inf")

    def due(self, time: float) -> Iterator[Action]:
        """Take out and yield what is due at a time [s], also what is entered meanwhile."""
        while self._rows and self._rows[0][0] <= time + self._near:
            action = self._rows.pop(0)[3]
            if action is not None:
                yield action

    def _enter(self, time: float, rank: int, action: Action | None) -> None:
        # A written time that is nearly the same is meant, such as 3 * 0.1 s and 0.3 s.
        time = next((t for t in self._written if abs(t - time) <= self._near), time)
        self._rows.append((time, rank, self._entered, action))
        self._rows.sort(key=lambda row: row[:3])
        self._entered += 1
