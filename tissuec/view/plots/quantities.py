"""Logged quantities of runs by the words that choose them: components, displacements, …"""

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError, counted
from tissuec.core.hints import alternatives
from tissuec.core.scale import AxisUnit, largest_of, scale_of
from tissuec.core.structs import replace
from tissuec.core.units import TIME as SECONDS
from tissuec.core.units import show
from tissuec.mechanics.deformation import von_mises
from tissuec.model.network import Floats
from tissuec.results.recording import AXES, TENSOR
from tissuec.view.plots.logs import is_place, log_called
from tissuec.view.plots.over_time import Window

if TYPE_CHECKING:
    from tissuec.results.trajectory import Log, Trajectory

TIME = "time"
#: "magnitude of LOG", "LOG along z"
_PART = re.compile(r"(?:(?P<magnitude>magnitude) of )?(?P<name>.+?)(?: along (?P<axis>[xyz]))?")
WAY, PLACE = "displacement of ", "position of "
QUANTITY = '"time", a log, "LOG along z", "magnitude of LOG", or "displacement of SET along z"'


class LoggedQuantity(Struct, frozen=True, eq=False):
    """A number over time.

    Attributes:
        name: Text at its axis.
        unit: Of its values, as files spell it.
        largest: Magnitude of the whole quantity, of which this may be a component or a part.
        time: [s], ascending, shape (moment,); two equal ones are both sides of an event.
        value: Shape (moment,).
    """

    name: str
    unit: str
    largest: float
    time: Floats
    value: Floats

    def within(self, window: Window) -> Self:
        """Return the part of a window of time.

        Raises:
            TissueError: No time is shown.
        """
        rows = window.rows(self.time, f'"{self.name}"')
        return replace(self, time=self.time[rows], value=self.value[rows])


def behind_events(log: LoggedQuantity) -> tuple[Floats, Floats]:
    """Return times and values, of both sides of an event what is after it.

    Returns:
        Times [s] and values, shape (moment,) each.
    """
    last = np.append(np.diff(log.time) > 0.0, True)
    return log.time[last], log.value[last]


def unit_of(quantities: Iterable[LoggedQuantity]) -> AxisUnit:
    """Return the unit of one quantity in several runs."""
    found = list(quantities)
    return scale_of(found[0].unit, [one.largest for one in found])


def quantity(run: "Trajectory", wanted: str, zero: float | None = None) -> LoggedQuantity:
    """Return a quantity of a run over time.

    Args:
        run: The result.
        wanted: "time", the name of a log, "LOG along z", "magnitude of LOG", "displacement of
            SET along z".
        zero: From which time displacements and times are measured [s].

    Raises:
        TissueError: There is no such log, or it has several values.
    """
    if wanted.lower() == TIME:
        times = [log.with_jumps()[0] for log in run.logs.values()]
        longest = max(times, key=len, default=np.zeros(0))
        if zero is None:
            return LoggedQuantity(TIME, "s", run.last_time, longest, longest)
        name = f"{TIME} after {show(zero, SECONDS)}"
        return LoggedQuantity(name, "s", run.last_time, longest, longest - zero)
    log, matched = _log(run, wanted), _PART.fullmatch(wanted)
    assert matched is not None
    axis, is_displacement = None, False
    if log is None:
        axis, name = matched["axis"], matched["name"]
        is_displacement = name.lower().startswith(WAY)
        log = _log(run, PLACE + name[len(WAY) :] if is_displacement else name)
    if log is None:
        raise TissueError(f'there is no quantity "{wanted}"; {logs_of(run, wanted)}')
    time, value = log.with_jumps()
    largest = log.largest
    if is_displacement:
        value = value - value[_row_at(time, zero, wanted)]
        largest = largest_of([np.linalg.norm(value, axis=1)])
    if len(log.columns) == 1:
        return LoggedQuantity(wanted, log.unit, largest, time, value[:, 0])
    if axis and log.columns == TENSOR:
        return LoggedQuantity(wanted, log.unit, largest, time, value[:, AXES.index(axis)])
    if log.columns == TENSOR:
        name = f"von Mises {wanted}"
        return LoggedQuantity(name, log.unit, largest, time, von_mises(value))
    if log.columns != AXES:
        raise TissueError(
            f'"{log.name}" has {counted(len(log.columns), "value")} at each time; an axis '
            "needs one: log it of a single spring"
        )
    if axis:
        return LoggedQuantity(wanted, log.unit, largest, time, value[:, AXES.index(axis)])
    if is_place(log.name) and not is_displacement:
        raise TissueError(
            f'"{log.name}" has three components; write "{log.name} along z", or '
            f'"{WAY}{log.name.removeprefix(PLACE)}" for the distance from the beginning'
        )
    name = wanted if matched["magnitude"] else f"magnitude of {wanted}"
    return LoggedQuantity(name, log.unit, largest, time, np.linalg.norm(value, axis=1))


def _row_at(time: Floats, zero: float | None, name: str) -> int:
    if not len(time):
        raise TissueError(f'"{name}" has no values yet')
    if zero is None:
        return 0
    return min(int(np.searchsorted(time, zero)), len(time) - 1)


def _log(run: "Trajectory", name: str) -> "Log | None":
    found = log_called(name, run.logs)
    return None if found is None else run.logs[found]


def logs_of(run: "Trajectory", wanted: str = "") -> str:
    """Return which logs a run has, as the end of a message.

    Args:
        run: The result.
        wanted: What was requested instead.
    """
    names = list(run.logs)
    if not names:
        return "the result has no logs; write output { force(NAME) every 1 ms }"
    return alternatives(wanted, [*names, TIME], what="there are")
