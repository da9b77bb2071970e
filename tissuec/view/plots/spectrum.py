"""Power spectral densities of logs, by Welch's method.

P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73: the log is cut into segments that
overlap by half; of each, its mean is taken off and a Hann window laid over it, and the squares
of the Fourier transforms are averaged. The density is one-sided: its integral is the variance.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.units import TIME, show
from tissuec.model.network import Floats
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import log_ticks, whole_decades
from tissuec.view.plots.curves import above, look
from tissuec.view.plots.options import Option, Start, Stop, read_time
from tissuec.view.plots.over_time import Window, say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.quantities import (
    QUANTITY,
    LoggedQuantity,
    behind_events,
    logs_of,
    quantity,
    unit_of,
)
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

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
        log: The quantity.
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
        least, most = (show(n * step, TIME) for n in (FEWEST, count))
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
                f"steps of {show(one.step, TIME)}"
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
    length = show(one.segment * one.step, TIME)
    return (
        f"Welch, Hann window, segments of {one.segment} values ({length}), overlap 50 %, "
        f"averaged over {one.count}; peak at {one.peak:.4g} Hz"
    )
