"""A result on one page: some frames, its logs, and the energies."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any, ClassVar

from msgspec import Struct

from tissuec.core.errors import TissueError, counted
from tissuec.results.promise import stepping
from tissuec.view.plots import PLOTS
from tissuec.view.plots.energies import EnergyPlot
from tissuec.view.plots.frames import FramesPlot
from tissuec.view.plots.logs import LogsPlot
from tissuec.view.plots.options import Direction
from tissuec.view.plots.over_time import WIDTH, Panel, picture_of
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.results.trajectory import Trajectory

MOST_LOGS = 4
HEAD = 12.0  # [mm]
_LINE = 96  # letters in a line of it


@PLOTS.member("overview")
class Overview(Struct, frozen=True):
    """Some frames, what was logged and the energies of one run on one page.

    Attributes:
        view: As for frames.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = False

    view: Direction = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a result.

        Raises:
            TissueError: It has neither frames nor logs nor energies.
        """
        parts = self._parts(subjects)
        if not parts:
            raise TissueError(
                f'"{subjects[0].content.path}" has neither frames nor logs nor energies; '
                "write output { trajectory every 20 ms } into the scene and run it again"
            )

        head = fill(_head(subjects[0]), _LINE)

        def draw(sheet: Canvas) -> None:
            heights = [part.height for part in parts]
            figures = sheet.figure.subfigures(
                len(parts), 1, height_ratios=heights, squeeze=False
            )
            for figure, part in zip(figures[:, 0], parts, strict=True):
                part.on(sheet.part(figure))
            sheet.figure.suptitle(head, x=0.01, ha="left", fontsize=9)

        return Picture(WIDTH, HEAD + sum(part.height for part in parts), draw)

    def _parts(self, subjects: Sequence[PlotSubject]) -> list[Picture]:
        """Return the pictures of what the result has, from above."""
        trajectory: Trajectory = subjects[0].content
        parts: list[Picture] = []
        panels: list[Panel] = []
        notes: list[str] = []
        if len(trajectory.times):
            parts.append(FramesPlot(view=self.view).picture(subjects))
        if any(len(log.time) for log in trajectory.logs.values()):
            names = [name for name, log in trajectory.logs.items() if len(log.time)]
            panels, notes = LogsPlot(log=_telling(names)).panels(subjects)
            if len(names) > MOST_LOGS:
                left = counted(len(names) - MOST_LOGS, "log")
                notes.append(f"{left} more: tissuec plot {trajectory.path} --kind logs")
        heights = [0.9] * len(panels)
        if trajectory.energies is not None and len(trajectory.energies.time):
            panels += EnergyPlot().panels(subjects)[:1]
            heights.append(1.1)
        if panels:
            parts.append(picture_of(panels, subjects, notes=notes, heights=heights))
        return parts


def _telling(names: Sequence[str]) -> tuple[str, ...]:
    """Return a few logs, forces before others, in the order of the scene."""
    forces = [name for name in names if name.startswith("force of ")]
    chosen = [*forces, *(name for name in names if name not in forces)][:MOST_LOGS]
    return tuple(name for name in names if name in chosen)


def _head(subject: PlotSubject) -> str:
    """Return the heading of a page: scene, size, method and outcome."""
    trajectory: Any = subject.content
    network, manifest = trajectory.network, trajectory.manifest
    facts = [
        str(network.size),
        stepping(manifest),
        *manifest.get("overrides", ()),
        trajectory.outcome,
    ]
    return f"{subject.name}   ({'; '.join(fact for fact in facts if fact)})"
