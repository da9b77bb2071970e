"""How a measure is distributed over the runs of a study: its quantiles, and a histogram."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.scene.study_entries import GRID, ONE_AT_A_TIME
from tissuec.studies.analysis.samples import usable
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.study_axes import Measures, chosen_measures, scale_of_measure
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

WIDTH, PANEL, AROUND = 140.0, 55.0, 14.0  # [mm]


@PLOTS.member("distribution")
class DistributionPlot(Struct, frozen=True):
    """Histograms of measures over the runs of a random design, with quantiles.

    Attributes:
        measure: Measures; all if none is named.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False

    measure: Measures = ()

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        is_random = table.head.design not in (GRID, ONE_AT_A_TIME, "list")
        return is_random and len(table.factors) > 4 and bool(table.measures)

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: There is nothing to draw, or the runs are no sample.
        """
        table = subjects[0].content
        measures = chosen_measures(table, self.measure)
        try:
            table.quantiles(measures[0].name)
        except ValueError as error:
            raise TissueError(str(error)) from error

        def draw(sheet: Canvas) -> None:
            panels = sheet.figure.subplots(len(measures), 1, squeeze=False)[:, 0]
            for axes, measure in zip(panels, measures, strict=True):
                _draw(axes, table, measure)
            sheet.note("lines: 5, 25, 50, 75 and 95 % of the runs; bands: 95 % intervals")

        return Picture(WIDTH, AROUND + PANEL * len(measures), draw)


def _draw(axes: "Axes", table: StudyTable, measure: Column) -> None:
    rows = usable(table, measure)
    scale = scale_of_measure(measure, rows)
    counts, edges = np.histogram(scale.of(measure.numbers[rows]), bins="sturges")
    axes.fill_between(
        np.repeat(edges, 2)[1:-1], 0.0, np.repeat(counts, 2), color=SERIES[0], alpha=0.35
    )
    for quantile in table.quantiles(measure.name):
        axes.axvline(float(scale.of(quantile.value)), color=INK, linewidth=1.0)
        if np.isfinite([quantile.low, quantile.high]).all():
            low, high = scale.of([quantile.low, quantile.high])
            axes.axvspan(low, high, color=SERIES[1], alpha=0.15, linewidth=0.0)
    axes.set(xlabel=scale.label(measure.name), ylabel="runs")
