"""Results for other programs: tables as CSV, frames and smooth surfaces as shapes."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from math import ulp
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from tissuec.core.files import replacing
from tissuec.core.hints import alternatives
from tissuec.core.scale import AxisUnit
from tissuec.model.network import Floats
from tissuec.results import ResultError
from tissuec.results.fields import Place
from tissuec.results.frame_columns import MOTION, POINTS
from tissuec.results.hdf5 import open_file
from tissuec.results.mesh import CellGrid
from tissuec.results.recording import Event
from tissuec.results.shapes import (
    ExportedShape,
    cannot_write,
    net_shape,
)
from tissuec.results.store import LIBVER
from tissuec.results.surface_table import SurfaceSeries
from tissuec.results.tables import Log
from tissuec.results.trajectory import Trajectory

WRITTEN = 12  # significant digits of times that scenes say
ROUNDING = 1e-12  # of the largest number of a log: below are rounding errors

ELEMENT = "element-"  # before the number of one that broke
_OF_EVENTS = ("kind", "springs", "cause", "place")


def write_csv(rows: Iterable[Sequence[object]], stream: TextIO) -> None:
    """Write rows as comma-separated values."""
    csv.writer(stream, lineterminator="\n").writerows(rows)


def table_rows(
    trajectory: Trajectory, names: str | Sequence[str]
) -> Iterable[Sequence[object]]:
    """Return logs, "energies" or "events" as the rows of one table, its head first.

    Logs of different times share one table, with empty fields where one has no row. Numbers
    are in the units of axes, which stand in the head, and have as many digits as it takes to
    read back the same ones, unless they are rounding errors, which are 0; for times, see
    ``without_rounding``.

    Args:
        trajectory: Where from.
        names: One name or several; "events" stands alone.

    Raises:
        ResultError: There is no such log.
    """
    names = [names] if isinstance(names, str) else list(names)
    if names == ["events"] and "events" not in trajectory.logs:
        return _event_rows(trajectory)
    logs = [find_log(trajectory, name) for name in names]
    head = [_head("time", trajectory.clock), *(head for log in logs for head in _heads(log))]
    return chain([head], _joined_rows(logs, trajectory.clock))


def table_names(trajectory: Trajectory) -> list[str]:
    """Return the names of all tables that hold something."""
    energies = ["energies"] if trajectory.energies is not None else []
    return [*trajectory.logs, *energies, *(["events"] if trajectory.events else [])]


def table_data(trajectory: Trajectory, names: Sequence[str]) -> dict[str, Any]:
    """Return tables by name, as plain data for programs.

    Raises:
        ResultError: There is no such log.
    """
    return {name: _plain_table(trajectory, name) for name in names}


def _plain_table(trajectory: Trajectory, name: str) -> Any:
    if name == "events" and "events" not in trajectory.logs:
        rows = [(event.time, *event_facts(trajectory, event)) for event in trajectory.events]
        return [dict(zip(("time", *_OF_EVENTS), row, strict=True)) for row in rows]
    log = find_log(trajectory, name)
    return {
        "columns": list(log.columns),
        "unit": log.unit,
        "time": log.time.tolist(),
        "value": log.value.tolist(),
    }


def frame_shape(trajectory: Trajectory, frame: int) -> ExportedShape:
    """Return the net in one frame; IndexError if there is no such frame."""
    drawing = trajectory.drawing(frame)
    points: dict[str, NDArray[Any]] = {}
    own: dict[str, tuple[Place, NDArray[Any]]] = {}
    for channel in (*MOTION, *trajectory.channels):
        if channel.at in POINTS:
            points[channel.stored] = trajectory.at_points(channel, frame)
        else:
            own[channel.stored] = channel.at, trajectory.fields[channel.name][frame]
    points["node_id"] = drawing.node_ids
    return net_shape(trajectory.path.name, trajectory.times[frame], drawing, points, own)


def surface_shape(series: SurfaceSeries, frame: int) -> ExportedShape:
    """Return a smooth surface in one frame; IndexError if there is no such frame."""
    triangles = series.triangles(frame)
    return ExportedShape(
        f"surface of {series.name}", series.times[frame], series.position(frame),
        CellGrid.of_triangles(triangles), triangles, {}, {},
    )  # fmt: skip


def export_surface(series: SurfaceSeries, path: Path) -> None:
    """Write all frames of a smooth surface as a file of their own for ParaView.

    Raises:
        ResultError: The file cannot be written.
    """
    try:
        with replacing(path) as beside, open_file(beside, "w", libver=LIBVER) as file:
            series.copy_to(file, "VTKHDF")
    except OSError as error:
        raise cannot_write(path, error) from error


def find_log(trajectory: Trajectory, name: str) -> Log:
    """Return a log, or "energies", by its name.

    Raises:
        ResultError: There is no such log.
    """
    if name in trajectory.logs:
        return trajectory.logs[name]
    if name == "energies" and trajectory.energies is not None:
        return trajectory.energies
    if name == "events":
        raise ResultError('"events" is a separate table; export it alone')
    if any(channel.name == name for channel in trajectory.channels):
        raise ResultError(
            f'"{name}" is a field of the frames of "{trajectory.path}": open the file in '
            "ParaView, or read Trajectory.fields in Python"
        )
    hint = alternatives(name, table_names(trajectory), what="there are")
    raise ResultError(f'"{trajectory.path}" has no log "{name}" to export; {hint}')


def _heads(log: Log) -> list[str]:
    scale = log.scale
    return [_head(f"{log.name} {column}", scale) for column in log.columns]


def _head(name: str, scale: AxisUnit) -> str:
    return f"{name} [{scale.spelled}]" if scale.spelled else name


def _joined_rows(logs: Sequence[Log], clock: AxisUnit) -> Iterable[Sequence[object]]:
    """Return one row per moment of any log; a moment that a log has twice stands there twice.

    Args:
        clock: Unit of the times.
    """
    moments, places = _joined_moments([log.time for log in logs])
    columns: list[Sequence[object]] = []
    for log, place in zip(logs, places, strict=True):
        value, least = log.value, ROUNDING * log.largest
        for values in np.where(np.abs(value) < least, 0.0, value).T:
            numbers: Sequence[object] = log.scale.exactly(values.tolist())
            if place is not None:
                column: list[object] = [""] * len(moments)
                for row, number in zip(place, numbers, strict=True):
                    column[row] = number
                numbers = column
            columns.append(numbers)
    times = map(without_rounding, moments.tolist())
    return zip(clock.exactly(times), *columns, strict=True)


def _joined_moments(times: Sequence[Floats]) -> tuple[Floats, list[list[int] | None]]:
    """Return the moments of all logs [s], shape (moment,), and the rows of each log among them.

    None stands for all of them in this order, as usually for all logs.

    Args:
        times: Of each log [s], shape (moment,).
    """
    first, *others = times
    if (np.diff(first) > 0.0).all() and all(np.array_equal(first, one) for one in others):
        return first, [None] * len(times)
    keys = [moments_of(one) for one in times]
    moments, place = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    ends = np.cumsum([len(key) for key in keys])
    parts = np.split(place.reshape(-1), ends[:-1])
    return moments[:, 0], [part.tolist() for part in parts]


def without_rounding(time: float) -> float:
    """Return the short decimal that a time was computed for, or the time itself.

    Multiples of an interval differ from their decimals by rounding: 3 * 0.1 s is
    0.30000000000000004 s. Decimals of at most ``WRITTEN`` digits within two units in the last
    place are taken for what a scene says; other times, such as those of ruptures, keep all
    digits.

    Args:
        time: [s].
    """
    short = float(f"{time:.{WRITTEN}g}")
    return short if abs(short - time) <= 2.0 * ulp(time) else time


def moments_of(time: Floats) -> Floats:
    """Return each time with the number of equal times before it.

    Args:
        time: Times [s], shape (moment,).

    Returns:
        Times [s] and numbers, shape (moment, 2).
    """
    order = np.argsort(time, kind="stable")
    ordered = time[order]
    again = np.empty(len(time))
    again[order] = np.arange(len(time)) - np.searchsorted(ordered, ordered)
    return np.column_stack([time, again])


def _event_rows(trajectory: Trajectory) -> Iterator[list[Any]]:
    clock, events = trajectory.clock, trajectory.events
    yield [_head("time", clock), *_OF_EVENTS]
    times = (without_rounding(one.time) for one in events)
    for time, event in zip(clock.exactly(times), events, strict=True):
        yield [time, *event_facts(trajectory, event)]


def event_facts(trajectory: Trajectory, event: Event) -> tuple[str, str, str, str]:
    """Return the kind of an event, the ids of its springs, its cause and its place."""
    springs = " ".join(names_of(trajectory, event))
    return event.kind, springs, event.cause, event.place


def names_of(trajectory: Trajectory, event: Event) -> tuple[str, ...]:
    """Return the ids of the springs of an event, or of the elements that broke in it."""
    elements = [one for one in event.springs if one >= trajectory.network.line_count]
    return tuple(spring_name(trajectory, number) for number in elements or event.springs)


def spring_name(trajectory: Trajectory, number: int) -> str:
    """Return the id of a spring, with its body where there are several that count their own.

    Of an element, it is its number.
    """
    network = trajectory.network
    identity = str(network.number_of(number))
    if number >= network.line_count:
        identity = f"{ELEMENT}{identity}"
    if len(network.parts) < 2:
        return identity
    return f"{network.owner(number).name}:{identity}"
