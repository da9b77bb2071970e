"""Measures of a study against factors: against one as curves, against two as colours."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tissuec.core.palette import AMOUNT, GRID
from tissuec.model.network import Floats
from tissuec.scene.study import entries as study_entries
from tissuec.studies.analysis.completed import completed
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_plot import (
    MOST_GROUPS,
    Across,
    Along,
    FactorAxis,
    Panels,
    StudyPlot,
    chosen_measures,
    factor_of,
    groups_of,
    left_out,
    scale_of_measure,
)

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
        if (
            table.head.design not in (study_entries.GRID, study_entries.LIST)
            or not table.measures
            or not table.factors
        ):
            return False
        along = factor_of(table, None)
        others = [set(map(str, one.values)) for one in table.factors if one is not along]
        return int(np.prod([len(one) for one in others], dtype=object)) <= MOST_GROUPS

    def panels(self, table: StudyTable) -> Panels:
        measures = chosen_measures(table, self.measure)
        axis = FactorAxis.of(factor_of(table, self.x))
        groups_of(table, range(len(table)), [axis.column])  # too many are an error before
        draw = [partial(_draw_curves, table, measure, axis) for measure in measures]
        return Panels(draw, left_out(table, measures), partial(_finish, axis))


def _draw_curves(
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


FEWEST = 5  # numbers of each factor


@PLOTS.member("heat-map")
class HeatMap(StudyPlot, frozen=True):
    """A measure of a study over two factors, as colours; a panel for each value of others.

    Attributes:
        measure: The measure; the first one if none is named.
        x, y: The factors; those with most numbers if not named.
    """

    width: ClassVar[float] = 150.0
    panel: ClassVar[float] = 80.0

    x: Along = None
    y: Across = None

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        is_grid = table.head.design == study_entries.GRID and len(table.factors) == 2
        return is_grid and bool(table.measures) and all(map(_is_fine, table.factors))

    def panels(self, table: StudyTable) -> Panels:
        measure = chosen_measures(table, self.measure)[0]
        along = factor_of(table, self.x)
        across = factor_of(table, self.y, apart=along)
        groups = groups_of(table, completed(table, measure).rows.tolist(), [along, across])
        sides = FactorAxis.of(along), FactorAxis.of(across)
        draw = [partial(_draw_map, measure, *one, sides) for one in groups.items()]
        return Panels(draw, left_out(table, [measure]))


def _is_fine(factor: Column) -> bool:
    """Return whether a factor has enough numbers for a picture rather than curves."""
    is_numeric = not isinstance(factor.values, tuple)
    return is_numeric and len(set(factor.numbers.tolist())) >= FEWEST


def _draw_map(
    measure: Column,
    name: str,
    rows: Sequence[int],
    sides: tuple[FactorAxis, FactorAxis],
    sheet: Canvas,
    axes: "Axes",
) -> None:
    from matplotlib.colors import LinearSegmentedColormap

    axes.set_title(name)
    scale = scale_of_measure(measure, rows)
    x, y = (side.places() for side in sides)
    levels = np.unique(x[rows]), np.unique(y[rows])
    values = np.full((len(levels[1]), len(levels[0])), np.nan)
    values[np.searchsorted(levels[1], y[rows]), np.searchsorted(levels[0], x[rows])] = scale.of(
        measure.numbers[rows]
    )
    colours: Any = LinearSegmentedColormap.from_list("amount", list(AMOUNT))
    axes.set_facecolor(GRID)  # of runs without a value
    axes.grid(visible=False)
    mesh = axes.pcolormesh(*map(_edges, levels), np.ma.masked_invalid(values), cmap=colours)
    sheet.figure.colorbar(mesh, ax=axes, label=scale.label(measure.name))
    for side, name in zip(sides, "xy", strict=True):
        side.mark(axes, name)


def _edges(levels: Floats) -> Floats:
    """Return the borders of the cells around levels, shape (level + 1,)."""
    if len(levels) == 1:
        return np.array([levels[0] - 0.5, levels[0] + 0.5])
    middle = 0.5 * (levels[1:] + levels[:-1])
    return np.concatenate([[2 * levels[0] - middle[0]], middle, [2 * levels[-1] - middle[-1]]])
