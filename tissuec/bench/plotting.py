"""matplotlib where it is installed, and a sentence that says how to get it."""

from pathlib import Path
from typing import Any

from tissuec.core.errors import TissueError


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure of a size [inch] that needs no screen.

    Raises:
        TissueError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise TissueError(
            'a plot needs matplotlib; pip install "tissuec[plot]" brings it'
        ) from error
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Any, path: Path) -> None:
    """Write a figure to a file, in the format that its suffix names.

    Raises:
        TissueError: There is no such format.
    """
    try:
        figure.savefig(path, dpi=150)
    except ValueError as error:
        raise TissueError(f'"{path}" cannot be drawn: {error}') from error
