"""Errors of positions: estimates of steps, of the companion run, and the allowed error."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import look, plain
from tissuec.view.plots.frame_reader import largest_displacements
from tissuec.view.plots.options import Start, Stop
from tissuec.view.plots.over_time import Panel, TimeCurve, Window, picture_of
from tissuec.view.plots.page import Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.results.trajectory import Log, Trajectory

ESTIMATE, COMPANION = "estimated", "companion run"


@PLOTS.member("errors")
class Errors(Struct, frozen=True):
    """The error of positions over time: estimated, by the companion run, and allowed."""

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = False

    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        return picture_of([self.panel(subjects[0].content)], subjects, heights=(1.7,))

    def panel(self, trajectory: "Trajectory") -> Panel:
        """Return the curves that the result has.

        Raises:
            TissueError: The result has no errors.
        """
        held = {ESTIMATE: trajectory.errors, COMPANION: trajectory.companion}
        curves = [
            self._curve(name, log, number)
            for number, (name, log) in enumerate(held.items())
            if log is not None and len(log.time)
        ]
        if not curves:
            raise TissueError(
                f'"{trajectory.path}" has no errors; they are written with a trajectory: '
                "write output { trajectory every 20 ms } into the scene and run it again"
            )
        if (allowed := self._allowed(trajectory)) is not None:
            curves.append(allowed)
        return Panel("error of positions", "m", curves, is_log=True)

    def _curve(self, name: str, log: "Log", number: int) -> TimeCurve:
        rows = Window(self.start, self.stop).rows(log.time, f"the error {name}")
        return TimeCurve(name, log.time[rows], log.value[rows, 0], look(number))

    def _allowed(self, trajectory: "Trajectory") -> TimeCurve | None:
        """Return the allowed error; None where a fixed step promises nothing."""
        from tissuec.engine.execution.finer_run import USUAL
        from tissuec.engine.run_arrays import FLOOR

        manifest = trajectory.manifest
        if manifest.get("step") is not None or not len(trajectory.times):
            return None
        tolerance = float(manifest.get("tolerance") or USUAL)
        reach = np.maximum(largest_displacements(trajectory), FLOOR * trajectory.network.extent)
        rows = Window(self.start, self.stop).rows(trajectory.times, "the trajectory")
        return TimeCurve(
            f"allowed by {tolerance:g}",
            trajectory.times[rows],
            tolerance * reach[rows],
            plain(1),
        )
