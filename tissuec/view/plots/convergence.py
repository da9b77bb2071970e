"""How a measure of a study converges while a factor is refined, with observed orders."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from tissuec.core.scale import AxisUnit, scale_of
from tissuec.studies.analysis.convergence import (
    REFINED,
    ObservedOrder,
    ObservedOrders,
    orders,
    refined_factor,
)
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_axes import Along, FactorAxis, chosen_measures
from tissuec.view.plots.study_plot import Panels, StudyPlot, together
from tissuec.view.plots.ticks import ticks_at

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes


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
