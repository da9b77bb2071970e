"""Files of figures: formats by their endings, also for LaTeX; the same bytes each time."""

import os
from collections.abc import Callable, Generator, Mapping
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TextIO

from tissuec.core.data import printable
from tissuec.core.errors import TissueError, enumerated
from tissuec.core.files import replacing

if TYPE_CHECKING:
    from tissuec.view.plots import drawing

DPI = 150
#: Formats by the endings of files, and what to leave out of each so that it does not change.
FORMATS: dict[str, dict[str, Any] | None] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".eps": {"Creator": "tissuec"},
    ".pgf": None,
}
#: How formats call the texts of a scene about itself, by the entries of manifests.
_CREDITS = {
    ".png": {
        "title": "Title", "about": "Description", "author": "Author", "licence": "Copyright",
        "laboratory": "Source",
    },
    ".svg": {
        "title": "Title", "about": "Description", "author": "Creator", "licence": "Rights",
        "laboratory": "Publisher",
    },
    ".pdf": {"title": "Title", "about": "Subject", "author": "Author", "licence": "Keywords"},
}  # fmt: skip


def metadata(suffix: str, credits: Mapping[str, str]) -> dict[str, Any]:
    """Return the metadata of a file for ``savefig``.

    Args:
        suffix: Of the file.
        credits: Texts of a scene about itself, by the entries of manifests, and its title.
    """
    names = _CREDITS.get(suffix, {})
    given = {names[key]: printable(text) for key, text in credits.items() if key in names}
    return (FORMATS.get(suffix) or {}) | given


_EPOCH = "SOURCE_DATE_EPOCH"  # the date of EPS, which cannot be left out


def save(figure: "drawing.Figure", path: Path, *, dpi: float = DPI) -> None:
    """Write a figure to a file, in the format of its suffix.

    Args:
        path: The file.
        dpi: Resolution [1/inch].

    Raises:
        TissueError: There is no such format, it cannot hold the figure, or the file cannot be
            written.
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
        known = enumerated(FORMATS, "or")
        raise TissueError(f'"{path}" {ends}; the name of a picture must end with {known}')


@contextmanager
def prepared(figure: Any, suffix: str) -> Generator[None]:
    """Fit a figure to a format within the block.

    EPS has neither transparency nor files without a date: colours are mixed with that of the
    paper instead.

    Args:
        figure: matplotlib's figure.
        suffix: Of the file.
    """
    if suffix != ".eps":
        yield
        return
    former = os.environ.get(_EPOCH)
    os.environ[_EPOCH] = former or "0"
    see_through = [one for one in figure.findobj() if _opacity(one) < 1.0]
    opacities = [one.get_alpha() for one in see_through]
    colours = [_mixed(one) for one in see_through]
    try:
        yield
    finally:
        for one, opacity, back in zip(see_through, opacities, colours, strict=True):
            back()
            one.set_alpha(opacity)
        if former is None:
            del os.environ[_EPOCH]


def _opacity(artist: Any) -> float:
    found = artist.get_alpha()
    return float(found) if isinstance(found, int | float) else 1.0


def _mixed(artist: Any) -> Any:
    """Mix the colours of an artist with white; return what undoes it."""
    import numpy as np
    from matplotlib.colors import to_rgb, to_rgba_array

    opacity = _opacity(artist)
    undo: list[tuple[Callable[[Any], object], Any]] = []
    artist.set_alpha(None)
    for name in ("color", "facecolor", "edgecolor"):
        if not hasattr(artist, f"set_{name}") or not hasattr(artist, f"get_{name}"):
            continue
        former = getattr(artist, f"get_{name}")()
        setter = getattr(artist, f"set_{name}")
        if name == "color" and hasattr(artist, "get_facecolor"):
            continue  # of collections: that of both
        try:
            shown = to_rgba_array(former)
        except ValueError:
            continue
        white = np.array(to_rgb("white"))
        mixed = shown.copy()
        mixed[:, :3] = opacity * shown[:, :3] + (1.0 - opacity) * white
        mixed[:, 3] = np.where(shown[:, 3] > 0.0, 1.0, 0.0)
        setter(mixed[0] if len(mixed) == 1 else mixed)
        undo.append((setter, former))

    def back() -> None:
        for setter, colour in undo:
            setter(colour)

    return back


_SPECIAL = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#",
    "_": r"\_", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "µ": r"\ensuremath{\mu}", "·": r"\ensuremath{\cdot}", "×": r"\ensuremath{\times}",
    "∫": r"\ensuremath{\int}", "…": r"\ldots{}",
}  # fmt: skip
_RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))


def in_latex(text: str) -> str:
    """Return a text in which nothing is a command of LaTeX."""
    raised = {mark: rf"\textsuperscript{{{plain}}}" for mark, plain in _RAISED.items()}
    special = _SPECIAL | raised
    return "".join(special.get(letter, letter) for letter in text)


def write_pgf(figure: Any, target: Path | str | TextIO) -> None:
    """Write a figure as the commands of a pgfpicture.

    Args:
        figure: matplotlib's figure, with the places of its axes.
        target: File or stream.

    Raises:
        TissueError: The figure has shades.
    """
    width, height = figure.get_size_inches()
    with _opened(target) as stream:
        stream.write(
            "% \\usepackage{pgf} in the preamble, \\input{this file} in a figure\n"
            "\\begingroup\\makeatletter\\begin{pgfpicture}\n"
            "\\pgfpathrectangle{\\pgfpointorigin}"
            f"{{\\pgfqpoint{{{width:f}in}}{{{height:f}in}}}}\n"
            "\\pgfusepath{use as bounding box, clip}\n"
        )
        figure.draw(_renderer()(figure, stream))
        stream.write("\\end{pgfpicture}\\makeatother\\endgroup\n")


def _opened(target: Path | str | TextIO) -> AbstractContextManager[IO[str]]:
    from matplotlib import cbook

    return cbook.open_file_cm(target, "w", encoding="utf-8")  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]  # matplotlib does not say of what streams are


@cache
def _renderer() -> type[Any]:
    """Return matplotlib's renderer of PGF with sizes of texts in its own fonts.

    matplotlib runs LaTeX to measure texts; our figures have the places of all texts already.
    """
    from matplotlib.backends import backend_pgf
    from matplotlib.backends.backend_agg import RendererAgg

    class LatexRenderer(backend_pgf.RendererPgf):
        """Draws without LaTeX."""

        def __init__(self, figure: Any, stream: Any):
            super().__init__(figure, stream)
            width, height = figure.get_size_inches() * figure.dpi
            self._rulers = RendererAgg(width, height, figure.dpi)

        def get_text_width_height_descent(self, s: str, prop: Any, ismath: Any) -> Any:
            """Return width, height and descent of a text in our fonts [px].

            Args:
                prop: Its font.
                ismath: Whether it is a formula.
            """
            return self._rulers.get_text_width_height_descent(s, prop, ismath)

        def draw_text(self, gc: Any, x: Any, y: Any, s: str, *rest: Any, **more: Any) -> None:
            """Draw a text in which nothing is a command.

            Args:
                gc: Looks.
                x, y: Its place [px].
                rest, more: As matplotlib has them.
            """
            super().draw_text(gc, x, y, in_latex(s), *rest, **more)

        def draw_image(self, *_: Any, **__: Any) -> None:
            """Refuse an image.

            Raises:
                TissueError: Always.
            """
            raise TissueError("this plot has shades that PGF cannot hold; write .pdf or .eps")

        draw_gouraud_triangles = draw_image

    return LatexRenderer
