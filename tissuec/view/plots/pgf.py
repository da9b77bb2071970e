"""Figures as PGF for LaTeX, written without LaTeX: texts are set by the document itself."""

from contextlib import AbstractContextManager
from functools import cache
from pathlib import Path
from typing import IO, Any, TextIO

from tissuec.core.errors import TissueError

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
                s: The text.
                prop: Its font.
                ismath: Whether it is a formula.
            """
            return self._rulers.get_text_width_height_descent(s, prop, ismath)

        def draw_text(self, gc: Any, x: Any, y: Any, s: str, *rest: Any, **more: Any) -> None:
            """Draw a text in which nothing is a command.

            Args:
                gc: Looks.
                x, y: Its place [px].
                s: The text.
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
