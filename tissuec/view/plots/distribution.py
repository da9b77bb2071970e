"""How a measure is distributed over the runs of a study: its quantiles, and a histogram."""

from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import scale_of
from tissuec.scene.study.entries import GRID, LIST, ONE_AT_A_TIME
from tissuec.studies.analysis.completed import values_of
from tissuec.studies.analysis.quantiles import Quantiles, quantiles, sample_of
from tissuec.studies.table import StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_axes import chosen_measures
from tissuec.view.plots.study_plot import Panels, StudyPlot, together

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
        return Panels([partial(_draw, sample, one) for one in found], notes)


def _draw(table: StudyTable, found: Quantiles, sheet: Canvas, axes: "Axes") -> None:
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
