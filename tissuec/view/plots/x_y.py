"""One quantity against another: force over displacement, pressure over volume, …"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.scale import scale_of
from tissuec.model.network import Floats
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import log_ticks
from tissuec.view.plots.curves import above, look, thinned
from tissuec.view.plots.options import Option, Start, Stop, read_time
from tissuec.view.plots.over_time import Window, say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.quantities import (
    QUANTITY,
    TIME,
    LoggedQuantity,
    logs_of,
    quantity,
    unit_of,
)
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

    from tissuec.results.trajectory import Trajectory
    from tissuec.view.plots.drawing import Axes

WIDTH, HEIGHT = 120.0, 90.0  # [mm]
ARROWS = (0.25, 0.5, 0.75)  # of the length of a curve, where its direction in time is shown
#: Units of products that have a name of their own.
_PRODUCTS = {("N", "m"): "J", ("Pa", "m^3"): "J", ("W", "s"): "J", ("N", "s"): "N*s"}


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
        zero: From which time displacements and times are measured [s]; None: from the first
            moment.
        scale: Axes that are logarithmic: "x=log", "y=log".
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    x: Annotated[str | None, Option(f"Horizontal axis: {QUANTITY}.", "QUANTITY")] = None
    y: Annotated[str | None, Option(f"Vertical axis: {QUANTITY}.", "QUANTITY")] = None
    zero: Annotated[
        float | None,
        Option("Measure displacements and times from this time.", "TIME", read_time),
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
            raise TissueError(f'"{wrong}" is not a scale of an axis; write x=log or y=log')
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
            raise TissueError(f"--{axis} is missing: {QUANTITY}; {logs_of(run)}")
        return quantity(run, wanted, self.zero).within(Window(self.start, self.stop))

    def _draw(
        self,
        sheet: Canvas,
        runs: Sequence[PlotSubject],
        shown: Sequence[tuple[LoggedQuantity, LoggedQuantity]],
        curves: Sequence[PairedCurve],
    ) -> None:
        axes: Axes = sheet.figure.subplots()
        first, second = shown[0]
        along, up = (unit_of(pair[k] for pair in shown) for k in (0, 1))
        lines: list[Line2D] = []
        for number, (run, curve) in enumerate(zip(runs, curves, strict=True)):
            x, y = thinned(along.of(curve.x), up.of(curve.y))
            lines += axes.plot(x, y, label=run.name, **look(number))
            if not first.name.startswith(TIME):
                sheet.later.append(lambda x=x, y=y, n=number: _arrows(axes, x, y, n))
                unit = _PRODUCTS.get((second.unit, first.unit), f"{second.unit}*{first.unit}")
                area = scale_of(unit, [curve.area])
                sheet.tell("areas", run.name, {"value": curve.area, "unit": unit})
                sheet.note(f"{run.name}: area {area.of(curve.area):.4g} {area.unit}")
        for name in self.scale:
            axes.set(**{f"{name[0]}scale": "log"})
            log_ticks(axes, name[0])
        axes.set(xlabel=along.label(first.name), ylabel=up.label(second.name))
        if len(runs) > 1:
            above(sheet, lines)
        say_unfinished(sheet, runs)


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
