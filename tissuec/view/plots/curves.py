"""Curves with names beside them, in colours and dashes that can be distinguished."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tissuec.core.palette import INK, SERIES
from tissuec.model.network import Floats
from tissuec.view.plots.page import Canvas

if TYPE_CHECKING:
    from matplotlib.lines import Line2D

    from tissuec.view.plots.drawing import Axes

#: Styles of successive curves, which distinguish them without colours.
DASHES: tuple[Any, ...] = (
    "-", (0, (5, 1.6)), (0, (6, 1.5, 1.2, 1.5)), (0, (1.3, 1.3)), (0, (8, 1.5, 1, 1.5, 1, 1.5)),
    (0, (2.5, 1.2)), (0, (9, 3)),
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*", "h")
_MOST_NAMES = 4  # beside their ends; more go into a legend
_LONGEST_NAME = 20
_MOST_ROWS = 5000  # of a curve that is drawn as it is
_LETTERS = 8  # [pt]
_APART = 1.25  # of their height
_NARROW = 300.0  # [pt]: of figures that have no room beside the axes
_LETTER, _HANDLE = 4.8, 45.0  # [pt]: of legends


def look(number: int) -> dict[str, Any]:
    """Return colour and dashes of the curve with a number from 0."""
    return {
        "color": SERIES[number % len(SERIES)],
        "linestyle": DASHES[number % len(DASHES)],
    }


def plain(number: int = 0) -> dict[str, Any]:
    """Return the look of the one curve, or total, that others go with."""
    return {"color": INK, "linestyle": DASHES[number % len(DASHES)]}


def thinned(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return a curve with fewer points: the smallest and the largest one of each interval.

    Args:
        x, y: In any units, shape (point,).
    """
    if len(x) <= _MOST_ROWS:
        return x, y
    stretches = np.array_split(np.arange(len(x)), _MOST_ROWS // 2)
    known = np.where(np.isfinite(y), y, np.inf), np.where(np.isfinite(y), y, -np.inf)
    ends = {0, len(x) - 1}
    chosen = ends.union(
        *({int(s[known[0][s].argmin()]), int(s[known[1][s].argmax()])} for s in stretches)
    )
    rows = np.array(sorted(chosen))
    return x[rows], y[rows]


def thinned_band(x: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats, Floats]:
    """Return a band with fewer points that encloses the band given.

    Args:
        x, low, high: In any units, shape (point,).
    """
    if len(x) <= _MOST_ROWS:
        return x, low, high
    firsts = np.linspace(0, len(x), _MOST_ROWS // 2, endpoint=False).astype(int)
    lows, highs = np.minimum.reduceat(low, firsts), np.maximum.reduceat(high, firsts)
    ends = [len(x) - 1]
    return (
        np.concatenate([x[firsts], x[ends]]),
        np.concatenate([lows, low[ends]]),
        np.concatenate([highs, high[ends]]),
    )


def name_curves(sheet: Canvas, axes: "Axes", lines: Sequence["Line2D"]) -> None:
    """Write the names of curves at their ends, or in a legend where ends lie together.

    Args:
        lines: The curves.
    """
    if len(lines) < 2:
        return
    names = [str(line.get_label()) for line in lines]
    places = sorted(_end(axes, line) for line in lines)
    together = min(b - a for a, b in pairwise(places)) < 0.6 * _gap(axes)
    if together or len(lines) > _MOST_NAMES or max(map(len, names)) > _LONGEST_NAME:
        beside(axes, lines)
        return
    marks: list[Any] = []
    for line, text in zip(lines, names, strict=True):  # takes its room before it has its place
        mark = axes.annotate(
            text, (1.0, 0.5), xycoords="axes fraction", xytext=(5, 0),
            textcoords="offset points", va="center", color=line.get_color(), fontsize=_LETTERS,
            annotation_clip=False,
        )  # fmt: skip
        mark.set_gid("curve name")
        marks.append(mark)
    sheet.later.append(lambda: _place(axes, lines, marks))


def beside(axes: "Axes", drawn: Sequence[Any], **options: Any) -> None:
    """Put a legend beside the axes, or below all axes of a narrow figure.

    Args:
        drawn: What the legend names.
    """
    figure, names = axes.figure, [str(one.get_label()) for one in drawn]
    width = figure.bbox.width / figure.dpi * 72.0
    there = [[text.get_text() for text in legend.get_texts()] for legend in figure.legends]
    if names in there:
        return
    if width < _NARROW and not there:
        columns = int(width / (_LETTER * max(map(len, names)) + _HANDLE))
        figure.legend(
            handles=list(drawn), loc="outside lower left", handlelength=2.6,
            ncols=max(1, min(len(names), columns)), **options,
        )  # fmt: skip
        return
    axes.legend(
        handles=list(drawn), loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0,
        handlelength=2.6, **options,
    )  # fmt: skip


def above(sheet: Canvas, lines: Sequence["Line2D"]) -> None:
    """Put a legend of files above all axes."""
    longest = max(len(str(line.get_label())) for line in lines)
    columns = max(1, min(len(lines), 96 // (longest + 8)))
    sheet.figure.legend(
        handles=list(lines), loc="outside upper left", ncols=columns, handlelength=2.8
    )


def _place(axes: "Axes", lines: Sequence["Line2D"], marks: Sequence[Any]) -> None:
    """Move names beside the ends of their curves, apart from one another."""
    wanted = [_end(axes, line) for line in lines]
    for mark, place in zip(marks, spread(wanted, _gap(axes)), strict=True):
        mark.xy = (1.0, place)


def _gap(axes: "Axes") -> float:
    """Return how far names must be apart, as a part of the height of the axes."""
    height = axes.get_window_extent().height * 72.0 / axes.figure.dpi
    return _APART * _LETTERS / max(height, 1.0)


def _end(axes: "Axes", line: "Line2D") -> float:
    """Return the height of the last number of a curve, as a part of the height of the axes."""
    x, y = (np.asarray(values, dtype=float) for values in line.get_data(orig=False))
    rows = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not len(rows):
        return 0.5
    end = np.array([[x[rows[-1]], y[rows[-1]]]])
    place = axes.transLimits.transform(axes.transScale.transform(end))[0, 1]
    return float(np.clip(place, 0.0, 1.0)) if np.isfinite(place) else 0.0


def spread(wanted: Sequence[float], gap: float) -> list[float]:
    """Return places near those wanted, from 0 to 1, that are a gap apart if there is room."""
    order = np.argsort(wanted, kind="stable")
    count = len(wanted)
    gap = min(gap, 1.0 / max(count - 1, 1))
    steps = gap * np.arange(count)
    # With the steps taken off, places that are apart ascend: the nearest ascending numbers.
    bare = _ascending((np.array(wanted)[order] - steps).tolist())
    placed = np.clip(bare, 0.0, 1.0 - steps[-1]) + steps
    result = np.empty(count)
    result[order] = placed
    return result.tolist()


def _ascending(values: Sequence[float]) -> Floats:
    """Return the ascending numbers that are nearest by squares (pool adjacent violators)."""
    blocks: list[tuple[float, int]] = []
    for value in values:
        mean, size = value, 1
        while blocks and blocks[-1][0] > mean:
            before, others = blocks.pop()
            mean, size = (mean * size + before * others) / (size + others), size + others
        blocks.append((mean, size))
    return np.concatenate([np.full(size, mean) for mean, size in blocks])
