"""One quantity against another: force over displacement, pressure over volume, …"""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.errors import TissueError, counted
from tissuec.core.hints import alternatives
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.model.network import Floats
from tissuec.results.recording import AXES
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import above, look, thinned
from tissuec.view.plots.logs import is_place, log_called
from tissuec.view.plots.options import Option, Start, Stop, read_time
from tissuec.view.plots.over_time import Window, say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

    from tissuec.results.trajectory import Log, Trajectory
    from tissuec.view.plots.drawing import Axes

WIDTH, HEIGHT = 120.0, 90.0  # [mm]
ARROWS = (0.25, 0.5, 0.75)  # of the length of a curve, where its direction in time is shown
TIME = "time"
#: "magnitude of LOG", "LOG along z"
_PART = re.compile(r"(?:(?P<magnitude>magnitude) of )?(?P<name>.+?)(?: along (?P<axis>[xyz]))?")
_FROM, _TO = "displacement of ", "position of "
#: Units of products that have a name of their own.
_PRODUCTS = {("N", "m"): "J", ("Pa", "m^3"): "J", ("W", "s"): "J", ("N", "s"): "N*s"}
_QUANTITY = '"time", a log, "LOG along z", "magnitude of LOG", or "displacement of SET along z"'


class LoggedQuantity(Struct, frozen=True, eq=False):
    """A number over time.

    Attributes:
        name: Stands at its axis.
        unit: Of its values, as files spell it.
        scale: That of the whole quantity, of which this may be a component or a part.
        time: [s], ascending, shape (moment,); two equal ones are both sides of an event.
        value: Shape (moment,).
    """

    name: str
    unit: str
    scale: AxisUnit
    time: Floats
    value: Floats


class PairedCurve(Struct, frozen=True, eq=False):
    """Two quantities of a run at the same moments, shape (moment,) each.

    Attributes:
        is_interpolated: Whether one of them is logged at other times than the other.
    """

    x: Floats
    y: Floats
    is_interpolated: bool

    @property
    def area(self) -> float:
        """Return ∫ y dx by trapezoids [unit of y × unit of x]: of a loop, what it encloses."""
        return float(np.diff(self.x) @ (self.y[1:] + self.y[:-1])) / 2.0


@PLOTS.member("x-y")
class XYPlot(Struct, frozen=True):
    """One logged quantity against another, with arrows along time and the area in its notes.

    Attributes:
        x, y: Quantities.
        zero: From which time displacements are measured [s]; None: from the first moment.
        scale: Axes that are logarithmic: "x=log", "y=log".
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    x: Annotated[str | None, Option(f"Horizontal axis: {_QUANTITY}.", "QUANTITY")] = None
    y: Annotated[str | None, Option(f"Vertical axis: {_QUANTITY}.", "QUANTITY")] = None
    zero: Annotated[
        float | None, Option("Measure displacements from this time.", "TIME", read_time)
    ] = None
    scale: Annotated[
        tuple[str, ...], Option("Logarithmic axis; may be repeated.", "x=log|y=log")
    ] = ()
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a curve of each run.

        Raises:
            TissueError: A quantity is missing, unknown, or has several values.
        """
        wrong = next((one for one in self.scale if one not in ("x=log", "y=log")), None)
        if wrong is not None:
            raise TissueError(f'"{wrong}" is no scale of an axis; write x=log or y=log')
        found = [
            (self._quantity("x", run.content), self._quantity("y", run.content))
            for run in subjects
        ]
        curves = [joined(x, y) for x, y in found]
        x, y = found[0]
        notes = [
            f"{run.name}: {x.name} and {y.name} are logged at different times; the coarser "
            "one is interpolated"
            for run, curve in zip(subjects, curves, strict=True)
            if curve.is_interpolated
        ]

        def draw(sheet: Canvas) -> None:
            self._draw(sheet, subjects, found, curves)

        return Picture(WIDTH, HEIGHT, draw, tuple(notes))

    def _quantity(self, axis: str, run: "Trajectory") -> LoggedQuantity:
        wanted = getattr(self, axis)
        if not wanted:
            raise TissueError(f"--{axis} is missing: {_QUANTITY}; {_logs_of(run)}")
        found = quantity(run, wanted, self.zero)
        rows = Window(self.start, self.stop).rows(found.time, f'"{found.name}"')
        return replace(found, time=found.time[rows], value=found.value[rows])

    def _draw(
        self,
        sheet: Canvas,
        runs: Sequence[PlotSubject],
        shown: Sequence[tuple[LoggedQuantity, LoggedQuantity]],
        curves: Sequence[PairedCurve],
    ) -> None:
        axes: Axes = sheet.figure.subplots()
        first, second = shown[0]
        along, up = (
            max((pair[k].scale for pair in shown), key=lambda scale: scale.power)
            for k in (0, 1)
        )
        lines: list[Line2D] = []
        for number, (run, curve) in enumerate(zip(runs, curves, strict=True)):
            x, y = thinned(along.of(curve.x), up.of(curve.y))
            lines += axes.plot(x, y, label=run.name, **look(number))
            if first.name != TIME:
                sheet.later.append(lambda x=x, y=y, n=number: _arrows(axes, x, y, n))
                unit = _PRODUCTS.get((second.unit, first.unit), f"{second.unit}*{first.unit}")
                area = scale_of(unit, [curve.area])
                sheet.areas[run.name] = {"value": curve.area, "unit": unit}
                sheet.note(f"{run.name}: area {area.of(curve.area):.4g} {area.unit}")
        for name in self.scale:
            axes.set(**{f"{name[0]}scale": "log"})
        axes.set(xlabel=along.label(first.name), ylabel=up.label(second.name))
        if len(runs) > 1:
            above(sheet, lines)
        say_unfinished(sheet, runs)


