"""What a study measured over time: a curve for each run, coloured by a factor."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError, alternatives
from tissuec.core.names import key_of
from tissuec.core.palette import AMOUNT
from tissuec.studies.table import Curve, StudyTable
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import beside, look
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.scale import scale_of
from tissuec.view.plots.study_axes import FactorAxis, Measures, factor_of
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

WIDTH, PANEL, AROUND = 170.0, 62.0, 12.0  # [mm]


@PLOTS.member("study-curves")
class StudyCurves(Struct, frozen=True):
    """Measures of a study over time: a curve for each run, coloured by the main factor.

    Attributes:
        measure: Measures over time; all if none is named.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False

    measure: Measures = ()

    @staticmethod
    def suits(table: StudyTable) -> bool:
        """Return whether this kind tells most about a table."""
        return bool(table.curves) and not table.measures

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: Nothing was measured over time.
        """
        table = subjects[0].content
        curves = _chosen(table, self.measure)

        def draw(sheet: Canvas) -> None:
            panels = sheet.figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
            for axes, curve in zip(panels, curves, strict=True):
                _draw(sheet, axes, table, curve)

        return Picture(WIDTH, AROUND + PANEL * len(curves), draw)


def _chosen(table: StudyTable, names: Sequence[str]) -> list[Curve]:
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


def _draw(sheet: Canvas, axes: "Axes", table: StudyTable, curve: Curve) -> None:
    value, time = scale_of(curve.unit, [curve.values]), scale_of("s", [curve.times])
    axis = FactorAxis.of(factor_of(table, None)) if table.factors else None
    places = np.zeros(len(table)) if axis is None else axis.places()
    colours = _Colours(axis, places)
    for row, values in enumerate(curve.values):
        known = np.isfinite(values)
        if known.any():
            looks = colours.of(places[row])
            axes.plot(time.of(curve.times[known]), value.of(values[known]), lw=0.9, **looks)
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
