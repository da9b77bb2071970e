"""Logs over time: forces with their components, lengths, pressures, …"""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError, counted
from tissuec.core.hints import alternatives
from tissuec.core.scale import largest_of
from tissuec.core.structs import replace
from tissuec.model.network import Floats
from tissuec.results.recording import AXES, TENSOR
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import look, plain
from tissuec.view.plots.options import Option, Start, Stop
from tissuec.view.plots.over_time import Panel, TimeCurve, Window, picture_of
from tissuec.view.plots.page import Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.results.trajectory import Log, Trajectory

MOST_PANELS = 16
MOST_COLUMNS = 4  # of single springs; of more the smallest and the largest are shown
UNSEEN = 1e-3  # of the largest component: a curve of it would look like one of zeros
NOTHING = 1e-9  # of the largest component: one that is smaller is not there


@PLOTS.member("logs")
class LogsPlot(Struct, frozen=True):
    """Forces, and what else a scene logs, over time; vectors with components and magnitude.

    Attributes:
        log: Only these; all if none is named.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    log: Annotated[
        tuple[str, ...],
        Option('Only this log, such as "force of forceps A"; may be repeated.', "NAME"),
    ] = ()
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        panels, notes = self.panels(subjects)
        return picture_of(panels, subjects, notes=notes)

    def panels(self, runs: Sequence[PlotSubject]) -> tuple[list[Panel], list[str]]:
        """Return the artists, and notes on what is not drawn."""
        panels: list[Panel] = []
        notes: list[str] = []
        for name in self._names(runs):
            held = {run: run.content.logs[name] for run in runs if name in run.content.logs}
            notes += [f'{run.name} has no log "{name}"' for run in runs if run not in held]
            if len(runs) == 1:
                panels += self._of_one(name, *held.values())
                notes += _left_out(name, *held.values())
            else:
                panels += self._of_several(name, runs, held)
        if len(panels) > MOST_PANELS:
            left = len(panels) - MOST_PANELS
            notes.append(f"{counted(left, 'panel')} omitted; select logs to see others")
        return panels[:MOST_PANELS], notes

    def _names(self, runs: Sequence[PlotSubject]) -> list[str]:
        """Return which logs are shown, in the order of the scenes."""
        every = list(dict.fromkeys(name for run in runs for name in run.content.logs))
        if not every:
            raise TissueError(_no_logs(runs[0].content))
        chosen: list[str] = []
        for wanted in self.log:
            found = log_called(wanted, every)
            if found is None:
                hint = alternatives(wanted, every, what="there are")
                raise TissueError(f'there is no log "{wanted}"; {hint}')
            chosen.append(found)
        # One that an unfinished run has not come to is left out, unless it is requested.
        begun = [name for name in every if any(_has_rows(run, name) for run in runs)]
        return chosen or begun or every

    def _cut(self, log: "Log") -> tuple[Floats, Floats]:
        """Return the times [s] and rows that are shown, with both sides of events."""
        time, value = log.with_jumps()
        rows = Window(self.start, self.stop).rows(time, f'the log "{log.name}"')
        return time[rows], value[rows]

    def _of_one(self, name: str, log: "Log") -> list[Panel]:
        time, value = self._cut(log)
        if log.columns == AXES:
            curves = _vector(name, time, value)
            if len(curves) == 1 and curves[0].name:  # the name says along what
                name = f"{name} along {curves[0].name}"
                curves = [replace(curves[0], name="", looks=look(0))]
            return [Panel(name, log.unit, curves, size=log.largest)]
        if len(log.columns) <= MOST_COLUMNS:
            names = [_column(column) if len(log.columns) > 1 else "" for column in log.columns]
            curves = [TimeCurve(n, time, value[:, k], look(k)) for k, n in enumerate(names)]
            return [Panel(name, log.unit, curves, size=log.largest)]
        low, high = np.fmin.reduce(value, axis=1), np.fmax.reduce(value, axis=1)
        curves = [
            TimeCurve("largest", time, high, look(0), (low, high)),
            TimeCurve("smallest", time, low, look(1)),
        ]
        name = f"{name}, {len(log.columns)} values"
        return [Panel(name, log.unit, curves, size=log.largest)]

    def _of_several(
        self, name: str, runs: Sequence[PlotSubject], held: "dict[PlotSubject, Log]"
    ) -> list[Panel]:
        """Return a panel for each component, with a curve for each run."""
        parts: dict[str, list[TimeCurve]] = {}
        unit = next(iter(held.values())).unit
        for number, run in enumerate(runs):
            if run in held:
                for part, time, value in self._parts(name, held[run]):
                    curves = parts.setdefault(part, [])
                    curves.append(TimeCurve("", time, value, look(number)))
        sizes = {part: _size(curves) for part, curves in parts.items()}
        largest = max(sizes.values())
        shown = [part for part in parts if sizes[part] > NOTHING * largest] or list(parts)[:1]
        # Components have the same unit, whatever part of them is shown.
        size = max(log.largest for log in held.values())
        return [Panel(f"{name} {part}".strip(), unit, parts[part], size=size) for part in shown]

    def _parts(self, name: str, log: "Log") -> list[tuple[str, Floats, Floats]]:
        time, value = self._cut(log)
        if log.columns == AXES:
            parts = [(f"along {axis}", time, value[:, k]) for k, axis in enumerate(AXES)]
            if is_place(name):
                return parts
            return [("(magnitude)", time, np.linalg.norm(value, axis=1)), *parts]
        if len(log.columns) == 1:
            return [("", time, value[:, 0])]
        if log.columns == TENSOR:
            return [(column, time, value[:, k]) for k, column in enumerate(TENSOR)]
        return [("(largest)", time, np.fmax.reduce(value, axis=1))]


def _has_rows(run: PlotSubject, name: str) -> bool:
    return name in run.content.logs and len(run.content.logs[name].time) > 0


def log_called(wanted: str, names: Iterable[str]) -> str | None:
    """Return the name of a log that is written in any case; None if there is no such log."""
    return next((name for name in names if name.lower() == wanted.lower()), None)


def is_place(name: str) -> bool:
    """Return whether a log is of positions, whose distance from the origin has no meaning."""
    return name.startswith("position of ")


def _vector(name: str, time: Floats, value: Floats) -> list[TimeCurve]:
    """Return the components that are there, and their magnitude if that says more."""
    present = _present(name, value)
    curves = [TimeCurve(AXES[k], time, value[:, k], look(k)) for k in present]
    if is_place(name):
        return curves or [TimeCurve("", time, value[:, 0], look(0))]
    if len(present) == 1:
        return curves
    magnitude = np.linalg.norm(value, axis=1)
    looks = plain() | {"linewidth": 1.6, "alpha": 0.85, "zorder": 1.9}
    return [TimeCurve("magnitude" if present else "", time, magnitude, looks), *curves]


def _present(name: str, value: Floats) -> list[int]:
    """Return which components of a vector are drawn: those that can be seen beside the largest.

    Args:
        value: Shape (row, 3).
    """
    sizes = np.abs(np.where(np.isfinite(value), value, 0.0)).max(axis=0, initial=0.0)
    least = NOTHING if is_place(name) else UNSEEN
    return [k for k in range(3) if sizes[k] > least * sizes.max()]


def _left_out(name: str, log: "Log") -> list[str]:
    """Return which components are left out, as notes; none where nothing is there at all."""
    if log.columns != AXES or is_place(name):
        return []
    present = _present(name, log.value)
    missing = [AXES[k] for k in range(3) if k not in present]
    if not present or not missing:
        return []
    what = "component" if len(missing) == 1 else "components"
    return [
        f"{name}: {what} {' and '.join(missing)} below {UNSEEN:.1%} of the largest".replace(
            "%", " %"
        )
    ]


def _column(column: str | int) -> str:
    return f"spring {column}" if isinstance(column, int) else str(column)


def _size(curves: Sequence[TimeCurve]) -> float:
    return largest_of(curve.value for curve in curves)


def _no_logs(trajectory: "Trajectory") -> str:
    """Return the contents of a result without logs, and how to get logs."""
    frames = len(trajectory.times)
    held = [counted(frames, "frame")] if frames else []
    held += ["energies"] if trajectory.energies is not None else []
    has = f"; it has {' and '.join(held)}" if held else ""
    bodies = trajectory.network.bodies
    what = f"force of {bodies[0].name}" if bodies else "energy"
    return (
        f'"{trajectory.path}" has no logs{has}; write output {{ {what} every 1 ms }}, or '
        "another measure, into the scene and run it again"
    )
