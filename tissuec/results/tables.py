"""Rows that come in time: logs, energies and events, written and read."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tissuec.core.errors import counted
from tissuec.core.scale import AxisUnit, largest_of, scale_of
from tissuec.model.network import Floats
from tissuec.results import access
from tissuec.results.access import Contents, ResultGroup
from tissuec.results.datasets import CHUNK, FEW, TEXT, DatasetSpec, GroupSpec
from tissuec.results.recording import AXES, ENERGIES, Event, LogChannel
from tissuec.results.schema import EVENTS, LOGS
from tissuec.results.store import ColumnTable, Store, member_name

ENERGY = LogChannel("energies", ENERGIES, "J", "energies of the scene over time")
ERROR = LogChannel(
    "errors", ("steps",), "m", "error of positions as estimated from step to step"
)
DISTANCE = LogChannel(
    "companion",
    ("distance",),
    "m",
    "largest distance of a node from where it is in a run with smaller steps",
)


class LogTable:
    """One logged quantity over time, and its jumps at events.

    Args:
        store: The file.
        group: Of which the log is one.
        channel: The quantity.
        number: Its place in the scene's order.
    """

    def __init__(self, store: Store, group: GroupSpec, channel: LogChannel, number: int = 0):
        self.channel = channel
        self._shape = (len(channel.columns),)
        datasets = datasets_of(group, channel)
        columns = datasets.pop("columns")
        self._table = ColumnTable(store, datasets)
        if columns.path not in store:
            attributes = store.group(columns.path.rpartition("/")[0]).attrs
            attributes["name"], attributes["number"] = channel.name, number
            are_ids = all(isinstance(column, Integral) for column in channel.columns)
            names = channel.columns if are_ids else list(map(str, channel.columns))
            store.array(columns.of(kind="i8" if are_ids else TEXT), names)

    def append(self, time: ArrayLike, rows: ArrayLike) -> None:
        """Add rows of shape (moment, column) at ``time`` [s], shape (moment,).

        Raises:
            ValueError: The rows have another shape.
        """
        time, rows = np.atleast_1d(np.asarray(time, float)), np.asarray(rows, float)
        if rows.shape != (len(time), *self._shape):
            raise ValueError(
                f'log "{self.channel.name}" takes rows of shape '
                f"{(len(time), *self._shape)}, not {rows.shape}"
            )
        self._table.append({"time": time, "value": rows})

    def jump(self, time: float, before: ArrayLike, after: ArrayLike) -> None:
        """Add the rows on both sides of an event.

        Args:
            time: Time of the event [s].
            before: The row before it in the units of the log, shape (column,).
            after: The row after it, shape (column,).

        Raises:
            ValueError: A row has another shape, or the log is too wide for jumps.
        """
        if "jumps/time" not in self._table:
            raise ValueError(f'no jumps are recorded of "{self.channel.name}"')
        sides = np.asarray(before, float), np.asarray(after, float)
        if any(side.shape != self._shape for side in sides):
            raise ValueError(f"a jump has two rows of {counted(*self._shape, 'number')}")
        rows = {"before": sides[0][None], "after": sides[1][None], "time": [time]}
        self._table.append({f"jumps/{name}": row for name, row in rows.items()})


class EventTable:
    """Events: one row per event in columns, and all their springs in a list."""

    def __init__(self, store: Store):
        self._table = ColumnTable(store, EVENTS)

    def append(self, event: Event) -> None:
        """Add one event."""
        rows: dict[str, Any] = {name: [getattr(event, name)] for name in _WORDS}
        first = self._table["springs"].rows
        rows |= {"time": [event.time], "first_spring": [first], "springs": event.springs}
        self._table.append(rows | {"spring_count": [len(event.springs)]})


_WORDS = ("kind", "cause", "place")


def datasets_of(group: GroupSpec, channel: LogChannel) -> dict[str, DatasetSpec]:
    """Return the datasets of a log, with the rows that are allocated at once.

    Args:
        group: Of which the log is one.
        channel: What it logs; one of very many columns has no jumps.
    """
    width = len(channel.columns)
    rows = min(CHUNK, max(1, 1024 // max(1, width)))
    log, what, unit = member_name(channel.name), channel.description, channel.unit
    found = {
        name: one.of(
            row=(width,) if "column" in one.axes[1:] else None, log=log, what=what, unit=unit
        )
        for name, one in group.items()
        if channel.has_jumps or not name.startswith("jumps/")
    }
    chunks = {name: min(FEW, rows) for name in found if name.startswith("jumps/")}
    chunks["value"] = rows
    return found | {name: found[name].of(chunk=chunk) for name, chunk in chunks.items()}


def log_tables(store: Store, channels: Sequence[LogChannel]) -> dict[str, LogTable]:
    """Return the tables of all logs by name."""
    return {one.name: LogTable(store, LOGS, one, place) for place, one in enumerate(channels)}


def read_channels(file: ResultGroup) -> dict[str, str]:
    """Return the path of every log by its name, in the order of the scene."""
    path = LOGS.path.rpartition("/")[0]
    logs = access.groups(access.group(file, path)) if path in file else []
    return {access.attribute(group, "name", str): group.path for group in logs}


def read_channel(file: ResultGroup, path: str) -> LogChannel:
    """Return the description of the log at ``path``."""
    group = access.group(file, path)
    value, columns = access.dataset(group, "value"), access.dataset(group, "columns")
    are_ids = columns.dtype.kind == "i"
    names = columns.whole().tolist() if are_ids else access.texts(group, "columns")
    return LogChannel(
        access.attribute(group, "name", str),
        tuple(names),
        access.attribute(value, "unit", str),
        access.attribute(value, "description", str),
    )


def read_events(file: ResultGroup) -> tuple[Event, ...]:
    """Return all events, in the order in which they were written."""
    found = Contents(file, EVENTS)
    springs = found["springs"].tolist()
    return tuple(
        Event(time, kind, tuple(springs[first : first + count]), cause, place)
        for time, kind, first, count, cause, place in found.rows(
            "time", "kind", "first_spring", "spring_count", "cause", "place"
        )
    )


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
