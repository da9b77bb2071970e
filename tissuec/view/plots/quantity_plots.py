"""Logged quantities as plots: against one another, of several runs, and their spectra.

P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73: the log is cut into segments that
overlap by half; of each, its mean is taken off and a Hann window laid over it, and the squares
of the Fourier transforms are averaged. The density is one-sided: its integral is the variance.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.scale import scale_of
from tissuec.core.units import TIME as SECONDS
from tissuec.core.units import show
from tissuec.model.network import Floats
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import log_ticks, whole_decades
from tissuec.view.plots.curves import above, look, thinned
from tissuec.view.plots.options import Option, Start, Stop, read_time
from tissuec.view.plots.over_time import Panel, TimeCurve, Window, draw_panels, say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.quantities import (
    QUANTITY,
    TIME,
    LoggedQuantity,
    behind_events,
    logs_of,
    quantity,
    unit_of,
)
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

    from tissuec.results.trajectory import Trajectory
    from tissuec.view.plots.drawing import Axes

WIDTH, HEIGHT = 120.0, 80.0  # [mm]
WINDOW = "hann"
SEGMENTS = 8  # of a log, with overlaps
FEWEST = 16  # values of a segment
_UNEVEN = 1e-6  # of a step: less is rounding


class Spectrum(Struct, frozen=True, eq=False):
    """A one-sided power spectral density.

    Attributes:
        frequency: [Hz], shape (frequency,).
        density: [unit²/Hz], shape (frequency,).
        step: Time between two values [s].
        segment: Values of a segment.
        count: Segments.
        is_interpolated: Whether the log was brought to even steps.
    """

    frequency: Floats
    density: Floats
    step: float
    segment: int
    count: int
    is_interpolated: bool

    @property
    def variance(self) -> float:
        """Return the variance [unit²] of what is not slower than a segment (Parseval)."""
        return float(self.density.sum() / (self.segment * self.step))

    @property
    def peak(self) -> float:
        """Return the frequency of the largest density [Hz]."""
        return float(self.frequency[self.density.argmax()])


@PLOTS.member("spectrum")
class SpectrumPlot(Struct, frozen=True):
    """Power spectral density of a logged quantity, by Welch's method with a Hann window.

    Attributes:
        spectrum: The quantity.
        segment: Length of the segments that are averaged [s].
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    spectrum: Annotated[str | None, Option(f"Spectrum of this: {QUANTITY}.", "QUANTITY")] = None
    segment: Annotated[
        float | None,
        Option("Length of averaged segments; by default there are 8.", "TIME", read_time),
    ] = None
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a spectrum of each run.

        Raises:
            TissueError: The quantity is missing or unknown, or has too few values.
        """
        if not self.spectrum:
            raise TissueError(
                f"--spectrum is missing: {QUANTITY}; {logs_of(subjects[0].content)}"
            )
        window = Window(self.start, self.stop)
        logs = [quantity(run.content, self.spectrum).within(window) for run in subjects]
        found = [spectrum_of(log, self.segment) for log in logs]

        def draw(sheet: Canvas) -> None:
            _draw(sheet, subjects, logs, found)

        return Picture(WIDTH, HEIGHT, draw)


def spectrum_of(log: LoggedQuantity, segment: float | None = None) -> Spectrum:
    """Return the power spectral density of a quantity over time.

    Args:
        segment: Length of segments [s]; by default there are 8.

    Raises:
        TissueError: There are too few values, or a segment is too short or too long.
    """
    from scipy.signal import welch

    time, value = behind_events(log)
    if len(time) < FEWEST or not np.isfinite(value).all():
        raise TissueError(
            f'"{log.name}" has {len(time)} values; a spectrum needs {FEWEST} or more, '
            "without gaps"
        )
    steps = np.diff(time)
    step = float(np.median(steps))
    if (np.abs(steps - step) > _UNEVEN * step).mean() > 0.5:  # not a few beside events
        step = float(steps.mean())
    even = time[0] + step * np.arange(int(np.floor((time[-1] - time[0]) / step + _UNEVEN)) + 1)
    is_even = len(even) == len(time) and bool(np.abs(even - time).max() <= _UNEVEN * step)
    if not is_even:
        value = np.asarray(np.interp(even, time, value), dtype=float)
    count = len(value)
    length = 2 * count // (SEGMENTS + 1) if segment is None else round(segment / step)
    length = max(length, min(FEWEST, count)) if segment is None else length
    if not FEWEST <= length <= count:
        least, most = (show(n * step, SECONDS) for n in (FEWEST, count))
        raise TissueError(f'a segment of "{log.name}" must be between {least} and {most} long')
    frequency, density = welch(
        value, 1.0 / step, window=WINDOW, nperseg=length, noverlap=length // 2,
        detrend="constant", scaling="density",
    )  # fmt: skip
    segments = (count - length // 2) // (length - length // 2)
    return Spectrum(frequency, density, step, length, segments, not is_even)


def _draw(
    sheet: Canvas,
    runs: Sequence[PlotSubject],
    logs: Sequence[LoggedQuantity],
    found: Sequence[Spectrum],
) -> None:
    axes: Axes = sheet.figure.subplots()
    scale = unit_of(logs)
    square = scale.factor**2
    lines: list[Line2D] = []
    for number, (run, log, one) in enumerate(zip(runs, logs, found, strict=True)):
        lines += axes.plot(
            one.frequency[1:], square * one.density[1:], label=run.name, **look(number)
        )
        sheet.note(f"{run.name}: {_method(one)}")
        if one.is_interpolated:
            sheet.note(
                f"{run.name}: {log.name} is not logged at even steps; it is interpolated to "
                f"steps of {show(one.step, SECONDS)}"
            )
        sheet.tell("spectra", run.name, {
            "window": WINDOW, "segment": one.segment * one.step, "overlap": 0.5,
            "segments": one.count, "step": one.step, "interpolated": one.is_interpolated,
            "unit": f"{log.unit}^2/Hz", "peak": one.peak, "variance": one.variance,
            "frequency": one.frequency.tolist(), "density": one.density.tolist(),
        })  # fmt: skip
    whole_decades(axes, np.concatenate([square * one.density for one in found]))
    unit = f" [{scale.unit}²/Hz]" if scale.unit else " [1/Hz]"
    axes.set(xlabel="frequency [Hz]", ylabel=f"power spectral density of {logs[0].name}{unit}")
    axes.set(xscale="log")
    log_ticks(axes, "x")
    if len(runs) > 1:
        above(sheet, lines)
    say_unfinished(sheet, runs)


def _method(one: Spectrum) -> str:
    """Return how a spectrum was computed, and what it shows."""
    length = show(one.segment * one.step, SECONDS)
    return (
        f"Welch, Hann window, segments of {one.segment} values ({length}), overlap 50 %, "
        f"averaged over {one.count}; peak at {one.peak:.4g} Hz"
    )


BAND_WIDTH, BAND_HEIGHT = 120.0, 70.0  # [mm]


class JoinedRuns(Struct, frozen=True, eq=False):
    """A quantity of several runs at the same times.

    Attributes:
        time: [s], shape (moment,).
        value: In the unit of the quantity, shape (run, moment).
        is_interpolated: Whether some run is logged at other times.
    """

    time: Floats
    value: Floats
    is_interpolated: bool


@PLOTS.member("envelope")
class Envelope(Struct, frozen=True):
    """Mean of a logged quantity over several runs, and the band that contains all of them.

    Attributes:
        envelope: The quantity.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    envelope: Annotated[
        str | None, Option(f"Mean and band of this over runs: {QUANTITY}.", "QUANTITY")
    ] = None
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of the mean and the band.

        Raises:
            TissueError: The quantity is missing or unknown, or runs have no common time.
        """
        if not self.envelope:
            raise TissueError(
                f"--envelope is missing: {QUANTITY}; {logs_of(subjects[0].content)}"
            )
        window = Window(self.start, self.stop)
        logs = [quantity(run.content, self.envelope).within(window) for run in subjects]
        both = common(logs)
        mean, band = both.value.mean(axis=0), (both.value.min(axis=0), both.value.max(axis=0))
        curve = TimeCurve("", both.time, mean, look(0), band)
        panel = Panel(logs[0].name, logs[0].unit, [curve], size=max(o.largest for o in logs))
        how = "their common times"
        if both.is_interpolated:
            how = f"the {len(both.time)} times of the finest log, the others interpolated"
        note = f"line: mean of {len(logs)} runs; band: smallest to largest; at {how}"

        def draw(sheet: Canvas) -> None:
            draw_panels(sheet, [panel], [])
            say_unfinished(sheet, subjects)
            sheet.tell("envelope", logs[0].name, {
                "unit": logs[0].unit, "runs": [run.name for run in subjects],
                "interpolated": both.is_interpolated, "time": both.time.tolist(),
                "mean": mean.tolist(), "low": band[0].tolist(), "high": band[1].tolist(),
            })  # fmt: skip

        return Picture(BAND_WIDTH, BAND_HEIGHT, draw, (note,))


def common(logs: Sequence[LoggedQuantity]) -> JoinedRuns:
    """Return quantities at the times of the finest log, as far as all of them reach.

    Raises:
        TissueError: There is no such time.
    """
    times, values = zip(*(behind_events(log) for log in logs), strict=True)
    if all(np.array_equal(time, times[0]) for time in times):
        return JoinedRuns(times[0], np.stack(values), is_interpolated=False)
    first, last = max(time[0] for time in times), min(time[-1] for time in times)
    finest = max(times, key=lambda time: int(((time >= first) & (time <= last)).sum()))
    shown = finest[(finest >= first) & (finest <= last)]
    if not len(shown):
        raise TissueError(f'the runs have no common time of "{logs[0].name}"')
    joined = [
        np.asarray(np.interp(shown, time, value), dtype=float)
        for time, value in zip(times, values, strict=True)
    ]
    return JoinedRuns(shown, np.stack(joined), is_interpolated=True)


PAIR_WIDTH, PAIR_HEIGHT = 120.0, 90.0  # [mm]
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

        return Picture(PAIR_WIDTH, PAIR_HEIGHT, draw, tuple(notes))

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
