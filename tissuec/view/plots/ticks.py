"""Logarithmic axes with readable ticks."""

import math
from typing import TYPE_CHECKING

import numpy as np

from tissuec.model.network import Floats

if TYPE_CHECKING:
    from tissuec.view.plots.drawing import Axes

_FEW_DECADES = 2.2
_MOST_DECADES = 9


def plain_ticks(axes: "Axes", which: str = "x") -> None:
    """Write the numbers of a log scale as they are, with 2 and 5 where decades are few."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = sorted(axis.get_view_interval())
    if math.log10(high / low) < _FEW_DECADES:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(_plain))
    axis.set_minor_formatter(NullFormatter())


def _plain(value: float, _: int | None) -> str:
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
