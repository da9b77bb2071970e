"""What a study measured over time: a curve for each run, coloured by a factor."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.palette import AMOUNT
from tissuec.core.scale import scale_of
from tissuec.model.network import Floats
from tissuec.studies.analysis.completed import completed
from tissuec.studies.table import MeasureCurve, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import beside, look
from tissuec.view.plots.options import Option
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_plot import FactorAxis, Panels, StudyPlot, factor_of, left_out

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes


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

        Args:
            table: The table.

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
        curve: The measure.
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
