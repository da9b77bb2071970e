"""Diagrams of benches: time against error of solvers, and the map of a stress test."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, SERIES
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import plain_ticks
from tissuec.view.plots.curves import DASHES, MARKERS, beside
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

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
                _draw_curve(axes, curve, scale, number)
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


def _draw_curve(axes: "Axes", curve: SolverCurve, scale: AxisUnit, number: int) -> None:
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


#: Kinds of verdicts: colour of the cell, and of the letters on it.
COLOURS = {
    "good": ("#4c9f70", INK), "energy": ("#a9d6b0", INK), "measured": ("#ffffff", INK),
    "warned": ("#f2c14e", INK),
    "refused": ("#f7e3a1", INK), "slow": ("#c8d3e0", INK), "none": ("#f2f2f2", "#777777"),
    "wrong": ("#b03024", "#ffffff"), "crash": ("#000000", "#ffffff"),
}  # fmt: skip
UNKNOWN = ("#dddddd", INK)
WIDTH, ROW, LINE, AROUND = 180.0, 5.0, 3.6, 24.0  # [mm]


@PLOTS.member("stability")
class Stability(Struct, frozen=True):
    """The map of a stress test: a row for each scene, a column for each method."""

    takes: ClassVar[str] = "stress"
    several: ClassVar[bool] = False

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of a map.

        Raises:
            TissueError: The map is incomplete.
        """
        document = subjects[0].content
        methods, verdicts = list(document["methods"]), list(document["verdicts"])
        width = len(methods)
        if not verdicts or not width or len(verdicts) % width:
            raise TissueError(f'"{subjects[0].name}" contains no complete map')
        rows = [verdicts[i : i + width] for i in range(0, len(verdicts), width)]

        def draw(sheet: Canvas) -> None:
            axes = sheet.figure.subplots()
            _draw_outcomes(axes, methods, rows, document.get("signs", {}))
            _explain(sheet, verdicts, document.get("signs", {}))

        kinds = {verdict["kind"] for verdict in verdicts}
        return Picture(WIDTH, AROUND + ROW * len(rows) + LINE * len(kinds), draw)


def _draw_outcomes(
    axes: "Axes",
    methods: Sequence[str],
    rows: Sequence[Sequence[Mapping[str, Any]]],
    signs: Mapping[str, Sequence[str]],
) -> None:
    from matplotlib.patches import Rectangle

    for place, row in enumerate(rows):
        for column, verdict in enumerate(row):
            kind = verdict["kind"]
            back, letters = COLOURS.get(kind, UNKNOWN)
            axes.add_patch(Rectangle((column + 0.02, place + 0.06), 0.96, 0.88, color=back))
            error, sign = verdict.get("error"), signs.get(kind, (kind,))[0]
            axes.text(
                column + 0.5, place + 0.5, sign if error is None else f"{error:.0e}",
                color=letters, ha="center", va="center_baseline", fontsize=6.5,
            )  # fmt: skip
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    axes.set(xlim=(0, len(methods)), ylim=(len(rows), 0))
    heads = [f"{row[0]['axis']} {row[0]['value']}" for row in rows]
    axes.set_yticks([place + 0.5 for place in range(len(rows))], heads, fontsize=7)
    axes.xaxis.tick_top()
    places = [column + 0.5 for column in range(len(methods))]
    axes.set_xticks(places, methods, rotation=35, ha="left", fontsize=7.5)


def _explain(
    sheet: Canvas, verdicts: Sequence[Mapping[str, Any]], signs: Mapping[str, Sequence[str]]
) -> None:
    """Say what the signs mean, and how often each occurs."""
    from matplotlib.patches import Patch

    counts = Counter(verdict["kind"] for verdict in verdicts)
    order = [*COLOURS, *(kind for kind in counts if kind not in COLOURS)]
    handles: list[Patch] = []
    for kind in order:
        if counts[kind]:
            sign, meaning = signs.get(kind, (kind, ""))
            label = f"{sign} ({counts[kind]})" + (f": {meaning}" if meaning else "")
            handles.append(Patch(color=COLOURS.get(kind, UNKNOWN)[0], label=label))
    sheet.figure.legend(handles=handles, loc="outside lower left", fontsize=7)
