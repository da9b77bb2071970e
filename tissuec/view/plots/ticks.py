"""Logarithmic axes with readable ticks."""

import math
from typing import TYPE_CHECKING

import numpy as np

from tissuec.model.network import Floats
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
        axes: Axes of matplotlib.
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
        axes: Axes of matplotlib.
        values: In the unit of the axis, of any shape.
    """
    known = values[np.isfinite(values) & (values > 0.0)]
    high = np.ceil(np.log10(known.max()))
    low = max(np.floor(np.log10(known.min())), high - _MOST_DECADES)  # below is rounding
    axes.set_yscale("log", nonpositive="mask")
    axes.set_ylim(10.0**low, 10.0 ** max(high, low + 1.0))
