"""Which factors of a study move a measure: ranges one at a time, or Sobol indices, as bars."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.scene.study_entries import INDICES, ONE_AT_A_TIME
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import beside
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.scale import scale_of
from tissuec.view.plots.study_axes import Measures, chosen_measures
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

WIDTH, BAR, AROUND = 160.0, 9.0, 22.0  # [mm]


@PLOTS.member("tornado")
class Tornado(Struct, frozen=True):
    """Effects of factors on measures: ranges of one at a time, or Sobol indices.

    Attributes:
        measure: Measures; all if none is named.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False

    measure: Measures = ()

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        return table.head.design in (INDICES, ONE_AT_A_TIME) and bool(table.measures)

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: The design of the study tells nothing of single factors.
        """
        table = subjects[0].content
        if not Tornado.suits(table):
            raise TissueError(
                f'a tornado needs the design "{ONE_AT_A_TIME}" or "{INDICES}"; this study has '
                f'"{table.head.design}"'
            )
        measures = chosen_measures(table, self.measure)
        drawing = _indices if table.head.design == INDICES else _ranges

        def draw(sheet: Canvas) -> None:
            panels = sheet.figure.subplots(len(measures), 1, squeeze=False)[:, 0]
            for axes, measure in zip(panels, measures, strict=True):
                try:
                    drawing(sheet, axes, table, measure)
                except ValueError as error:
                    axes.text(0.02, 0.5, str(error), transform=axes.transAxes)

        height = (AROUND + BAR * len(table.factors)) * len(measures)
        return Picture(WIDTH, height, draw)


def _ranges(sheet: Canvas, axes: "Axes", table: StudyTable, measure: Column) -> None:
    own, effects = table.effects(measure.name)
    scale = scale_of(measure.unit, [[own], *([one.low, one.high] for one in effects)])
    for place, one in enumerate(reversed(effects)):
        low, high = scale.of([one.low, one.high])
        axes.fill_between([low, high], place - 0.3, place + 0.3, color=SERIES[0], alpha=0.55)
        for value, text, side in ((low, one.at_low, "right"), (high, one.at_high, "left")):
            gap = -3 if side == "right" else 3
            axes.annotate(
                text, (value, place), xytext=(gap, 0), textcoords="offset points", ha=side,
                va="center", fontsize=7.5,
            )  # fmt: skip
    axes.axvline(float(scale.of(own)), color=INK, linewidth=1.0)
    axes.set_yticks(range(len(effects)), [one.factor for one in reversed(effects)])
    axes.set_xlabel(scale.label(measure.name))
    axes.set(xmargin=0.25)  # for the texts at the bars
    sheet.note("the line is the scene as written")


def _indices(sheet: Canvas, axes: "Axes", table: StudyTable, measure: Column) -> None:
    found = table.sobol_indices(measure.name)
    ordered = sorted(found.factors, key=lambda one: one.total)
    places = np.arange(len(ordered))
    for shift, name, colour in ((0.15, "total", SERIES[1]), (-0.15, "first", SERIES[0])):
        for place, one in zip(places, ordered, strict=True):
            axes.plot(
                getattr(one, f"{name}_interval"), [place + shift] * 2, color=colour, linewidth=2
            )
        axes.plot(
            [getattr(one, name) for one in ordered], places + shift, "o", color=colour,
            label="first order" if name == "first" else name,
        )  # fmt: skip
    axes.axvline(0.0, color=INK, linewidth=0.8)
    axes.set_yticks(places, [one.factor for one in ordered])
    axes.set_xlabel(f"Sobol index of {measure.name}")
    beside(axes, axes.get_legend_handles_labels()[0])
    if found.left_out:
        total = found.used + found.left_out
        sheet.note(f"{found.left_out} of {total} base runs are left out: a run of them failed")
