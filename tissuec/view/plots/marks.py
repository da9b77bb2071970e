"""Marks of events on axes of time."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tissuec.core.palette import INK
from tissuec.core.scale import AxisUnit
from tissuec.results.recording import Event

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

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
        scale: Of that axis.
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
