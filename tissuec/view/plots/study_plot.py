"""What kinds of plot of a study share: panels above one another, and what they leave out."""

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, ClassVar

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.studies.analysis.completed import completed
from tissuec.studies.table import Column, MeasureCurve, StudyTable
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.study_axes import Measures
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

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
        table: The table.
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
