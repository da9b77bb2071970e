"""Axes: logarithmic ones with readable ticks, and marks of events on those of time."""

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tissuec.core.palette import INK
from tissuec.core.scale import AxisUnit
from tissuec.model.network import Floats
from tissuec.results.recording import Event
from tissuec.view.plots.page import Canvas

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes


_FEW_DECADES = 2.2
_MANY_DECADES = 4.5
_MOST_DECADES = 9
_LETTER = 5.5  # width of a digit [pt]


def log_ticks(axes: "Axes", which: str) -> None:
    """Give a logarithmic axis readable numbers: plain ones, over many decades powers."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = sorted(axis.get_view_interval())
    if low <= 0.0 or high / low > 10.0**_MANY_DECADES:
        return
    plain_ticks(axes, which)
    if high / low < 10.0:  # 1, 2 and 5 may be none of it
        axis.set_major_locator(MaxNLocator(5))
        axis.set_major_formatter(FuncFormatter(_plain))
        axis.set_minor_formatter(NullFormatter())


def plain_ticks(axes: "Axes", which: str = "x") -> None:
    """Write the numbers of a log scale as they are, with 2 and 5 where decades are few."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = sorted(axis.get_view_interval())
    if math.log10(high / low) < _FEW_DECADES:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(_plain))
    axis.set_minor_formatter(NullFormatter())


def ticks_at(sheet: Canvas, axes: "Axes", values: Floats) -> None:
    """Mark a logarithmic horizontal axis at values, as far as their numbers do not touch.

    Args:
        sheet: What the axes are on.
        values: In the unit of the axis, of any shape.
    """
    from matplotlib.ticker import NullLocator

    places = np.unique(values[np.isfinite(values)])
    axes.xaxis.set_minor_locator(NullLocator())
    _mark(axes, places)
    sheet.later.append(lambda: _mark(axes, _apart(axes, places)))


def _mark(axes: "Axes", places: Floats) -> None:
    axes.set_xticks(places, [_plain(place) for place in places.tolist()])


def _apart(axes: "Axes", places: Floats) -> Floats:
    """Return places whose numbers do not touch, now that the axes have their width."""
    low, high = np.log(axes.get_xlim())
    letters = axes.get_window_extent().width * 72.0 / axes.figure.dpi / _LETTER
    kept: list[float] = []
    end = -np.inf
    for place in places.tolist():
        half = 0.5 * len(_plain(place))
        middle = letters * (np.log(place) - low) / (high - low)
        if middle - half > end + 1.0:
            kept.append(place)
            end = middle + half
    return np.array(kept)


def _plain(value: float, _: int | None = None) -> str:
    return f"{value:.6g}"


def whole_decades(axes: "Axes", values: Floats) -> None:
    """Give an axis of positive numbers a logarithmic scale with a power of ten at each end.

    Args:
        values: In the unit of the axis, of any shape.
    """
    known = values[np.isfinite(values) & (values > 0.0)]
    high = np.ceil(np.log10(known.max()))
    low = max(np.floor(np.log10(known.min())), high - _MOST_DECADES)  # below is rounding
    axes.set_yscale("log", nonpositive="mask")
    axes.set_ylim(10.0**low, 10.0 ** max(high, low + 1.0))


NEAR = 0.012  # of the time that is shown: events so close to each other share a mark
SILENT = ("note", "end", "end the run")
ROUTINE = ("move", "turn", "push", "pull", "tighten", "stop", "open", "close")
MOST = 8  # marks; of more the routine ones are left out
_MOST_LEVELS = 3
_SMALL = 7


def mark_events(
    axes: Sequence["Axes"],
    happened: Sequence[tuple[float, str]],
    scale: AxisUnit,
    *,
    color: str = INK,
    linestyle: Any = (0, (4, 3)),
) -> list[Any]:
    """Draw a line at each time of an event; write above the axes what happened.

    Args:
        axes: One above the other, with the same axis of time.
        happened: Times [s] and texts, see `clusters`.
        color: Colour of the lines.
        linestyle: Style of the lines.

    Returns:
        The texts, for `stagger`.
    """
    texts: list[Any] = []
    for time, text in happened:
        place = float(scale.of(time))
        for one in axes:
            line = one.axvline(
                place, color=color, alpha=0.45, linewidth=0.7, linestyle=linestyle, zorder=0.5
            )
            line.set_gid("event")
        mark = axes[0].annotate(
            text, (place, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2),
            textcoords="offset points", fontsize=_SMALL, color=color, alpha=0.8, ha="left",
            va="bottom", annotation_clip=False,
        )  # fmt: skip
        mark.set_gid("event")
        texts.append(mark)
    return texts


def clusters(events: Sequence[Event], shown: tuple[float, float]) -> list[tuple[float, str]]:
    """Return times [s] at which something happened, and what.

    What begins with the run is no news and left out, and so are the ends of motions, and what
    happened outside. Of very many events those remain that are no part of a motion.
    """
    start, stop = shown
    near = NEAR * (stop - start)
    groups: list[list[Event]] = []
    for event in sorted(events, key=lambda event: event.time):
        if not (max(start, 0.0) < event.time <= stop) or event.kind in SILENT:
            continue
        if groups and event.time - groups[-1][0].time <= near:
            groups[-1].append(event)
        else:
            groups.append([event])
    if len(groups) > MOST:
        groups = [g for g in groups if any(event.kind not in ROUTINE for event in g)]
    return [(group[0].time, told(group)) for group in groups]


def told(events: Sequence[Event]) -> str:
    """Return the kinds of events, such as "cut, rupture × 13"."""
    counts = Counter(event.kind for event in events)
    return ", ".join(kind if n == 1 else f"{kind} × {n}" for kind, n in counts.items())


def stagger(texts: Sequence[Any], axes: "Axes") -> None:
    """Lift texts that would run into their neighbours, and keep them on the page."""
    figure = axes.figure
    ends = [-1.0] * _MOST_LEVELS
    last = axes.get_window_extent().x1
    dots = figure.dpi / 72.0
    for text in sorted(texts, key=lambda text: text.xy[0]):
        box = text.get_window_extent()
        left = box.x0
        if box.x1 > last + 30 * dots:  # beyond the axes: to the other side of the line
            text.set_ha("right")
            left = box.x0 - box.width
        level = next((n for n, end in enumerate(ends) if left > end), None)
        if level is None:
            text.remove()  # the line remains; the table of events explains it
            continue
        text.xyann = (0, 2 + level * 1.2 * _SMALL)
        ends[level] = left + box.width + 4 * dots
