"""Panels one above the other with one axis of time, drawn of runs."""

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.scale import AxisUnit, largest_of, scale_of
from tissuec.core.structs import replace
from tissuec.core.units import TIME, show
from tissuec.model.network import Floats
from tissuec.view.plots.axes import clusters, mark_events, stagger, whole_decades
from tissuec.view.plots.curves import above, beside, look, name_curves, thinned, thinned_band
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

    from tissuec.view.plots.drawing import Axes

WIDTH = 180.0  # of a page [mm]
PANEL = 42.0  # height of a panel [mm]
AROUND = 16.0  # height of everything around the panels [mm]
_LINE = 24  # letters in a line of what is written at a panel, at most
_LETTER = 1.45  # [mm]: of the height of a panel that a letter takes
_LEAST_LINE = 8  # letters
_PALE, _SOLID = 0.22, 0.75  # how much a band hides
_ROUNDING = 1e-9


class TimeCurve(Struct, frozen=True, eq=False):
    """A number over time.

    Attributes:
        name: Text beside it; none for curves whose colour is explained elsewhere.
        time: [s], ascending, shape (moment,).
        value: In the unit of its panel, shape (moment,).
        looks: Colour, dashes and width, as matplotlib has them.
        band: What is filled around it, from and to, shape (moment,) each.
        is_layer: Whether the band is what counts, as in a stack; its edge is the value.
    """

    name: str
    time: Floats
    value: Floats
    looks: Mapping[str, Any]
    band: tuple[Floats, Floats] | None = None
    is_layer: bool = False


class Panel(Struct, frozen=True, eq=False):
    """Curves in the same unit.

    Attributes:
        name: Written at the axis.
        unit: Of all values, as files spell it.
        is_log: Whether the axis is logarithmic.
        size: The number that the prefix of the unit suits; by default the largest of all.
    """

    name: str
    unit: str
    curves: list[TimeCurve]
    is_log: bool = False
    size: float | None = None


class Window(Struct, frozen=True):
    """The part of the time that is shown [s]; None: from the start, or to the end."""

    start: float | None = None
    stop: float | None = None

    def rows(self, time: Floats, name: str) -> slice:
        """Return the range of ascending times that is shown.

        Args:
            time: Times [s], shape (row,).
            name: Name of the result in messages.

        Raises:
            TissueError: No time is shown.
        """
        if self.start is not None and self.stop is not None and self.start > self.stop:
            what = f"start = {_show(self.start)} is after stop = {_show(self.stop)}"
            raise TissueError(f"{name} has nothing to show: {what}")
        first = 0 if self.start is None else int(np.searchsorted(time, self.start - 1e-12))
        last = len(time)
        if self.stop is not None:
            last = int(np.searchsorted(time, self.stop + 1e-12))
        if first >= last:
            has = "nothing has been written yet"
            if len(time):
                has = f"it runs from {_show(time[0])} to {_show(time[-1])}"
            raise TissueError(f"{name} has nothing to show at these times; {has}")
        return slice(first, last)


def picture_of(
    panels: Sequence[Panel],
    runs: Sequence[PlotSubject],
    *,
    notes: Sequence[str] = (),
    heights: Sequence[float] = (),
) -> Picture:
    """Return the picture of panels.

    Args:
        heights: Of each panel, relative to the usual height, if they differ.
    """
    height = AROUND + PANEL * (sum(heights) if heights else len(panels))
    layout = {"height_ratios": list(heights)} if heights else {}

    def draw(sheet: Canvas) -> None:
        draw_panels(sheet, panels, runs, **layout)

    return Picture(WIDTH, height, draw, tuple(notes))


def draw_panels(
    sheet: Canvas, panels: Sequence[Panel], runs: Sequence[PlotSubject], **layout: Any
) -> list["Axes"]:
    """Draw panels with the events of the runs; several runs are named above all.

    Args:
        layout: Further arguments of matplotlib's ``subplots``, such as ``height_ratios``.
    """
    height = (sheet.height - AROUND) / len(panels)
    grid = sheet.figure.subplots(len(panels), 1, sharex=True, squeeze=False, **layout)
    axes: list[Axes] = list(grid[:, 0])
    times = [curve.time for panel in panels for curve in panel.curves]
    shown = (min(float(t[0]) for t in times), max(float(t[-1]) for t in times))
    # As wide as the runs, whatever part of them is shown.
    scale = scale_of("s", [shown, *(run.content.last_time for run in runs)])
    # Where all panels have the same curves, their names appear once, above all.
    sets = {tuple(curve.name for curve in panel.curves if curve.name) for panel in panels}
    are_alike = len(panels) > 1 and len(sets) == 1 and len(next(iter(sets))) > 1
    drawn = [
        _draw_panel(sheet, one, panel, scale, height, names=not are_alike)
        for one, panel in zip(axes, panels, strict=True)
    ]
    if are_alike:
        above(sheet, drawn[0])
    low, high = scale.of(shown)
    axes[-1].set(xlabel=scale.label("time"), xlim=(low, high if high > low else low + 1.0))
    if len(runs) > 1:
        above(sheet, [_key(axes[0], run.name, number) for number, run in enumerate(runs)])
    _mark(sheet, axes, runs, scale, shown)
    say_unfinished(sheet, runs)
    return axes


