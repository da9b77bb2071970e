"""Progress lines; that of a run: simulated time, speed against real time, time left."""

import sys
import time as clock
from collections.abc import Callable
from shutil import get_terminal_size
from threading import Event, Thread
from typing import Self

from tissuec.core.data import printable
from tissuec.core.units import TIME, show

FIRST_AFTER = 0.5  # [s]: short runs need no progress
EVERY = 0.2  # [s]
LOGGED_EVERY = 30.0  # [s]: whole lines in a file
SILENCE = 1.0  # [s]: a run that steps reports its time more often than that
LOADER = "tissuec.compiled.loading"  # which translates what is shipped, the first time
WIDTH = 24


class ProgressLine:
    """A line on stderr that is rewritten; off a terminal nothing, or a new line now and then.

    Args:
        meanwhile: Returns the task under way while nothing else is reported, "" for none.
        anywhere: Whether it is also shown off a terminal, such as in a notebook.
        logged: Whether new lines are written off a terminal, such as to a file.
    """

    def __init__(
        self,
        name: str,
        *,
        shown: bool,
        meanwhile: Callable[[], str] | None = None,
        anywhere: bool = False,
        logged: bool = False,
    ):
        self.name = printable(name)
        self.is_terminal = sys.stderr.isatty()
        self.is_logged = logged and not (anywhere or self.is_terminal)
        self.shown = shown and (anywhere or self.is_terminal or self.is_logged)
        self.widest = 0
        self.next = clock.monotonic() + (LOGGED_EVERY if self.is_logged else FIRST_AFTER)
        self.written = False
        self.heard = clock.monotonic()
        self.ended = Event()
        self.meanwhile = meanwhile
        self.watch = Thread(target=self._watch, daemon=True) if meanwhile else None

    def show(self, line: Callable[[float], str]) -> None:
        """Show a line, if it is time to.

        Args:
            line: What to show, made only then, at a time of the clock [s].
        """
        now = clock.monotonic()
        self.heard = now
        if not self.shown or now < self.next:
            return
        if self.is_logged:
            self.next = now + LOGGED_EVERY
            sys.stderr.write(f"{line(now)}\n")
            sys.stderr.flush()
            return
        self.next = now + EVERY
        self._write(line(now))

    def _watch(self) -> None:
        """Show the task under way while nothing else is reported."""
        assert self.meanwhile is not None
        while not self.ended.wait(EVERY):
            if clock.monotonic() - self.heard > SILENCE and (what := self.meanwhile()):
                self._write(f"{self.name}: {what} …")

    def _write(self, line: str) -> None:
        if self.is_terminal:
            # A line that wraps cannot be cleared; the essential part is at its end.
            excess = len(line) - (get_terminal_size().columns - 1)
            line = f"…{line[excess + 1 :]}" if excess > 0 else line
        self.written = True
        self._clear()
        sys.stderr.write(line)
        sys.stderr.flush()
        self.widest = max(self.widest, len(line))

    def _clear(self) -> None:
        """Clear the line; off a terminal there are only blanks to do it with."""
        blank = "\x1b[2K" if self.is_terminal else f"{'':{self.widest}}\r"
        sys.stderr.write(f"\r{blank}")

    def __enter__(self) -> Self:
        if self.shown and self.watch is not None:
            self.watch.start()
        return self

    def __exit__(self, *failure: object) -> None:
        self.ended.set()
        if self.shown and self.watch is not None:
            self.watch.join()
        if self.written:
            self._clear()
            sys.stderr.flush()


def compiling(name: str, *, shown: bool) -> ProgressLine:
    """Return the line that is shown while a large scene is compiled."""
    return ProgressLine(name, shown=shown, meanwhile=lambda: "compiling the scene")


class RunProgress(ProgressLine):
    """The line of a run: how far it has come, how fast it goes, and how long it takes yet.

    Args:
        duration: Of the run [s].
        compiles: Whether kernels may have to be compiled, or much be prepared.
    """

    def __init__(
        self,
        name: str,
        duration: float,
        *,
        shown: bool,
        compiles: bool = True,
        anywhere: bool = False,
    ):
        meanwhile = self._beside_steps if compiles else None
        super().__init__(name, shown=shown, meanwhile=meanwhile, anywhere=anywhere)
        self.duration = duration
        self.first: tuple[float, float] | None = None
        self.is_done = False

    def _beside_steps(self) -> str:
        """Return the task under way while no time is reported, "" for none."""
        if getattr(sys.modules.get(LOADER), "translating", False):
            return "compiling kernels"
        if self.is_done:
            return "simulated; checking the accuracy and writing the result"
        return "preparing" if self.first is None else ""

    def at(self, time: float) -> None:
        """Show a simulated time [s], if it is time to."""
        if self.first is None:
            self.first = (clock.monotonic(), time)
        self.is_done = time >= self.duration
        self.show(lambda now: self._line(now, time))

    def _line(self, now: float, time: float) -> str:
        assert self.first is not None
        part = time / self.duration
        bar = "#" * round(part * WIDTH)
        speed = (time - self.first[1]) / max(now - self.first[0], 1e-9)
        left = f", {minutes((self.duration - time) / speed)} left" if speed > 0.0 else ""
        done = f"{show(time, TIME)} of {show(self.duration, TIME)}"
        # Narrow terminals cut the beginning: the time follows the speed.
        return f"{self.name} [{bar:<{WIDTH}}] {speed:.2g} x real time, {done}{left}"


def minutes(seconds: float) -> str:
    """Return a time that is left, in a unit that suits it."""
    if seconds < 60.0:
        return f"{seconds:.0f} s"
    if seconds < 3600.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"
