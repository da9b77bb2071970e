"""One quantity of several runs: their mean, and the band from the smallest to the largest."""

from collections.abc import Sequence
from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.model.network import Floats
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import look
from tissuec.view.plots.options import Option, Start, Stop
from tissuec.view.plots.over_time import Panel, TimeCurve, Window, draw_panels, say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.quantities import (
    QUANTITY,
    LoggedQuantity,
    behind_events,
    logs_of,
    quantity,
)
from tissuec.view.plots.subjects import PlotSubject

WIDTH, HEIGHT = 120.0, 70.0  # [mm]


class JoinedRuns(Struct, frozen=True, eq=False):
    """A quantity of several runs at the same times.

    Attributes:
        time: [s], shape (moment,).
        value: In the unit of the quantity, shape (run, moment).
        is_interpolated: Whether some run is logged at other times.
    """

    time: Floats
    value: Floats
    is_interpolated: bool


@PLOTS.member("envelope")
class Envelope(Struct, frozen=True):
    """Mean of a logged quantity over several runs, and the band that contains all of them.

    Attributes:
        envelope: The quantity.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    envelope: Annotated[
        str | None, Option(f"Mean and band of this over runs: {QUANTITY}.", "QUANTITY")
    ] = None
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of the mean and the band.

        Raises:
            TissueError: The quantity is missing or unknown, or runs have no common time.
        """
        if not self.envelope:
            raise TissueError(
                f"--envelope is missing: {QUANTITY}; {logs_of(subjects[0].content)}"
            )
        window = Window(self.start, self.stop)
        logs = [quantity(run.content, self.envelope).within(window) for run in subjects]
        both = common(logs)
        mean, band = both.value.mean(axis=0), (both.value.min(axis=0), both.value.max(axis=0))
        curve = TimeCurve("", both.time, mean, look(0), band)
        panel = Panel(logs[0].name, logs[0].unit, [curve], size=max(o.largest for o in logs))
        how = "their common times"
        if both.is_interpolated:
            how = f"the {len(both.time)} times of the finest log, the others interpolated"
        note = f"line: mean of {len(logs)} runs; band: smallest to largest; at {how}"

        def draw(sheet: Canvas) -> None:
            draw_panels(sheet, [panel], [])
            say_unfinished(sheet, subjects)
            sheet.tell("envelope", logs[0].name, {
                "unit": logs[0].unit, "runs": [run.name for run in subjects],
                "interpolated": both.is_interpolated, "time": both.time.tolist(),
                "mean": mean.tolist(), "low": band[0].tolist(), "high": band[1].tolist(),
            })  # fmt: skip

        return Picture(WIDTH, HEIGHT, draw, (note,))


def common(logs: Sequence[LoggedQuantity]) -> JoinedRuns:
    """Return quantities at the times of the finest log, as far as all of them reach.

    Raises:
        TissueError: There is no such time.
    """
    times, values = zip(*(behind_events(log) for log in logs), strict=True)
    if all(np.array_equal(time, times[0]) for time in times):
        return JoinedRuns(times[0], np.stack(values), is_interpolated=False)
    first, last = max(time[0] for time in times), min(time[-1] for time in times)
    finest = max(times, key=lambda time: int(((time >= first) & (time <= last)).sum()))
    shown = finest[(finest >= first) & (finest <= last)]
    if not len(shown):
        raise TissueError(f'the runs have no common time of "{logs[0].name}"')
    joined = [
        np.asarray(np.interp(shown, time, value), dtype=float)
        for time, value in zip(times, values, strict=True)
    ]
    return JoinedRuns(shown, np.stack(joined), is_interpolated=True)
