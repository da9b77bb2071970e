"""Which factors of a study move a measure: ranges one at a time, or Sobol indices, as bars."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import scale_of
from tissuec.scene.study.entries import INDICES, ONE_AT_A_TIME
from tissuec.studies.analysis.effects import Effects, effects
from tissuec.studies.analysis.sobol import SobolIndices, sobol_indices
from tissuec.studies.table import StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import beside
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_axes import chosen_measures
from tissuec.view.plots.study_plot import Panel, Panels, StudyPlot, together

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

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
