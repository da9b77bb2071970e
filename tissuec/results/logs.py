"""Logged quantities of a result file."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.scale import AxisUnit, largest_of, scale_of
from tissuec.model.network import Floats
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.recording import AXES
from tissuec.results.tables import read_channel, read_channels

MOST_NAMED = 6  # columns
_FROM_ITS_LOWEST = "gravity"  # energy, whose zero is where the net was drawn


class Jumps(NamedTuple):
    """Jumps of a log at events.

    Attributes:
        time: When [s], ascending, shape (jump,).
        before: The row just before each event [unit of the log], shape (jump, column).
        after: The row just after it, shape (jump, column).
    """

    time: Floats
    before: Floats
    after: Floats

    def within(self, time: Floats, value: Floats) -> tuple[Floats, Floats]:
        """Return the rows of a log with the two rows of each event inserted in order of time.

        Args:
            time: Times of the log [s], shape (moment,).
            value: Its rows in the unit of the log, shape (moment, column).

        Returns:
            Times and rows, with two more for each event.
        """
        places = np.repeat(np.searchsorted(time, self.time), 2)
        sides = np.stack([self.before, self.after], axis=1).reshape(-1, value.shape[1])
        times = np.insert(time, places, np.repeat(self.time, 2))
        return times, np.insert(value, places, sides, axis=0)


class Log:
    """A logged quantity.

    Attributes:
        name: What the scene calls it.
        columns: What the numbers of a row are: axes or ids.
        unit: Their unit.
        description: One sentence.
    """

    def __init__(self, file: ResultGroup, path: str):
        channel = read_channel(file, path)
        self.name, self.columns = channel.name, channel.columns
        self.unit, self.description = channel.unit, channel.description
        self._group = access.group(file, path)

    @cached_property
    def time(self) -> Floats:
        """Return the moments [s], shape (moment,)."""
        return access.array(self._group, "time")

    @cached_property
    def value(self) -> Floats:
        """Return the rows in the unit of the log, shape (moment, column)."""
        return access.array(self._group, "value")

    @cached_property
    def jumps(self) -> Jumps:
        """Both sides of each event that changed this log; none in files of earlier versions.

        `time` and `value` are not changed by them: at the time of an event they hold what is
        after it.
        """
        if "jumps" not in self._group:
            none = np.zeros((0, len(self.columns)))
            return Jumps(np.zeros(0), none, none)
        group = access.group(self._group, "jumps")
        return Jumps(*(access.array(group, name) for name in Jumps._fields))

    def with_jumps(self) -> tuple[Floats, Floats]:
        """Return the log as a line that is vertical at events.

        Returns:
            Times [s], ascending, shape (point,), and rows [unit], shape (point, column): those
            of the log and, before what it has at the time of an event, both sides of it.
        """
        return self.jumps.within(self.time, self.value)

    @cached_property
    def largest(self) -> float:
        """Return the largest magnitude [unit of the log]: of vectors, of their length."""
        _, rows = self.with_jumps()
        if self.columns == AXES:
            return largest_of([np.linalg.norm(rows, axis=1)])
        known = rows[:, [column != _FROM_ITS_LOWEST for column in self.columns]]
        if known.shape == rows.shape or not len(rows):
            return largest_of([rows])
        return largest_of([known, np.ptp(rows[:, self.columns.index(_FROM_ITS_LOWEST)])])

    @property
    def scale(self) -> AxisUnit:
        """Return the unit that it has on axes, in tables of pages and in CSV."""
        return scale_of(self.unit, [self.largest])

    def __repr__(self) -> str:
        columns = ", ".join(map(str, self.columns[:MOST_NAMED]))
        more = ", …" if len(self.columns) > MOST_NAMED else ""
        size = counted(len(access.dataset(self._group, "time")), "moment")
        return f'<log "{self.name}" [{self.unit}]: {size} of {columns}{more}>'


class Logs(Mapping[str, Log]):
    """All logs of a file by name, in the order of the scene."""

    def __init__(self, file: ResultGroup):
        self._file = file
        self._paths = read_channels(file)

    def __getitem__(self, name: str) -> Log:
        return Log(self._file, self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)

    def __repr__(self) -> str:
        return "\n".join(map(repr, self.values())) or "<no logs>"
