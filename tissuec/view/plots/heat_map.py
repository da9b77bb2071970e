"""A measure of a study over two factors, as colours."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.palette import AMOUNT, GRID
from tissuec.model.network import Floats
from tissuec.scene import study_entries
from tissuec.studies.analysis.samples import usable
from tissuec.studies.table import Column, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.study_axes import (
    Across,
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

WIDTH, PANEL, AROUND = 150.0, 80.0, 12.0  # [mm]
FEWEST = 5  # numbers of each factor


@PLOTS.member("heat-map")
class HeatMap(Struct, frozen=True):
    """A measure of a study over two factors, as colours; a panel for each value of others.

    Attributes:
        measure: Measures; the first one if none is named.
        x, y: The factors; those with most numbers if not named.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False

    measure: Measures = ()
    x: Along = None
    y: Across = None

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        is_grid = table.head.design == study_entries.GRID and len(table.factors) == 2
        return is_grid and bool(table.measures) and all(map(_is_fine, table.factors))

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: There is nothing to draw.
        """
        table = subjects[0].content
        measure = chosen_measures(table, self.measure)[0]
        along = factor_of(table, self.x)
        across = factor_of(table, self.y, apart=along)
        rows = np.flatnonzero(usable(table, measure)).tolist()
        groups = groups_of(table, rows, [along, across])
        sides = FactorAxis.of(along), FactorAxis.of(across)

        def draw(sheet: Canvas) -> None:
            panels = sheet.figure.subplots(len(groups), 1, squeeze=False)[:, 0]
            for axes, (name, members) in zip(panels, groups.items(), strict=True):
                axes.set_title(name)
                _draw(sheet, axes, measure, members, sides)

        return Picture(WIDTH, AROUND + PANEL * len(groups), draw)


def _is_fine(factor: Column) -> bool:
    """Return whether a factor has enough numbers for a picture rather than curves."""
    is_numeric = not isinstance(factor.values, tuple)
    return is_numeric and len(set(factor.numbers.tolist())) >= FEWEST


def _draw(
    sheet: Canvas,
    axes: "Axes",
    measure: Column,
    rows: Sequence[int],
    sides: tuple[FactorAxis, FactorAxis],
) -> None:
    from matplotlib.colors import LinearSegmentedColormap

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
