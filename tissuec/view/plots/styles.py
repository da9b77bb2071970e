"""Styles of figures: for screens, and for the columns of journals."""

from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.palette import GRID, INK, PAPER

_ALL: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": "#888888",
    "axes.facecolor": PAPER,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 9,
    "figure.facecolor": PAPER,
    "font.family": "sans-serif",
    "font.size": 8.5,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "pdf.fonttype": 42,  # whole fonts, that editors can write in
    "ps.fonttype": 42,
    "savefig.facecolor": PAPER,
    "svg.fonttype": "none",
    "svg.hashsalt": "tissuec",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}
_OF_PAPER = {
    "axes.edgecolor": INK,
    "axes.grid": False,
    "axes.titlesize": 8,
    "font.size": 8,
    "legend.fontsize": 8,
    "lines.linewidth": 1.0,
}


class PlotStyle(Struct, frozen=True):
    """A style.

    Attributes:
        width: Of figures [mm]; None: as suits the kind of plot.
        sizes: The smallest and the largest text [pt].
        settings: Of matplotlib.
    """

    width: float | None
    sizes: tuple[float, float]
    settings: dict[str, Any]

    def size_of(self, width: float, height: float) -> tuple[float, float]:
        """Return the size of a figure [mm] that would be so large on a screen.

        Its height shrinks less than its width, as texts do not shrink.
        """
        if self.width is None:
            return width, height
        return self.width, height * (self.width / width) ** 0.5

    def fit(self, figure: Any) -> None:
        """Give all texts of a figure a size within the limits."""
        from matplotlib.text import Text

        for text in figure.findobj(Text):
            text.set_fontsize(float(np.clip(text.get_fontsize(), *self.sizes)))


STYLES = {
    "screen": PlotStyle(None, (6.5, 10.0), _ALL),
    "paper": PlotStyle(85.0, (7.0, 9.0), _ALL | _OF_PAPER),
    "paper-wide": PlotStyle(180.0, (7.0, 9.0), _ALL | _OF_PAPER),
}


def style_named(name: str) -> PlotStyle:
    """Return a style.

    Raises:
        TissueError: There is no such style.
    """
    if name not in STYLES:
        hint = alternatives(name, STYLES, what="styles")
        raise TissueError(f'there is no style "{name}"; {hint}')
    return STYLES[name]


@contextmanager
def drawn_in(style: PlotStyle) -> Generator[None]:
    """Draw in a style within the block, whatever a user has set; needs matplotlib."""
    matplotlib: Any = import_module("matplotlib")

    with matplotlib.rc_context():
        matplotlib.rcParams.update(matplotlib.rcParamsDefault | style.settings)
        yield