def quantity(run: "Trajectory", wanted: str, zero: float | None = None) -> LoggedQuantity:
    """Return a quantity of a run over time.

    Args:
        run: The result.
        wanted: "time", the name of a log, "LOG along z", "magnitude of LOG", "displacement of
            SET along z".
        zero: From which time displacements are measured [s].

    Raises:
        TissueError: There is no such log, or it has several values.
    """
    if wanted.lower() == TIME:
        times = [log.with_jumps()[0] for log in run.logs.values()]
        longest = max(times, key=len, default=np.zeros(0))
        return LoggedQuantity(TIME, "s", run.clock, longest, longest)
    log, matched = _log(run, wanted), _PART.fullmatch(wanted)
    assert matched is not None
    axis, is_displacement = None, False
    if log is None:
        axis, name = matched["axis"], matched["name"]
        is_displacement = name.lower().startswith(_FROM)
        log = _log(run, _TO + name[len(_FROM) :] if is_displacement else name)
    if log is None:
        raise TissueError(f'there is no quantity "{wanted}"; {_logs_of(run, wanted)}')
    time, value = log.with_jumps()
    scale = log.scale
    if is_displacement:
        value = value - value[_row_at(time, zero, wanted)]
        scale = scale_of(log.unit, [np.linalg.norm(value, axis=1)])
    if len(log.columns) == 1:
        return LoggedQuantity(wanted, log.unit, scale, time, value[:, 0])
    if log.columns != AXES:
        raise TissueError(
            f'"{log.name}" has {counted(len(log.columns), "value")} at each time; an axis '
            "needs one: log it of a single spring"
        )
    if axis:
        return LoggedQuantity(wanted, log.unit, scale, time, value[:, AXES.index(axis)])
    if is_place(log.name) and not is_displacement:
        raise TissueError(
            f'"{log.name}" has three components; write "{log.name} along z", or '
            f'"{_FROM}{log.name.removeprefix(_TO)}" for the distance from the beginning'
        )
    name = wanted if matched["magnitude"] else f"magnitude of {wanted}"
    return LoggedQuantity(name, log.unit, scale, time, np.linalg.norm(value, axis=1))


def joined(x: LoggedQuantity, y: LoggedQuantity) -> PairedCurve:
    """Return two quantities at the same moments: those of the one with more of them."""
    if np.array_equal(x.time, y.time):
        return PairedCurve(x.value, y.value, is_interpolated=False)
    fine, coarse = (x, y) if len(x.time) >= len(y.time) else (y, x)
    both = (fine.time >= coarse.time[0]) & (fine.time <= coarse.time[-1])
    other = np.interp(fine.time[both], coarse.time, coarse.value)
    values = (fine.value[both], other) if fine is x else (other, fine.value[both])
    # Both sides of events do not make other moments.
    is_same = np.array_equal(np.unique(x.time), np.unique(y.time))
    return PairedCurve(*values, is_interpolated=not is_same and TIME not in (x.name, y.name))


def _row_at(time: Floats, zero: float | None, name: str) -> int:
    if not len(time):
        raise TissueError(f'"{name}" has no values yet')
    if zero is None:
        return 0
    return min(int(np.searchsorted(time, zero)), len(time) - 1)


def _log(run: "Trajectory", name: str) -> "Log | None":
    found = log_called(name, run.logs)
    return None if found is None else run.logs[found]


def _logs_of(run: "Trajectory", wanted: str = "") -> str:
    names = list(run.logs)
    if not names:
        return "the result has no logs; write output { force of NAME every 1 ms }"
    return alternatives(wanted, [*names, TIME], what="there are")


def _arrows(axes: "Axes", x: Floats, y: Floats, number: int) -> None:
    """Show along which way a curve is passed in time."""
    place = axes.transData.transform(np.column_stack([x, y]))
    finite = np.isfinite(place).all(axis=1)
    place, x, y = place[finite], x[finite], y[finite]
    if len(place) < 2:
        return
    pieces = np.linalg.norm(np.diff(place, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(pieces)])
    whole = float(length[-1])
    for part in ARROWS if whole > 0.0 else ():
        row = min(int(np.searchsorted(length, part * whole)), len(x) - 1)
        axes.annotate(
            "", (x[row], y[row]), (x[max(row - 1, 0)], y[max(row - 1, 0)]),
            arrowprops={"arrowstyle": "-|>", "color": look(number)["color"], "lw": 0.0,
                        "mutation_scale": 12},
        )  # fmt: skip
