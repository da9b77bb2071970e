"""Figures that need no screen, in the styles of screens and of the columns of journals."""

import re
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct, field

from tissuec.core.data import printable
from tissuec.core.errors import TissueError
from tissuec.core.files import write_file
from tissuec.core.hints import alternatives
from tissuec.core.palette import GRID, INK, PAPER
from tissuec.view.plots.formats import DPI, FORMATS, metadata, prepared, write_pgf

if TYPE_CHECKING:
    from tissuec.view.plots import drawing

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


INCH = 25.4  # [mm]
_DIGITS = 6  # of places, as parts of the page
_LAYOUTS, _SETTLED = 6, 1e-4  # at most, and until places of axes move by no more than this


class Canvas(Struct):
    """A figure, or a part of one, that is drawn on.

    Attributes:
        figure: matplotlib's figure or subfigure.
        notes: What there is to be said beside the picture.
        numbers: What was computed for the picture, by what it is and the names of runs.
        later: What waits until the places of all axes are known.
    """

    figure: "drawing.Figure"
    notes: list[str] = field(default_factory=list[str])
    numbers: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])
    later: list[Callable[[], None]] = field(default_factory=list[Callable[[], None]])

    @property
    def height(self) -> float:
        """Return the height of the sheet [mm]."""
        dots: Any = self.figure
        return dots.bbox.height / dots.dpi * INCH

    def part(self, figure: "drawing.Figure") -> "Canvas":
        """Return a part of this sheet."""
        return Canvas(figure, self.notes, self.numbers, self.later)

    def tell(self, what: str, name: str, number: Any) -> None:
        """Keep what was computed for the picture.

        Args:
            what: Such as "areas".
            name: Of the run.
            number: Plain data, with units.
        """
        self.numbers.setdefault(what, {})[name] = number

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
def new_sheet(
    width: float, height: float, style: PlotStyle = STYLES["screen"]
) -> Generator[Canvas]:
    """Yield an empty sheet, and finish it after the block.

    Args:
        width: [mm].
        height: [mm].
        style: Style of the figure.

    Raises:
        TissueError: matplotlib is not installed.
    """
    need_matplotlib()
    with drawn_in(style):
        size = (width / INCH, height / INCH)  # exact, for whole numbers of pixels
        figure = _page_class()(figsize=size, dpi=DPI, layout="constrained")
        figure.style = style
        sheet = Canvas(figure)
        yield sheet
        _finish_texts(figure)
        _lay_out(figure)
        if wrapped_labels(figure):
            _lay_out(figure)
        for finish in sheet.later:
            finish()
        _finish_texts(figure)
        _lay_out(figure)  # with room for what was added
        _keep_layout(figure)
        figure.notes, figure.numbers = tuple(sheet.notes), sheet.numbers


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


def _finish_texts(figure: Any) -> None:
    """Have texts drawn as they are, "$" too, in sizes of the style."""
    from matplotlib.text import Text

    for one in figure.axes:
        for axis in (one.xaxis, one.yaxis):
            powers_as_text(axis)
    for text in figure.findobj(Text):
        text.set_parse_math(False)
        text.set_text(printable(text.get_text()))
    figure.style.fit(figure)


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
        """A figure of tissuec; ``notes`` contains remarks on it, ``numbers`` what it shows.

        ``credits`` contains what a file of it says about its scene; see ``formats.metadata``.
        """

        notes: tuple[str, ...] = ()
        style: PlotStyle = STYLES["screen"]
        numbers: Mapping[str, Any] = MappingProxyType({})
        credits: Mapping[str, str] = MappingProxyType({})

        def __init__(self, *args: Any, **keywords: Any):
            super().__init__(*args, **keywords)  # pyright: ignore[reportUnknownMemberType]  # keywords
            FigureCanvasAgg(self)

        def savefig(self, fname: Any, *, outlines: bool = False, **keywords: Any) -> None:
            """Write the figure in its style; see ``Figure.savefig``.

            Args:
                fname: File to write.
                outlines: Whether texts of SVG are outlines, which look alike everywhere.
                keywords: Of matplotlib.
            """
            suffix = Path(fname).suffix.lower() if isinstance(fname, str | Path) else ""
            suffix = f".{keywords['format']}" if keywords.get("format") else suffix
            if suffix in FORMATS and FORMATS[suffix] is not None:
                keywords.setdefault("metadata", metadata(suffix, self.credits))
            with drawn_in(self.style), prepared(self, suffix):
                if suffix == ".pgf":
                    write_pgf(self, fname)
                    return
                if suffix == ".eps" and isinstance(fname, str | Path):
                    stream = BytesIO()  # otherwise its title is the name of the file
                    super().savefig(stream, **keywords, format="eps")  # pyright: ignore[reportUnknownMemberType]  # keywords
                    write_file(Path(fname), stream.getvalue())
                    return
                if outlines:
                    import_module("matplotlib").rcParams["svg.fonttype"] = "path"
                super().savefig(fname, **keywords)  # pyright: ignore[reportUnknownMemberType]  # keywords

        def _repr_png_(self) -> bytes:
            picture = BytesIO()
            self.savefig(picture, format="png")
            return picture.getvalue()

    return Page


_RAISED = str.maketrans("0123456789-−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻")
_POWER = re.compile(r"\^\{([^}]*)\}")
_LEAST = 8  # letters of a line


def wrapped_labels(figure: Any) -> bool:
    """Wrap the names of axes that are longer than these; return whether any was."""
    found = False
    for axes in figure.axes:
        if not axes.axison:
            continue
        box = axes.get_window_extent()
        for label, side, room in (
            (axes.xaxis.label, "width", box.width),
            (axes.yaxis.label, "height", box.height),
        ):
            text, length = label.get_text(), getattr(label.get_window_extent(), side)
            if length <= room:
                continue
            letters = max(_LEAST, int(max(map(len, text.split("\n"))) * room / length))
            lines = wrap(text.replace("\n", " "), letters, break_long_words=False)
            found |= text != "\n".join(lines)
            label.set_text("\n".join(lines))
    return found


def powers_as_text(axis: Any) -> None:
    """Have a logarithmic axis write 10⁻³ in letters: a formula has smaller ones."""
    from matplotlib.ticker import LogFormatterSciNotation

    for which in ("major", "minor"):
        formatter = getattr(axis, f"get_{which}_formatter")()
        if type(formatter) is LogFormatterSciNotation:
            getattr(axis, f"set_{which}_formatter")(_powers()(like=formatter))


@cache
def _powers() -> type[Any]:
    from matplotlib.ticker import LogFormatterSciNotation

    class PowerFormatter(LogFormatterSciNotation):
        """Powers of ten in letters."""

        def __init__(self, like: Any):
            super().__init__(
                like._base, like.labelOnlyBase, like.minor_thresholds, like._linthresh
            )

        def __call__(self, x: float, pos: int | None = None) -> str:
            return _in_letters(super().__call__(x, pos))

    return PowerFormatter


def _in_letters(formula: str) -> str:
    """Return 2×10⁻³ for $\\mathdefault{2\\times10^{-3}}$."""
    plain = formula.removeprefix(r"$\mathdefault{").removesuffix("}$")
    plain = plain.replace(r"\times", "×")
    return _POWER.sub(lambda found: found[1].translate(_RAISED), plain)