def _key(axes: "Axes", name: str, number: int) -> "Line2D":
    """Return the entry of a run in a legend; it has no points."""
    (line,) = axes.plot([], [], label=name, **look(number))
    return line


def _draw_panel(
    sheet: Canvas, axes: "Axes", panel: Panel, time: AxisUnit, height: float, *, names: bool
) -> list[Any]:
    """Draw a panel; return what bears the names of its curves, written there or not.

    Args:
        height: Of the panel, about [mm].
    """
    scale = scale_of(panel.unit, numbers_of([panel]) if panel.size is None else [panel.size])
    for curve in panel.curves:
        wrong = int((~np.isfinite(curve.value)).sum())
        if wrong:
            what = f"{panel.name} {curve.name}".strip()
            sheet.note(f"{what} has {wrong} values that are not numbers")
    drawn = [_draw_curve(axes, curve, time, scale) for curve in panel.curves]
    if panel.is_log and any((curve.value > 0.0).any() for curve in panel.curves):
        whole_decades(axes, scale.of(np.concatenate([curve.value for curve in panel.curves])))
    else:
        _show_what_stays(axes, panel, scale)
    line = int(np.clip(height / _LETTER, _LEAST_LINE, _LINE))
    axes.set_ylabel("\n".join(wrap(scale.label(panel.name), line, break_long_words=False)))
    named = [one for one, curve in zip(drawn, panel.curves, strict=True) if curve.name]
    if any(curve.is_layer for curve in panel.curves):
        axes.set_ylim(bottom=0.0)
        beside(axes, drawn[::-1])  # from above, as they lie
    elif names:
        name_curves(sheet, axes, named)
    return named


def numbers_of(panels: Sequence[Panel]) -> list[Floats]:
    """Return all numbers that panels show, in the units of the panels, shape (n,) each."""
    curves = [curve for panel in panels for curve in panel.curves]
    return [part for curve in curves for part in (curve.value, *(curve.band or ()))]


def alike(panels: list[Panel]) -> list[Panel]:
    """Return panels of components, which have the same unit at their axes."""
    largest = largest_of(numbers_of(panels))
    return [replace(panel, size=largest) for panel in panels]


def _show_what_stays(axes: "Axes", panel: Panel, scale: AxisUnit) -> None:
    """Keep an axis from showing the rounding of numbers that are all the same."""
    numbers = np.concatenate([curve.value for curve in panel.curves])
    known = scale.of(numbers[np.isfinite(numbers)])
    size = float(np.abs(known).max(initial=0.0))
    if len(known) and np.ptp(known) <= _ROUNDING * size:
        around = max(0.1 * size, 1e-12) if size else 1.0
        axes.set_ylim(known[0] - around, known[0] + around)


def _draw_curve(axes: "Axes", curve: TimeCurve, time: AxisUnit, scale: AxisUnit) -> Any:
    """Draw a curve; return what bears its name."""
    label = curve.name or "_"
    if curve.band is not None:
        x, low, high = thinned_band(curve.time, *curve.band)
        band = axes.fill_between(
            time.of(x), scale.of(low), scale.of(high), color=curve.looks["color"],
            alpha=_SOLID if curve.is_layer else _PALE, linewidth=0.0,
            label=label if curve.is_layer else "_",
        )  # fmt: skip
        if curve.is_layer:
            return band
    x, y = thinned(curve.time, curve.value)
    (line,) = axes.plot(time.of(x), scale.of(y), label=label, **curve.looks)
    if len(x) == 1:
        line.set_marker("o")
    return line


def _mark(
    sheet: Canvas,
    axes: Sequence["Axes"],
    runs: Sequence[PlotSubject],
    scale: AxisUnit,
    shown: tuple[float, float],
) -> None:
    """Mark what happened: in all runs alike, or else in the colour of each."""
    near = 1e-3 * (shown[1] - shown[0])
    told = [clusters(run.content.events, shown) for run in runs]

    def is_common(time: float, text: str) -> bool:
        return all(any(text == t and abs(time - at) <= near for at, t in one) for one in told)

    common = [cluster for one in told[:1] for cluster in one if is_common(*cluster)]
    texts = mark_events(axes, common, scale)
    if len(runs) > 1:
        for number, one in enumerate(told):
            own = [cluster for cluster in one if not is_common(*cluster)]
            texts += mark_events(axes, own, scale, **look(number))
    if texts:
        sheet.later.append(lambda: stagger(texts, axes[0]))


def say_unfinished(sheet: Canvas, runs: Sequence[PlotSubject]) -> None:
    """Mark runs that did not reach their end, in the picture and in its notes."""
    said = [text for run in runs if (text := unfinished(run))]
    for text in said:
        sheet.note(text)
    if said:
        sheet.figure.supxlabel("\n".join(said), fontsize=8, style="italic")


def unfinished(run: PlotSubject) -> str:
    """Return how far an unfinished run has come; nothing of one that is finished."""
    trajectory = run.content
    if trajectory.finished:
        return ""
    whole = trajectory.manifest.get("duration")
    of = f" of {_show(whole)}" if isinstance(whole, float | int) else ""
    return f"{run.name} is unfinished: until {_show(trajectory.last_time)}{of}"


def _show(time: float) -> str:
    return show(float(time), TIME)
