"""The progress line of a run: simulated time, speed against real time, time left."""

import sys
import time as clock
from types import TracebackType
from typing import Self

from tissuec.core.units import TIME, show

FIRST_AFTER = 0.5  # [s]: short runs need no progress
EVERY = 0.2  # [s]
WIDTH = 24


class Progress:
    """A line on stderr that is rewritten; nothing at all off a terminal."""

    def __init__(self, name: str, duration: float, *, shown: bool):
        self.name = name
        self.duration = duration
        self.shown = shown and sys.stderr.isatty()
        self.started = clock.monotonic()
        self.next = self.started + FIRST_AFTER
        self.first: tuple[float, float] | None = None
        self.written = False

    def at(self, time: float) -> None:
        """Show a simulated time [s], if it is time to."""
        now = clock.monotonic()
        if self.first is None:
            self.first = (now, time)
        if not self.shown or now < self.next:
            return
        self.next = now + EVERY
        self.written = True
        sys.stderr.write(f"\r\x1b[2K{self._line(now, time)}")
        sys.stderr.flush()

    def _line(self, now: float, time: float) -> str:
        assert self.first is not None
        part = time / self.duration
        bar = "#" * round(part * WIDTH)
        speed = (time - self.first[1]) / max(now - self.first[0], 1e-9)
        left = f", {_minutes((self.duration - time) / speed)} left" if speed > 0.0 else ""
        done = f"{show(time, TIME)} of {show(self.duration, TIME)}"
        return f"{self.name} [{bar:<{WIDTH}}] {done}, {speed:.2g} x real time{left}"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.written:
            sys.stderr.write("\r\x1b[2K")
            sys.stderr.flush()


def _minutes(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.0f} s"
    if seconds < 3600.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"
