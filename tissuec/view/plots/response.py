"""Measures of a study against a factor: a curve for each combination of the others."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.scene.study_entries import GRID, LIST
from tissuec.studies.analysis.samples import usable
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.study_axes import (
    MOST_GROUPS,
    Along,
    FactorAxis,
    Measures,
    chosen_measures,
    factor_of,
    groups_of,
    scale_of_measure,
)
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

WIDTH, PANEL, AROUND = 160.0, 62.0, 12.0  # [mm]


@PLOTS.member("response")
class Response(Struct, frozen=True):
    """Measures of a study against one factor, with a curve for each combination of the others.

    Attributes:
        measure: Measures; all if none is named.
        x: The factor; the one with most numbers if not named.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False

    measure: Measures = ()
    x: Along = None

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        if table.head.design not in (GRID, LIST) or not table.measures or not table.factors:
            return False
        along = factor_of(table, None)
        others = [set(map(str, one.values)) for one in table.factors if one is not along]
        return int(np.prod([len(one) for one in others], dtype=object)) <= MOST_GROUPS

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: There is nothing to draw.
        """
        table = subjects[0].content
        measures, along = chosen_measures(table, self.measure), factor_of(table, self.x)
        axis = FactorAxis.of(along)

        def draw(sheet: Canvas) -> None:
            panels = sheet.figure.subplots(len(measures), 1, sharex=True, squeeze=False)[:, 0]
            for axes, measure in zip(panels, measures, strict=True):
                _draw(axes, table, measure, axis)
            axis.mark(panels[-1])
            handles = panels[0].get_legend_handles_labels()[0]
            if len(handles) > 1:
                beside(panels[0], handles)
            left_out = int((~table.finished).sum())
            if left_out:
                sheet.note(f"{left_out} of {len(table)} runs failed and are left out")

        groups_of(table, range(len(table)), [along])  # too many are told before drawing
        return Picture(WIDTH, AROUND + PANEL * len(measures), draw)


def _draw(axes: "Axes", table: StudyTable, measure: Column, axis: FactorAxis) -> None:
    rows = np.flatnonzero(usable(table, measure)).tolist()
    scale, places = scale_of_measure(measure, rows), axis.places()
    for number, (name, members) in enumerate(groups_of(table, rows, [axis.column]).items()):
        ordered = sorted(members, key=places.__getitem__)
        style: dict[str, Any] = look(number)
        axes.plot(
            places[ordered], scale.of(measure.numbers[ordered]), label=name,
            marker=MARKERS[number % len(MARKERS)], markersize=3.5, **style,
        )  # fmt: skip
    axes.set_ylabel(scale.label(measure.name))
