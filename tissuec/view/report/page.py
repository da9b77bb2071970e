"""The page about a run: one self-contained HTML document."""

from collections.abc import Sequence
from pathlib import Path

from tissuec.core import palette
from tissuec.core.version import __version__
from tissuec.view.report import drawings, origins, outcome
from tissuec.view.report.content import ReportContent, head
from tissuec.view.report.markup import Html, Section, element, link

_HERE = Path(__file__).parent
#: The page, and the player in it, may load nothing from outside.
ALONE = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
)
#: The names that the style sheet has for the colours of all pictures: on paper, in the dark.
_COLOURS = {
    "ink": (palette.INK, palette.INK_DARK),
    "grid": (palette.GRID, palette.GRID_DARK),
    "paper": (palette.PAPER, palette.PAPER_DARK),
    "blue": (palette.SERIES[0], palette.SERIES[4]),
    "good": (palette.SERIES[2], palette.SERIES[2]),
    "bad": (palette.SERIES[1], palette.SERIES[1]),
    "warned": (palette.SERIES[5], palette.SERIES[5]),
    "open": (palette.SERIES[6], palette.TENSION[2]),
    "silk": (palette.SILK, palette.SERIES[3]),
}


def render(content: ReportContent) -> str:
    """Return the whole HTML document about a run."""
    title = f"{content.title}: {content.verdict.word}"
    return document(title, head(content), _sections(content))


def document(title: str, header: Html, parts: Sequence[Section]) -> str:
    """Return a whole HTML document.

    Args:
        title: Of the window.
        header: The part above all sections.
        parts: The sections.
    """
    main = element("main", header, [part.write() for part in parts])
    page = element(
        "html",
        element(
            "head",
            element("meta", charset="utf-8"),
            element("meta", name="viewport", content="width=device-width, initial-scale=1"),
            element("meta", name="color-scheme", content="light dark"),
            element("meta", http_equiv="Content-Security-Policy", content=ALONE),
            element("title", title),
            element("style", Html(colours() + stylesheet())),
        ),
        element(
            "body",
            element("div", _contents(parts), main, class_="page"),
            _foot(),
            element("script", Html(_file("report.js"))),
        ),
        lang="en",
    )
    return f"<!doctype html>\n{page}\n"


def _sections(content: ReportContent) -> list[Section]:
    every: list[Section | None] = [
        drawings.motion(content),
        outcome.expectations(content),
        drawings.logs(content),
        outcome.events(content),
        origins.numbers(content),
        origins.plan(content),
        outcome.run(content),
        outcome.exactness(content),
        outcome.validation(content),
        origins.warnings(content),
        origins.texts(content),  # after all that has links to its lines
        origins.again(content),
        origins.citing(content),
        origins.manifest(content),
    ]
    return [section for section in every if section is not None]


def _contents(parts: Sequence[Section]) -> Html:
    items = [element("li", link(part.key, part.title)) for part in parts]
    return element("nav", element("ol", items), aria_label="Contents")


def _foot() -> Html:
    return element("footer", element("p", f"Made by tissuec report {__version__}."))


def colours() -> str:
    """Return the shared colours as custom properties, in the light and in the dark."""
    light, dark = (
        "".join(f"--{name}:{pair[place]};" for name, pair in _COLOURS.items())
        for place in (0, 1)
    )
    return (
        f":root{{color-scheme:light dark;{light}}}\n"
        f"@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
    )


def stylesheet() -> str:
    """Return the style sheet, without the colours."""
    return _file("report.css")


def _file(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
