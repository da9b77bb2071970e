"""Accuracy over time: energies with their balance error, and errors of positions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.model.network import Floats
from tissuec.results.recording import ENERGIES
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import DASHES, look, plain
from tissuec.view.plots.frame_reader import largest_displacements
from tissuec.view.plots.options import Option, Start, Stop
from tissuec.view.plots.over_time import Panel, TimeCurve, Window, picture_of
from tissuec.view.plots.page import Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.results.trajectory import Log, Trajectory

#: What is stacked, from below: what the energy has become.
STACK = ("elastic", "kinetic", "gravity", "dissipated")
_SERIES = dict(zip(STACK, (0, 1, 3, 6), strict=True))
_SHARE = 1e-6  # of the largest energy: what is less is rounding
SUPPLY = "supplied"
DRIFT = "energy drift"
LATER = ("dissipated", SUPPLY)


class EnergySeries(NamedTuple):
    """The energies of a run [J], each of shape (moment,).

    Attributes:
        parts: By the names of the columns; gravity from its lowest.
        supply: What was there at first, and what work and events put in since.
        error: What is there and should not be, over the largest energy so far.
    """

    time: Floats
    parts: dict[str, Floats]
    supply: Floats
    error: Floats


@PLOTS.member("energies")
class EnergyPlot(Struct, frozen=True):
    """Energies over time: a stack that reaches what was put in, and how far it fails to.

    Attributes:
        lines: Whether each energy has a line instead.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = True

    lines: Annotated[bool, Option("Draw a line for each energy instead of a stack.")] = False
    start: Start = None
    stop: Stop = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        heights = (1.7, 0.9) if len(subjects) == 1 else ()
        return picture_of(self.panels(subjects), subjects, heights=heights)

    def panels(self, runs: Sequence[PlotSubject]) -> list[Panel]:
        """Return the energies, and below them the error of the books."""
        known = {run: self._books(run.content) for run in runs}
        if len(runs) == 1:
            (books,) = known.values()
            stacks = not self.lines and _can_be_stacked(books)
            largest = _largest_of(runs)
            above = Panel(
                "energy", "J", _stacked(books) if stacks else _lines(books), size=largest
            )
            closing = [TimeCurve("", books.time, books.error, plain())]
            return [above, Panel(DRIFT, "", closing, is_log=True)]
        panels = [
            Panel(f"energy {name}" if name in LATER else f"{name} energy", "J", [
                TimeCurve("", books.time, _part(books, name), look(number))
                for number, books in enumerate(known.values())
            ], size=_largest_of(runs))
            for name in (*STACK, SUPPLY)
        ]  # fmt: skip
        shown = [panel for panel in panels if any(c.value.any() for c in panel.curves)]
        closing = [
            TimeCurve("", books.time, books.error, look(number))
            for number, books in enumerate(known.values())
        ]
        return [*shown, Panel(DRIFT, "", closing, is_log=True)]

    def _books(self, trajectory: "Trajectory") -> EnergySeries:
        if trajectory.energies is None:
            raise TissueError(
                f'"{trajectory.path}" has no energies; write output {{ energy every 10 ms }} '
                "into the scene and run it again"
            )
        books = books_of(*trajectory.energies.with_jumps())
        rows = Window(self.start, self.stop).rows(books.time, "the table of energies")
        parts = {name: part[rows] for name, part in books.parts.items()}
        return EnergySeries(books.time[rows], parts, books.supply[rows], books.error[rows])


def _largest_of(runs: Sequence[PlotSubject]) -> float:
    """Return the largest energy of runs [J], which the unit suits."""
    return max(run.content.energies.largest for run in runs)


def books_of(time: Floats, value: Floats) -> EnergySeries:
    """Return the energy balance of a table of energies [J], shape (moment, column)."""
    parts: dict[str, Floats] = dict(zip(ENERGIES, value.T, strict=True))
    if not len(time):
        return EnergySeries(time, parts, time, time)
    parts["gravity"] = parts["gravity"] - np.nanmin(parts["gravity"])
    there = parts["kinetic"] + parts["elastic"] + parts["gravity"] + parts["dissipated"]
    given = parts["work"] + parts["switched"]
    supply = there[0] + given - given[0]
    # As the measure "energy drift": where gravity energy is zero is a matter of the drawing.
    moving = parts["kinetic"] + parts["elastic"]
    sizes = np.abs([moving, parts["work"], parts["dissipated"], parts["switched"]]).max(axis=0)
    largest = np.maximum.accumulate(sizes)
    error = np.zeros(len(time))
    np.divide(np.abs(there - supply), largest, out=error, where=largest > 0.0)
    return EnergySeries(time, parts, supply, error)


def _part(books: EnergySeries, name: str) -> Floats:
    return books.supply if name == SUPPLY else books.parts[name]


def _largest(books: EnergySeries) -> float:
    return max(float(np.abs(_part(books, name)).max()) for name in (*STACK, SUPPLY))


def _can_be_stacked(books: EnergySeries) -> bool:
    """Return whether no part is below zero, as where dampers are paid or a law gives energy."""
    least = -_SHARE * _largest(books)
    return all(bool((books.parts[name] >= least).all()) for name in STACK)


def _stacked(books: EnergySeries) -> list[TimeCurve]:
    """Return the parts above one another, and a line for what was put in."""
    curves: list[TimeCurve] = []
    low = np.zeros(len(books.time))
    for name in STACK:
        part = np.maximum(books.parts[name], 0.0)
        if part.max() > _SHARE * _largest(books):
            high = low + part
            looks = {"color": SERIES[_SERIES[name]]}
            curves.append(TimeCurve(name, books.time, high, looks, (low, high), is_layer=True))
            low = high
    looks = {"color": INK, "linestyle": DASHES[1], "linewidth": 1.2}
    return [*curves, TimeCurve(SUPPLY, books.time, books.supply, looks)]


def _lines(books: EnergySeries) -> list[TimeCurve]:
    """Return a line for each part that is there, and for what was put in."""
    curves = [
        TimeCurve(name, books.time, books.parts[name], look(number))
        for number, name in enumerate(STACK)
        if np.abs(books.parts[name]).max() > _SHARE * _largest(books)
    ]
    return [*curves, TimeCurve(SUPPLY, books.time, books.supply, plain(1))]


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
