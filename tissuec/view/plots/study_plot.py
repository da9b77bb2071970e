"""What kinds of plot of a study share: axes, panels, and what they leave out."""

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.scale import AxisUnit, readable, scale_of
from tissuec.model.network import Floats
from tissuec.studies.analysis.completed import completed, measure_of
from tissuec.studies.table import Column, MeasureCurve, StudyTable
from tissuec.view.plots.options import Option
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

MOST_GROUPS = 14  # of runs, each with a curve or panel of its own

Measures = Annotated[tuple[str, ...], Option("Only this measure; may be repeated.", "MEASURE")]
Along = Annotated[str | None, Option("Factor on the horizontal axis.", "FACTOR")]
Across = Annotated[str | None, Option("Factor on the vertical axis.", "FACTOR")]


class FactorAxis(Struct, frozen=True, eq=False):
    """A factor along an axis.

    Attributes:
        column: The factor.
        words: Its values if they are words, in their order.
    """

    column: Column
    words: tuple[str, ...] = ()

    @classmethod
    def of(cls, column: Column) -> "FactorAxis":
        """Return the axis of a factor."""
        is_text = isinstance(column.values, tuple)
        return cls(column, tuple(dict.fromkeys(map(str, column.values))) if is_text else ())

    @property
    def label(self) -> str:
        """Return the label of the axis."""
        unit = readable(self.column.unit)
        return f"{self.column.name} [{unit}]" if unit else self.column.name

    def places(self) -> Floats:
        """Return the places of all rows: in the unit, or numbers of words, shape (row,)."""
        if self.words:
            return np.array([self.words.index(str(one)) for one in self.column.values], float)
        return self.column.numbers

    def mark(self, axes: "Axes", side: str = "x") -> None:
        """Label an axis, with words at their places.

        Args:
            side: "x" or "y".
        """
        axes.set(**{f"{side}label": self.label})
        if self.words:
            ticks: Any = axes.set_xticks if side == "x" else axes.set_yticks
            ticks(range(len(self.words)), self.words)


def chosen_measures(table: StudyTable, names: Sequence[str]) -> list[Column]:
    """Return the measures that are named, or all.

    Args:
        names: Of measures.

    Raises:
        TissueError: There is no such measure, or no run has a value of it.
    """
    try:
        chosen = [measure_of(table, name) for name in names] or list(table.measures)
    except ValueError as error:
        raise TissueError(str(error)) from error
    if not chosen:
        raise TissueError("the table has no measure with a single number for each run")
    known = [one for one in chosen if len(completed(table, one).rows)]
    if not known:
        names = ", ".join(f'"{one.name}"' for one in chosen)
        raise TissueError(f"no run that finished has a value of {names}")
    return known


def factor_of(table: StudyTable, name: str | None, *, apart: Column | None = None) -> Column:
    """Return a factor by its name, or the one with numbers that takes most of them.

    Args:
        name: Of the factor.
        apart: Another factor, which is not meant.

    Raises:
        TissueError: There is no such factor.
    """
    others = [factor for factor in table.factors if factor is not apart]
    if name is None:
        if not others:
            raise TissueError("the study has no further factor")
        return max(others, key=lambda one: (not isinstance(one.values, tuple), _levels(one)))
    for factor in others:
        if key_of(factor.name) == key_of(name):
            return factor
    hint = alternatives(name, [one.name for one in others], what="there are")
    raise TissueError(f'the table has no factor "{name}"; {hint}')


def _levels(column: Column) -> int:
    return len(
        set(column.values if isinstance(column.values, tuple) else column.values.tolist())
    )


def groups_of(
    table: StudyTable, rows: Sequence[int], apart: Sequence[Column]
) -> dict[str, list[int]]:
    """Return rows by the values of all factors but some, as texts.

    Args:
        rows: Numbers of rows.
        apart: Factors that are left out.

    Raises:
        TissueError: There are too many groups to distinguish.
    """
    others = [one for one in table.factors if all(one is not other for other in apart)]
    found: dict[str, list[int]] = {}
    for row in rows:
        name = ", ".join(f"{one.name} {one.text(row)}" for one in others)
        found.setdefault(name, []).append(row)
    if len(found) > MOST_GROUPS:
        raise TissueError(
            f"{len(found)} combinations of other factors cannot be distinguished (at most "
            f"{MOST_GROUPS}); use --kind scatter-matrix"
        )
    return found


def scale_of_measure(measure: Column, rows: Any) -> AxisUnit:
    """Return the unit that suits a measure in some rows.

    Args:
        rows: Numbers or a mask of rows, shape (n,) or (row,).
    """
    return scale_of(measure.unit, [measure.numbers[rows]])


#: Draws on axes of its own.
Panel = Callable[[Canvas, "Axes"], None]


def _nothing(sheet: Canvas, axes: "Sequence[Axes]") -> None:
    """Add nothing to the panels."""


class Panels(Struct, frozen=True):
    """Panels above one another.

    Attributes:
        draw: Draws each of them.
        notes: What there is to be said beside them, such as the runs that are left out.
        finish: Is given the sheet and all axes at the end.
    """

    draw: Sequence[Panel]
    notes: Sequence[str]
    finish: "Callable[[Canvas, Sequence[Axes]], None]" = _nothing


class StudyPlot(Struct, frozen=True):
    """A picture of the table of a study.

    Attributes:
        measure: Measures; all if none is named.
    """

    takes: ClassVar[str] = "table"
    several: ClassVar[bool] = False
    width: ClassVar[float] = 160.0  # [mm]
    panel: ClassVar[float] = 62.0  # height of each [mm]
    around: ClassVar[float] = 12.0  # of the height, all panels aside [mm]
    shares_x: ClassVar[bool] = False  # whether all panels have one horizontal axis

    measure: Measures = ()

    def panels(self, table: StudyTable) -> Panels:
        """Return the drawing of a table.

        Raises:
            TissueError: There is nothing to draw.
            ValueError: The study lacks what is requested.
        """
        raise NotImplementedError

    def height(self, table: StudyTable) -> float:
        """Return the height of a panel [mm]."""
        return self.panel

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a table.

        Raises:
            TissueError: There is nothing to draw.
        """
        table: StudyTable = subjects[0].content
        try:
            panels = self.panels(table)
        except ValueError as error:
            raise TissueError(str(error)) from error

        def draw(sheet: Canvas) -> None:
            count = len(panels.draw)
            grid = sheet.figure.subplots(count, 1, sharex=self.shares_x, squeeze=False)[:, 0]
            for axes, one in zip(grid, panels.draw, strict=True):
                one(sheet, axes)
            panels.finish(sheet, grid)

        height = self.around + self.height(table) * len(panels.draw)
        return Picture(self.width, height, draw, tuple(panels.notes))


def left_out(table: StudyTable, shown: Iterable[Column | MeasureCurve]) -> list[str]:
    """Return which runs a picture leaves out.

    Args:
        shown: Measures and curves in the picture.
    """
    found = {one.name: completed(table, one).left_out for one in shown}
    return together({name: [str(one)] if one.count else [] for name, one in found.items()})


def together(notes: dict[str, list[str]]) -> list[str]:
    """Return notes on several measures: with their names, but once where all are alike.

    Args:
        notes: By the names of the measures.
    """
    all_notes = list(notes.values())
    if all(one == all_notes[0] for one in all_notes):
        return all_notes[0]
    return [f"{name}: {note}" for name, some in notes.items() for note in some]
