"""What a study measured over time: a curve for each run, coloured by a factor."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.palette import AMOUNT
from tissuec.core.scale import scale_of
from tissuec.studies.analysis.completed import completed
from tissuec.studies.table import MeasureCurve, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import beside, look
from tissuec.view.plots.page import Canvas
from tissuec.view.plots.study_axes import FactorAxis, factor_of
from tissuec.view.plots.study_plot import Panels, StudyPlot, left_out

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes


@PLOTS.member("study-curves")
class StudyCurves(StudyPlot, frozen=True):
    """Measures of a study over time: a curve for each run, coloured by the main factor.

    Attributes:
        measure: Measures over time; all if none is named.
    """

    width: ClassVar[float] = 170.0
    shares_x: ClassVar[bool] = True

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        return bool(table.curves) and not table.measures

    def panels(self, table: StudyTable) -> Panels:
        curves = _chosen(table, self.measure)
        return Panels([partial(_draw, table, one) for one in curves], left_out(table, curves))


def _chosen(table: StudyTable, names: Sequence[str]) -> list[MeasureCurve]:
    by_key = {key_of(curve.name): curve for curve in table.curves}
    if not by_key:
        raise TissueError(
            "nothing was measured over time; for example: measure force of hand every 1 ms"
        )
    for name in names:
        if key_of(name) not in by_key:
            hint = alternatives(name, [one.name for one in table.curves], what="there are")
            raise TissueError(f'nothing called "{name}" was measured over time; {hint}')
    return [by_key[key_of(name)] for name in names] or list(table.curves)


def _draw(table: StudyTable, curve: MeasureCurve, sheet: Canvas, axes: "Axes") -> None:
    value, time = scale_of(curve.unit, [curve.values]), scale_of("s", [curve.times])
    axis = FactorAxis.of(factor_of(table, None)) if table.factors else None
    places = np.zeros(len(table)) if axis is None else axis.places()
    colours = _Colours(axis, places)
    for row in completed(table, curve).rows.tolist():
        known, looks = np.isfinite(curve.values[row]), colours.of(float(places[row]))
        values = value.of(curve.values[row][known])
        axes.plot(time.of(curve.times[known]), values, lw=0.9, **looks)
    axes.set(xlabel=time.label("time"), ylabel=value.label(curve.name))
    if axis is not None and axis.words:
        beside(axes, [_sample(axes, number, word) for number, word in enumerate(axis.words)])
    elif axis is not None:
        sheet.figure.colorbar(colours.scale(), ax=axes, label=axis.label)


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
