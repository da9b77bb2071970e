"""Statistics of a study: how measures are distributed, and how they depend on factors."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from textwrap import fill
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.model.network import Floats
from tissuec.scene.study.entries import GRID, INDICES, LIST, ONE_AT_A_TIME
from tissuec.studies.analysis.completed import completed, values_of
from tissuec.studies.analysis.convergence import (
    REFINED,
    ObservedOrder,
    ObservedOrders,
    orders,
    refined_factor,
)
from tissuec.studies.analysis.quantiles import Quantiles, quantiles, sample_of
from tissuec.studies.analysis.sensitivity import Effects, SobolIndices, effects, sobol_indices
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import ticks_at
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.study_plot import (
    Along,
    FactorAxis,
    Panel,
    Panels,
    StudyPlot,
    chosen_measures,
    left_out,
    scale_of_measure,
    together,
)
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes


@PLOTS.member("distribution")
class DistributionPlot(StudyPlot, frozen=True):
    """Histograms of measures over the runs of a random design, with quantiles."""

    width: ClassVar[float] = 140.0
    panel: ClassVar[float] = 55.0
    around: ClassVar[float] = 14.0

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        is_random = table.head.design not in (GRID, LIST, ONE_AT_A_TIME)
        return is_random and len(table.factors) > 4 and bool(table.measures)

    def panels(self, table: StudyTable) -> Panels:
        sample = sample_of(table)
        found = [quantiles(sample, one.name) for one in chosen_measures(sample, self.measure)]
        lines = "lines: 5, 25, 50, 75 and 95 % of the runs; bands: 95 % intervals"
        notes = [lines, *together({one.measure: one.notes() for one in found})]
        return Panels([partial(_draw_quantiles, sample, one) for one in found], notes)


def _draw_quantiles(table: StudyTable, found: Quantiles, sheet: Canvas, axes: "Axes") -> None:
    values, _ = values_of(table, table.column(found.measure))
    scale = scale_of(found.unit, [values])
    counts, edges = np.histogram(scale.of(values), bins="sturges")
    axes.fill_between(
        np.repeat(edges, 2)[1:-1], 0.0, np.repeat(counts, 2), color=SERIES[0], alpha=0.35
    )
    for quantile in found:
        axes.axvline(float(scale.of(quantile.value)), color=INK, linewidth=1.0)
        if quantile.has_interval:
            low, high = scale.of([quantile.low, quantile.high])
            axes.axvspan(low, high, color=SERIES[1], alpha=0.15, linewidth=0.0)
    axes.set(xlabel=scale.label(found.measure), ylabel="runs")


CELL, AROUND = 32.0, 12.0  # [mm]
MOST = 8  # rows of panels
BINS = 12
LINE = 16  # letters of a label


class PlottedVariable(Struct, frozen=True, eq=False):
    """A factor or measure.

    Attributes:
        label: Of its axis.
        values: In the unit of the label, shape (row,).
        words: Words that are numbered, if there are any.
    """

    label: str
    values: Floats
    words: tuple[str, ...] = ()


@PLOTS.member("scatter-matrix")
class ScatterMatrix(StudyPlot, frozen=True):
    """All factors and measures of a study against one another, with histograms."""

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        return bool(table.measures)

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: There is nothing to draw, or there is too much.
        """
        table: StudyTable = subjects[0].content
        shown = _dimensions(table, self.measure)
        count = len(shown)
        if count > MOST:
            raise TissueError(
                f"{count} factors and measures are too many for one picture (at most {MOST}); "
                "name measures with --measure"
            )

        def draw(sheet: Canvas) -> None:
            grid = sheet.figure.subplots(count, count, squeeze=False)
            for row, column in product(range(count), repeat=2):
                _draw_pair(grid[row, column], shown[column], shown[row], is_own=row == column)
                if row < count - 1:
                    grid[row, column].set_xticks([])
                if column > 0:
                    grid[row, column].set_yticks([])
            for place, one in enumerate(shown):
                grid[-1, place].set_xlabel(fill(one.label, LINE))
                grid[place, 0].set_ylabel(fill(one.label, LINE))

        side = AROUND + CELL * max(count, 2)
        notes = left_out(table, chosen_measures(table, self.measure))
        return Picture(side, side, draw, tuple(notes))


