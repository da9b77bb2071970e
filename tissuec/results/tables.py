"""Rows that come in time: logs, energies and events."""

from collections.abc import Sequence
from functools import partial
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike

from tissuec.core.errors import counted
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.recording import ENERGIES, Event, LogChannel
from tissuec.results.store import CHUNK, FEW, TEXT, Store, member_name

LOGS = "/tissuec/logs"
EVENTS = "/tissuec/events"
JUMPS = "jumps"
ENERGY_PATH = "/tissuec/energies"
ERROR_PATH = "/tissuec/errors"
COMPANION_PATH = "/tissuec/companion"


class LogTable:
    """One logged quantity: the datasets ``time``, ``value`` and ``columns`` of a group."""

    def __init__(self, store: Store, path: str, channel: LogChannel, *, number: int = 0):
        self.channel = channel
        self._store = store
        width = len(channel.columns)
        self._time = store.column(
            f"{path}/time", "f8", f"times of: {channel.description}", unit="s"
        )
        self._value = store.column(
            f"{path}/value",
            "f8",
            channel.description,
            unit=channel.unit,
            row=(width,),
            chunk=rows_of_a_chunk(width),
        )
        if f"{path}/columns" not in store:
            group = store.group(path)
            group.attrs["name"] = channel.name
            group.attrs["number"] = number  # the place in the scene's order
            text = f"what the columns of value are: {channel.description}"
            if all(isinstance(column, Integral) for column in channel.columns):
                ids = np.array(channel.columns, dtype="i8")
                store.array(f"{path}/columns", ids, text)
            else:
                store.texts(f"{path}/columns", list(map(str, channel.columns)), text)

    def append(self, time: ArrayLike, rows: ArrayLike) -> None:
        """Add rows of shape (moment, column) at ``time`` [s], shape (moment,).

        Raises:
            ValueError: The rows have another shape.
        """
        time, rows = np.atleast_1d(np.asarray(time, float)), np.asarray(rows, float)
        if rows.shape != (len(time), len(self.channel.columns)):
            raise ValueError(
                f'log "{self.channel.name}" takes rows of shape '
                f"{(len(time), len(self.channel.columns))}, not {rows.shape}"
            )
        self._store.append({self._time: time, self._value: rows})


class JumpTable:
    """Jumps of a log at events: the datasets ``time``, ``before`` and ``after`` of a group.

    Args:
        path: Of the log.
    """

    def __init__(self, store: Store, path: str, channel: LogChannel):
        self._store = store
        self._width = width = len(channel.columns)
        what, chunk = channel.description, min(FEW, rows_of_a_chunk(width))
        column = partial(store.column, chunk=chunk)
        self._time = column(
            f"{path}/{JUMPS}/time", "f8", f"times of events that changed: {what}", unit="s"
        )
        self._before, self._after = (
            column(
                f"{path}/{JUMPS}/{side}", "f8", f"just {side} each event: {what}",
                unit=channel.unit, row=(width,),
            )
            for side in ("before", "after")
        )  # fmt: skip

    def append(self, time: float, before: ArrayLike, after: ArrayLike) -> None:
        """Add the rows on both sides of an event.

        Args:
            time: Time of the event [s].
            before: The row before it in the units of the log, shape (column,).
            after: The row after it, shape (column,).

        Raises:
            ValueError: A row has another shape.
        """
        sides = np.asarray(before, float), np.asarray(after, float)
        if any(side.shape != (self._width,) for side in sides):
            raise ValueError(f"a jump has two rows of {counted(self._width, 'number')}")
        self._store.append(
            {self._time: [time], self._before: sides[0][None], self._after: sides[1][None]}
        )


class EventTable:
    """Events: one row per event in columns, and all their springs in a list."""

    def __init__(self, store: Store):
        self._store = store
        column = partial(store.column, chunk=FEW)
        self._time = column(f"{EVENTS}/time", "f8", "time of each event", unit="s")
        self._texts = {
            "kind": column(f"{EVENTS}/kind", TEXT, "what happened: cut, rupture, grasp, …"),
            "cause": column(f"{EVENTS}/cause", TEXT, "why it happened"),
            "place": column(
                f"{EVENTS}/place", TEXT, "file:line of the sentence that caused it"
            ),
        }
        self._first = column(
            f"{EVENTS}/first_spring", "i8", "where its springs begin in springs"
        )
        self._count = column(f"{EVENTS}/spring_count", "i8", "how many springs it concerns")
        self._springs = store.column(
            f"{EVENTS}/springs", "i8", "network numbers of the springs of all events"
        )

    def append(self, event: Event) -> None:
        """Add one event."""
        rows = {self._texts[name]: [getattr(event, name)] for name in self._texts}
        self._store.append(
            rows
            | {
                self._time: [event.time],
                self._first: [self._springs.rows],
                self._count: [len(event.springs)],
                self._springs: event.springs,
            }
        )


def rows_of_a_chunk(width: int) -> int:
    """Return how many rows of a log are allocated at once."""
    return min(CHUNK, max(1, 1024 // max(1, width)))


def log_tables(store: Store, channels: Sequence[LogChannel]) -> dict[str, LogTable]:
    """Return the tables of all logs by name."""
    return {
        channel.name: LogTable(
            store, f"{LOGS}/{member_name(channel.name)}", channel, number=number
        )
        for number, channel in enumerate(channels)
    }


def jump_tables(store: Store, channels: Sequence[LogChannel]) -> dict[str, JumpTable]:
    """Return the tables of jumps of logs by name; those that are too wide have none."""
    return {
        channel.name: JumpTable(store, f"{LOGS}/{member_name(channel.name)}", channel)
        for channel in channels
        if channel.has_jumps
    }


def energy_tables(store: Store) -> tuple[LogTable, JumpTable]:
    """Return the table of energies, and that of their jumps."""
    channel = LogChannel("energies", ENERGIES, "J", "energies of the scene over time")
    return LogTable(store, ENERGY_PATH, channel), JumpTable(store, ENERGY_PATH, channel)


def error_table(store: Store) -> LogTable:
    """Return the table of estimated errors in frames."""
    text = "error of positions as estimated from step to step"
    return LogTable(store, ERROR_PATH, LogChannel("errors", ("steps",), "m", text))


def companion_table(store: Store) -> LogTable:
    """Return the table of distances from the companion run."""
    text = "largest distance of a node from where it is in a run with smaller steps"
    return LogTable(store, COMPANION_PATH, LogChannel("companion", ("distance",), "m", text))


def read_channels(file: ResultGroup) -> dict[str, str]:
    """Return the path of every log by its name, in the order of the scene."""
    if LOGS not in file:
        return {}
    logs = access.groups(access.group(file, LOGS))
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
    group = access.group(file, EVENTS)
    springs = access.array(group, "springs").tolist()
    names = ("time", "first_spring", "spring_count")
    numbers = [access.array(group, name).tolist() for name in names]
    words = [access.texts(group, name) for name in ("kind", "cause", "place")]
    return tuple(
        Event(time, kind, tuple(springs[first : first + count]), cause, place)
        for time, first, count, kind, cause, place in zip(*numbers, *words, strict=True)
    )
