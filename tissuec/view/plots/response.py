"""Measures of a study against a factor: a curve for each combination of the others."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tissuec.scene.study.entries import GRID, LIST
from tissuec.studies.analysis.completed import completed
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_axes import (
    MOST_GROUPS,
    Along,
    FactorAxis,
    chosen_measures,
    factor_of,
    groups_of,
    scale_of_measure,
)
from tissuec.view.plots.study_plot import Panels, StudyPlot, left_out

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes


@PLOTS.member("response")
class ResponsePlot(StudyPlot, frozen=True):
    """Measures of a study against one factor, with a curve for each combination of the others.

    Attributes:
        x: The factor; the one with most numbers if not named.
    """

    shares_x: ClassVar[bool] = True

    x: Along = None

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        if table.head.design not in (GRID, LIST) or not table.measures or not table.factors:
            return False
        along = factor_of(table, None)
        others = [set(map(str, one.values)) for one in table.factors if one is not along]
        return int(np.prod([len(one) for one in others], dtype=object)) <= MOST_GROUPS

    def panels(self, table: StudyTable) -> Panels:
        measures = chosen_measures(table, self.measure)
        axis = FactorAxis.of(factor_of(table, self.x))
        groups_of(table, range(len(table)), [axis.column])  # too many are an error before
        draw = [partial(_draw, table, measure, axis) for measure in measures]
        return Panels(draw, left_out(table, measures), partial(_finish, axis))


def _draw(
    table: StudyTable, measure: Column, axis: FactorAxis, sheet: Canvas, axes: "Axes"
) -> None:
    rows = completed(table, measure).rows
    scale, places = scale_of_measure(measure, rows), axis.places()
    values = np.full(len(table), np.nan)  # which interrupt a curve where a run is left out
    values[rows] = scale.of(measure.numbers[rows])
    groups = groups_of(table, range(len(table)), [axis.column])
    for number, (name, members) in enumerate(groups.items()):
        ordered = sorted(members, key=places.__getitem__)
        style: dict[str, Any] = look(number)
        axes.plot(
            places[ordered], values[ordered], label=name,
            marker=MARKERS[number % len(MARKERS)], markersize=3.5, **style,
        )  # fmt: skip
    axes.set_ylabel(scale.label(measure.name))


def _finish(axis: FactorAxis, sheet: Canvas, panels: "Sequence[Axes]") -> None:
    axis.mark(panels[-1])
    handles = panels[0].get_legend_handles_labels()[0]
    if len(handles) > 1:
        beside(panels[0], handles)
