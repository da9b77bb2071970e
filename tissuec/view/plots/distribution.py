"""How factors and measures of a study are distributed: quantiles, histograms and scatter."""

from collections.abc import Sequence
from functools import partial
from itertools import product
from textwrap import fill
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import scale_of
from tissuec.model.network import Floats
from tissuec.scene.study.entries import GRID, LIST, ONE_AT_A_TIME
from tissuec.studies.analysis.completed import completed, values_of
from tissuec.studies.analysis.quantiles import Quantiles, quantiles, sample_of
from tissuec.studies.table import StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.study_plot import (
    FactorAxis,
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
