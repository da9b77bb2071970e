"""Figures of one style that need no screen, and the files that they are written to.

The same figure makes the same bytes: vector files carry no date, and their marks no chance.
"""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct, field

from tissuec.core.errors import TissueError
from tissuec.core.files import replacing
from tissuec.core.palette import GRID, INK, PAPER
from tissuec.core.printable import printable

if TYPE_CHECKING:
    from tissuec.view.plots import drawing

INCH = 25.4  # [mm]
DPI = 150
_DIGITS = 6  # of places, as parts of the page
_LAYOUTS, _SETTLED = 6, 1e-4  # at most, and until places of axes move by no more than this
#: Formats by the endings of files, and what to leave out of each so that it does not change.
FORMATS: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
STYLE: dict[str, Any] = {
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
    "mathtext.default": "regular",
    "pdf.fonttype": 42,
    "savefig.facecolor": PAPER,
    "svg.hashsalt": "tissuec",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}


class Canvas(Struct):
    """A figure, or a part of one, that is drawn on.

    Attributes:
        figure: matplotlib's figure or subfigure.
        notes: What there is to be said beside the picture.
        areas: Under curves of one quantity against another, by their names: value and unit.
        later: What waits until the places of all axes are known.
    """

    figure: "drawing.Figure"
    notes: list[str] = field(default_factory=list[str])
    areas: dict[str, Any] = field(default_factory=dict[str, Any])
    later: list[Callable[[], None]] = field(default_factory=list[Callable[[], None]])

    @property
    def height(self) -> float:
        """Return the height of the sheet [mm]."""
        dots: Any = self.figure
        return dots.bbox.height / dots.dpi * INCH

    def part(self, figure: "drawing.Figure") -> "Canvas":
        """Return a part of this sheet."""
        return Canvas(figure, self.notes, self.areas, self.later)

    def note(self, text: str) -> None:
        """Say something once."""
        if text not in self.notes:
            self.notes.append(text)


class Picture(Struct, frozen=True):
    """A picture to be drawn, with all data read.

    Attributes:
        width, height: That suit it [mm].
        draw: Draws it on a sheet.
        notes: What there is to be said beside it.
    """

    width: float
    height: float
    draw: Callable[[Canvas], object]
    notes: tuple[str, ...] = ()

    def on(self, sheet: Canvas) -> None:
        """Draw it, and say what there is to be said."""
        self.draw(sheet)
        for note in self.notes:
            sheet.note(note)


def need_matplotlib() -> None:
    """Check that matplotlib is installed.

    Raises:
        TissueError: matplotlib is not installed.
    """
    try:
        import_module("matplotlib.figure")
    except ImportError as error:
        raise TissueError(
            'a picture needs matplotlib; install it: pip install "tissuec[plot]"'
        ) from error


@contextmanager
def style() -> Generator[None]:
    """Draw in our style within the block, whatever a user has set; needs matplotlib."""
    matplotlib: Any = import_module("matplotlib")

    with matplotlib.rc_context():
        matplotlib.rcParams.update(matplotlib.rcParamsDefault | STYLE)
        yield


@contextmanager
def new_sheet(width: float, height: float) -> Generator[Canvas]:
    """Yield an empty sheet of a size [mm], and finish it behind the block.

    Raises:
        TissueError: matplotlib is not installed.
    """
    need_matplotlib()
    with style():
        size = (width / INCH, height / INCH)  # exact, for whole numbers of pixels
        figure = _page_class()(figsize=size, dpi=DPI, layout="constrained")
        sheet = Canvas(figure)
        yield sheet
        _show_plainly(figure)
        _lay_out(figure)
        for finish in sheet.later:
            finish()
        _show_plainly(figure)
        _lay_out(figure)  # with room for what was added
        _keep_layout(figure)
        figure.notes, figure.areas = tuple(sheet.notes), sheet.areas


def _lay_out(figure: Any) -> None:
    """Give the axes their places, without drawing what they hold.

    Room for titles is found from axes as they are, which become smaller where both directions
    have one scale: so it is repeated until nothing moves.
    """
    former = None
    for _ in range(_LAYOUTS):
        if figure.axes:
            figure.get_layout_engine().execute(figure)
        places = np.array([axes.get_position(original=True).bounds for axes in figure.axes])
        if former is not None and np.allclose(places, former, rtol=0.0, atol=_SETTLED):
            break
        former = places


def _show_plainly(figure: Any) -> None:
    """Have names drawn as they are, "$" too; only numbers on logarithmic axes are formulas."""
    from matplotlib.text import Text
    from matplotlib.ticker import LogFormatter

    axes = [axis for one in figure.axes for axis in (one.xaxis, one.yaxis)]
    numbers = {
        label
        for axis in axes
        if isinstance(axis.get_major_formatter(), LogFormatter)
        for label in axis.get_ticklabels(which="both")
    }
    for text in set(figure.findobj(Text)) - numbers:
        text.set_parse_math(False)
        text.set_text(printable(text.get_text()))


def _keep_layout(figure: Any) -> None:
    """Keep the places of axes for every format, rounded: the last bits of layout are chance."""
    figure.set_layout_engine("none")
    for part in figure.subfigs:
        part.bbox_relative.set_points(np.round(part.bbox_relative.get_points(), _DIGITS))
    for axes in figure.axes:
        place = axes.get_position(original=True)
        axes.set_position(np.round(place.bounds, _DIGITS))


@cache
def _page_class() -> type[Any]:
    """Return a figure that keeps its style, and is shown by notebooks without pyplot."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    class Page(Figure):
        """A figure of tissuec; ``notes`` contains remarks on it, ``areas`` those of curves."""

        notes: tuple[str, ...] = ()
        areas: Mapping[str, Any] = MappingProxyType({})

        def __init__(self, *args: Any, **keywords: Any):
            super().__init__(*args, **keywords)  # pyright: ignore[reportUnknownMemberType]  # keywords
            FigureCanvasAgg(self)

        def savefig(self, fname: Any, **keywords: Any) -> None:
            """Write the figure in the style of tissuec; see ``Figure.savefig``."""
            suffix = Path(fname).suffix.lower() if isinstance(fname, str | Path) else ""
            suffix = f".{keywords['format']}" if keywords.get("format") else suffix
            keywords.setdefault("metadata", FORMATS.get(suffix))
            with style():
                super().savefig(fname, **keywords)  # pyright: ignore[reportUnknownMemberType]  # keywords

        def _repr_png_(self) -> bytes:
            picture = BytesIO()
            self.savefig(picture, format="png")
            return picture.getvalue()

    return Page


def save(figure: "drawing.Figure", path: Path, *, dpi: float = DPI) -> None:
    """Write a figure to a file, in the format of its suffix.

    Args:
        figure: The figure.
        path: The file.
        dpi: Resolution [1/inch].

    Raises:
        TissueError: There is no such format, or the file cannot be written.
    """
    check_suffix(path)
    try:
        with replacing(path) as beside:
            figure.savefig(beside, dpi=dpi)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise TissueError(f'cannot write "{path}": {reason}') from error


def check_suffix(path: Path) -> None:
    """Check that the suffix of a file is a known format.

    Raises:
        TissueError: It does not.
    """
    if path.suffix.lower() not in FORMATS:
        ends = "has no ending" if not path.suffix else f"ends with {path.suffix}"
        *others, last = FORMATS
        raise TissueError(
            f'"{path}" {ends}; the name of a picture must end with {", ".join(others)} or '
            f"{last}"
        )
