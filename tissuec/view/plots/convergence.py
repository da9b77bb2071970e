"""How a measure of a study converges while a factor is refined, with observed orders."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.studies.analysis.convergence import REFINED, ObservedOrder, refined_factor
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.scale import AxisUnit, scale_of
from tissuec.view.plots.study_axes import Along, FactorAxis, Measures, chosen_measures
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

WIDTH, PANEL, AROUND = 160.0, 75.0, 12.0  # [mm]


@PLOTS.member("convergence")
class Convergence(Struct, frozen=True):
    """Differences to the limit of a refinement, with the observed order of convergence.

    Attributes:
        measure: Measures; all if none is named.
        x: The refined factor, if it is not clear.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False

    measure: Measures = ()
    x: Along = None

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        try:
            refined = refined_factor(table)
        except ValueError:
            return False
        is_named = refined.name.split(" of ")[0] in REFINED
        return is_named and bool(table.measures) and len(set(refined.numbers.tolist())) >= 3

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: Nothing is refined at three levels or more.
        """
        table = subjects[0].content
        measures = chosen_measures(table, self.measure)
        try:
            refined = refined_factor(table, self.x)
            found = [table.orders(measure.name, refined.name) for measure in measures]
        except ValueError as error:
            raise TissueError(str(error)) from error

        def draw(sheet: Canvas) -> None:
            panels = sheet.figure.subplots(len(measures), 1, sharex=True, squeeze=False)[:, 0]
            for axes, measure, orders in zip(panels, measures, found, strict=True):
                _draw(axes, measure, orders)
            FactorAxis.of(refined).mark(panels[-1])
            sheet.note("p: observed order of the three finest levels that have one")
            if not table.finished.all():
                sheet.note(f"{int((~table.finished).sum())} runs failed and are left out")

        return Picture(WIDTH, AROUND + PANEL * len(measures), draw)


def _draw(axes: "Axes", measure: Column, orders: Sequence[ObservedOrder]) -> None:
    every = [_differences(one) for one in orders]
    scale = scale_of(measure.unit, every)
    for number, (one, values) in enumerate(zip(orders, every, strict=True)):
        axes.plot(
            one.levels, _shown(scale, values), marker=MARKERS[number % len(MARKERS)],
            markersize=4, label=_name(one), **look(number),
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", ylabel=scale.label(f"error of {measure.name}"))
    beside(axes, axes.get_legend_handles_labels()[0])


def _differences(one: ObservedOrder) -> np.ndarray:
    """Return distances to the limit, or where there is none to the finest level, (level,)."""
    goal = one.limit if np.isfinite(one.limit) else one.values[-1]
    return np.abs(one.values - goal)


def _shown(scale: AxisUnit, values: np.ndarray) -> np.ndarray:
    """Return numbers for a logarithmic axis, which has no zero."""
    return np.where(values > 0.0, scale.of(values), np.nan)


def _name(one: ObservedOrder) -> str:
    order = f"p = {one.order:.2f}" if np.isfinite(one.order) else "no order"
    return f"{', '.join(one.fixed)}: {order}" if one.fixed else order
