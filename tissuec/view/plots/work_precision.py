"""Work-precision diagrams: time against error of solvers."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.view.plots import PLOTS
from tissuec.view.plots.curves import DASHES, MARKERS, beside
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject
from tissuec.view.plots.ticks import plain_ticks

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

SIZE = 180.0, 120.0  # [mm]


class SolverCurve(NamedTuple):
    """A solver: its errors and times [s], from coarse to fine."""

    name: str
    ours: bool
    errors: list[float]
    seconds: list[float]


@PLOTS.member("work-precision")
class WorkPrecision(Struct, frozen=True):
    """Time against error of every solver of a bench; those of tissuec are filled."""

    takes: ClassVar[str] = "bench"
    several: ClassVar[bool] = False

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a bench.

        Raises:
            TissueError: The bench has no points.
        """
        document = subjects[0].content
        floor = float(document["reference"]["uncertainty"])
        curves = curves_of(document, floor)
        if not curves:
            raise TissueError(f'the bench of "{subjects[0].name}" has no results')
        seconds = [second for curve in curves for second in curve.seconds]
        scale = scale_of("s", [math.sqrt(min(seconds) * max(seconds))])

        def draw(sheet: Canvas) -> None:
            axes = sheet.figure.subplots()
            for number, curve in enumerate(curves):
                _draw(axes, curve, scale, number)
            axes.set(
                xscale="log", yscale="log", xlabel="error over largest displacement",
                ylabel=scale.label("time"),
            )  # fmt: skip
            axes.grid(visible=True, which="minor", linewidth=0.3)
            _draw_floor(axes, floor)
            axes.invert_xaxis()  # precision grows to the right
            plain_ticks(axes, "y")
            beside(axes, axes.get_legend_handles_labels()[0])
            axes.set_title(_head(subjects[0].name, document), fontsize=8.5)

        return Picture(*SIZE, draw)


def curves_of(document: Mapping[str, Any], floor: float) -> list[SolverCurve]:
    """Return the solvers of a bench; errors below the uncertainty are raised to it."""
    found: dict[str, SolverCurve] = {}
    for point in document["points"]:
        name = point["method"]
        curve = found.setdefault(name, SolverCurve(name, bool(point["ours"]), [], []))
        if point["error"] is not None and point["seconds"] is not None:
            curve.errors.append(max(point["error"], floor))
            curve.seconds.append(point["seconds"])
    return [curve for curve in found.values() if curve.errors]


def _draw(axes: "Axes", curve: SolverCurve, scale: AxisUnit, number: int) -> None:
    colour = SERIES[number % len(SERIES)]
    axes.plot(
        curve.errors, scale.of(curve.seconds), color=colour, label=curve.name,
        marker=MARKERS[number % len(MARKERS)], markersize=5,
        markerfacecolor=colour if curve.ours else "white",
        linestyle="-" if curve.ours else DASHES[1], linewidth=1.8 if curve.ours else 1.0,
    )  # fmt: skip


def _draw_floor(axes: "Axes", floor: float) -> None:
    """Mark errors that are not known any better."""
    if floor > 0.0:
        axes.axvline(
            floor,
            color=INK,
            linestyle=(0, (1, 2)),
            linewidth=1.0,
            label="accuracy of the reference",
            zorder=1,
        )


def _head(name: str, document: Mapping[str, Any]) -> str:
    kinds = ("nodes", "elements", "springs")
    size = [f"{document[what]} {what}" for what in kinds if document.get(what)]
    return f"{name}   ({', '.join(size)})" if size else name
