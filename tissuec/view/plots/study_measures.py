"""What a study measured: against its factors, and over time."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.palette import AMOUNT, GRID, INK, PAPER
from tissuec.core.scale import scale_of
from tissuec.model.network import Floats
from tissuec.scene.study import entries as study_entries
from tissuec.studies.analysis.completed import completed
from tissuec.studies.table import Column, MeasureCurve, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import MARKERS, beside, look
from tissuec.view.plots.options import Option
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
_MOST_CELLS = 10  # along a side, into which numbers fit


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
    for side, name, own in zip(sides, "xy", levels, strict=True):
        side.mark(axes, name)
        if _is_even(own):
            ticks: Any = axes.set_xticks if name == "x" else axes.set_yticks
            texts = [side.words[int(one)] if side.words else f"{one:.4g}" for one in own]
            ticks(range(len(own)), texts)
        elif _is_geometric(own):
            axes.set(**{f"{name}scale": "log"})
    if all(map(_is_even, levels)):
        _write_numbers(axes, values, mesh)


def _write_numbers(axes: "Axes", values: Floats, mesh: Any) -> None:
    """Write the numbers into the cells, shape (row, column)."""
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            dark = float(np.dot(mesh.cmap(mesh.norm(value))[:3], (0.3, 0.6, 0.1))) < 0.5
            axes.text(
                column, row, f"{value:.3g}", ha="center", va="center", fontsize=7.5,
                color=PAPER if dark else INK,
            )  # fmt: skip


def _is_even(levels: Floats) -> bool:
    """Return whether levels have cells of one size, beside which each number is written."""
    return len(levels) <= _MOST_CELLS


def _is_geometric(levels: Floats) -> bool:
    """Return whether ratios of levels are more alike than their differences."""
    if levels[0] <= 0.0:
        return False
    spread = (np.ptp(step) / step.mean() for step in map(np.diff, (np.log(levels), levels)))
    return bool(next(spread) < next(spread))


def _edges(levels: Floats) -> Floats:
    """Return the borders of the cells around levels, shape (level + 1,)."""
    if _is_even(levels):
        return np.linspace(-0.5, len(levels) - 0.5, len(levels) + 1)
    if _is_geometric(levels):
        return np.asarray(np.exp(_between(np.log(levels))), dtype=float)
    return _between(levels)


def _between(levels: Floats) -> Floats:
    middle = 0.5 * (levels[1:] + levels[:-1])
    return np.concatenate([[2 * levels[0] - middle[0]], middle, [2 * levels[-1] - middle[-1]]])


@PLOTS.member("study-curves")
class StudyCurves(StudyPlot, frozen=True):
    """Measures of a study over time: a curve for each run, coloured by the main factor.

    Attributes:
        measure: Measures over time; all if none is named.
        x: Another measure over time, on the horizontal axis.
    """

    width: ClassVar[float] = 170.0
    shares_x: ClassVar[bool] = True

    x: Annotated[str | None, Option("Measure over time on the horizontal axis.", "MEASURE")] = (
        None
    )

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind of plot suits a table best."""
        return bool(table.curves) and not table.measures

    def panels(self, table: StudyTable) -> Panels:
        """Return a panel for each measure.

        Raises:
            TissueError: There is no such measure over time, or none but that of the other axis.
        """
        curves = _chosen(table, self.measure)
        along = _chosen(table, [self.x])[0] if self.x else None
        if along is not None:
            curves = [one for one in curves if one.name != along.name]
            if not curves:
                raise TissueError(f'"{along.name}" is on the horizontal axis already')
        other = [one.name for one in curves if along and one.every != along.every]
        notes = [f"{name}: {self.x} has other times and is interpolated" for name in other]
        shown = [*curves, along] if along else curves
        return Panels(
            [partial(_draw, table, one, along) for one in curves],
            [*left_out(table, shown), *notes],
        )


def _chosen(table: StudyTable, names: Sequence[str]) -> list[MeasureCurve]:
    by_key = {key_of(curve.name): curve for curve in table.curves}
    if not by_key:
        raise TissueError(
            "nothing was measured over time; for example: measure force(hand) every 1 ms"
        )
    for name in names:
        if key_of(name) not in by_key:
            hint = alternatives(name, [one.name for one in table.curves], what="there are")
            raise TissueError(f'nothing called "{name}" was measured over time; {hint}')
    return [by_key[key_of(name)] for name in names] or list(table.curves)


def _draw(
    table: StudyTable,
    curve: MeasureCurve,
    along: MeasureCurve | None,
    sheet: Canvas,
    axes: "Axes",
) -> None:
    value = scale_of(curve.unit, [curve.values])
    x = scale_of("s", [curve.times]) if along is None else scale_of(along.unit, [along.values])
    axis = FactorAxis.of(factor_of(table, None)) if table.factors else None
    places = np.zeros(len(table)) if axis is None else axis.places()
    colours = _Colours(axis, places)
    for row in completed(table, curve).rows.tolist():
        where = curve.times if along is None else _at(along, row, curve.times)
        known = np.isfinite(curve.values[row]) & np.isfinite(where)
        values, looks = value.of(curve.values[row][known]), colours.of(float(places[row]))
        axes.plot(x.of(where[known]), values, lw=0.9, **looks)
    name = "time" if along is None else along.name
    axes.set(xlabel=x.label(name), ylabel=value.label(curve.name))
    if axis is not None and axis.words:
        beside(axes, [_sample(axes, number, word) for number, word in enumerate(axis.words)])
    elif axis is not None:
        sheet.figure.colorbar(colours.scale(), ax=axes, label=axis.label)


def _at(curve: MeasureCurve, row: int, times: Floats) -> Floats:
    """Return the values of a run at some times, NaN where it has none, shape (time,).

    Args:
        row: Row of the run.
        times: [s], shape (time,).
    """
    known = np.isfinite(curve.values[row])
    if not known.any():
        return np.full(len(times), np.nan)
    interpolated: Any = np.interp
    found = interpolated(times, curve.times[known], curve.values[row][known], np.nan, np.nan)
    return np.asarray(found, dtype=float)


def _sample(axes: "Axes", number: int, word: str) -> Any:
    return axes.plot([], [], label=word, **look(number))[0]


class _Colours:
    """Colours of runs by a factor: of words one each, of numbers from little to much."""

    def __init__(self, axis: FactorAxis | None, places: Any):
        self._words = () if axis is None else axis.words
        self._low, self._high = float(places.min()), float(places.max())

    def of(self, place: float) -> dict[str, Any]:
        """Return the look of a curve."""
        if self._words:
            return look(int(place))
        return {"color": self.scale().to_rgba(place)}

    def scale(self) -> Any:
        """Return matplotlib's scale of colours."""
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import LinearSegmentedColormap, Normalize

        colours = LinearSegmentedColormap.from_list("amount", list(AMOUNT[:-1]))
        return ScalarMappable(Normalize(self._low, self._high), colours)