def _dimensions(table: StudyTable, names: Sequence[str]) -> list[PlottedVariable]:
    rows = completed(table).rows
    axes = [FactorAxis.of(factor) for factor in table.factors]
    found = [PlottedVariable(one.label, one.places()[rows], one.words) for one in axes]
    for measure in chosen_measures(table, names):
        scale = scale_of_measure(measure, rows)
        found.append(
            PlottedVariable(scale.label(measure.name), scale.of(measure.numbers[rows]))
        )
    return found


def _draw_pair(axes: "Axes", x: PlottedVariable, y: PlottedVariable, *, is_own: bool) -> None:
    axes.grid(visible=False)
    if is_own:
        known = x.values[np.isfinite(x.values)]
        heights, edges = np.histogram(known, bins=len(x.words) or BINS)
        heights = heights / max(int(heights.max(initial=0)), 1)
        # On the axis of its values, so that ticks at the left mean what the label says.
        low, high = _range(known)
        axes.fill_between(
            np.repeat(edges, 2)[1:-1], low, low + (high - low) * np.repeat(heights, 2),
            color=SERIES[0], alpha=0.35, linewidth=0.0,
        )  # fmt: skip
        axes.set_ylim(low, high)
    else:
        axes.plot(x.values, y.values, ".", color=SERIES[0], markersize=3, alpha=0.6)
    if x.words:
        axes.set_xticks(range(len(x.words)), x.words, rotation=90)
    if y.words:
        axes.set_yticks(range(len(y.words)), y.words)
    for side, one in (("x", x), ("y", y)):
        if not one.words:
            axes.locator_params(side, nbins=4)


def _range(values: Floats) -> tuple[float, float]:
    low, high = float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))
    if not low < high:
        return low - 0.5, low + 0.5
    return low - 0.05 * (high - low), high + 0.05 * (high - low)


@PLOTS.member("convergence")
class Convergence(StudyPlot, frozen=True):
    """Differences to the limit of a refinement, with the observed order of convergence.

    Attributes:
        x: The refined factor, if it is not clear.
    """

    panel: ClassVar[float] = 75.0
    shares_x: ClassVar[bool] = True

    x: Along = None

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        try:
            refined = refined_factor(table)
        except ValueError:
            return False
        is_named = refined.name.split(" of ")[0] in REFINED
        return is_named and bool(table.measures) and len(set(refined.numbers.tolist())) >= 3

    def panels(self, table: StudyTable) -> Panels:
        refined = refined_factor(table, self.x)
        measures = chosen_measures(table, self.measure)
        found = [orders(table, measure.name, refined.name) for measure in measures]
        order = "p: observed order of the three finest levels that have one"
        notes = [order, *together({one.measure: one.notes() for one in found})]
        draw = [partial(_draw, one) for one in found]
        return Panels(draw, notes, partial(_finish, refined))


def _draw(found: ObservedOrders, sheet: Canvas, axes: "Axes") -> None:
    every = [_differences(one) for one in found]
    scale = scale_of(found.unit, every)
    for number, (one, values) in enumerate(zip(found, every, strict=True)):
        axes.plot(
            one.levels, _shown(scale, values), marker=MARKERS[number % len(MARKERS)],
            markersize=4, label=_name(one), **look(number),
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", ylabel=scale.label(f"error of {found.measure}"))
    beside(axes, axes.get_legend_handles_labels()[0])


def _differences(one: ObservedOrder) -> np.ndarray:
    """Return distances to the limit, or where there is none to the finest level, (level,)."""
    known = one.values[np.isfinite(one.values)]
    finest = known[-1] if len(known) else np.nan
    return np.abs(one.values - (one.limit if np.isfinite(one.limit) else finest))


def _shown(scale: AxisUnit, values: np.ndarray) -> np.ndarray:
    """Return numbers for a logarithmic axis, which has no zero."""
    return np.where(values > 0.0, scale.of(values), np.nan)


def _name(one: ObservedOrder) -> str:
    order = f"p = {one.order:.2f}" if np.isfinite(one.order) else "no order"
    return f"{one.name}: {order}" if one.fixed else order


def _finish(refined: Column, sheet: Canvas, panels: "Sequence[Axes]") -> None:
    FactorAxis.of(refined).mark(panels[-1])
    ticks_at(sheet, panels[-1], refined.numbers)


BAR = 9.0  # [mm]


@PLOTS.member("tornado")
class Tornado(StudyPlot, frozen=True):
    """Effects of factors on measures: ranges of one at a time, or Sobol indices."""

    panel: ClassVar[float] = 22.0
    around: ClassVar[float] = 0.0

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        return table.head.design in (INDICES, ONE_AT_A_TIME) and bool(table.measures)

    def height(self, table: StudyTable) -> float:
        """Return the height of a panel [mm]."""
        return self.panel + BAR * len(table.factors)

    def panels(self, table: StudyTable) -> Panels:
        """Return a panel for each measure.

        Raises:
            ValueError: The design of the study does not isolate single factors.
        """
        if not Tornado.suits(table):
            raise ValueError(
                f'a tornado needs the design "{ONE_AT_A_TIME}" or "{INDICES}"; this study has '
                f'"{table.head.design}"'
            )
        is_random = table.head.design == INDICES
        answer: Callable[[StudyTable, str], Any] = sobol_indices if is_random else effects
        drawing: Callable[[Any, Canvas, Axes], None] = _indices if is_random else _ranges
        draw, notes = list[Panel](), dict[str, list[str]]()
        for measure in chosen_measures(table, self.measure):
            try:
                found = answer(table, measure.name)
            except ValueError as error:
                draw.append(partial(_say, str(error)))
                notes[measure.name] = []
            else:
                draw.append(partial(drawing, found))
                notes[measure.name] = found.notes()
        own = [] if is_random else ["the line is the scene as written"]
        return Panels(draw, [*own, *together(notes)])


def _say(text: str, sheet: Canvas, axes: "Axes") -> None:
    axes.text(0.02, 0.5, text, transform=axes.transAxes)


def _ranges(found: Effects, sheet: Canvas, axes: "Axes") -> None:
    ordered = found.parts[::-1]
    scale = scale_of(found.unit, [[found.own], *([one.low, one.high] for one in ordered)])
    for place, one in enumerate(ordered):
        low, high = scale.of([one.low, one.high])
        axes.fill_between([low, high], place - 0.3, place + 0.3, color=SERIES[0], alpha=0.55)
        for value, text, side in ((low, one.at_low, "right"), (high, one.at_high, "left")):
            gap = -3 if side == "right" else 3
            axes.annotate(
                text, (value, place), xytext=(gap, 0), textcoords="offset points", ha=side,
                va="center", fontsize=7.5,
            )  # fmt: skip
    axes.axvline(float(scale.of(found.own)), color=INK, linewidth=1.0)
    axes.set_yticks(range(len(ordered)), [one.factor for one in ordered])
    axes.set_xlabel(scale.label(found.measure))
    axes.set(xmargin=0.25)  # for the texts at the bars


def _indices(found: SobolIndices, sheet: Canvas, axes: "Axes") -> None:
    ordered = sorted(found, key=lambda one: one.total)
    places = np.arange(len(ordered))
    for shift, name, colour in ((0.15, "total", SERIES[1]), (-0.15, "first", SERIES[0])):
        for place, one in zip(places, ordered, strict=True):
            if (interval := getattr(one, f"{name}_interval")) is not None:
                axes.plot(interval, [place + shift] * 2, color=colour, linewidth=2)
        axes.plot(
            [getattr(one, name) for one in ordered], places + shift, "o", color=colour,
            label="first order" if name == "first" else name,
        )  # fmt: skip
    axes.axvline(0.0, color=INK, linewidth=0.8)
    axes.set_yticks(places, [one.factor for one in ordered])
    axes.set_xlabel(f"Sobol index of {found.measure}")
    beside(axes, axes.get_legend_handles_labels()[0])
