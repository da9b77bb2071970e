"""The page about a run: one self-contained HTML document, with its motion and its plots."""

import re
from base64 import b64encode
from collections.abc import Iterator, Sequence
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.core import palette
from tissuec.core.errors import TissueError
from tissuec.core.palette import GRID, INK, PAPER
from tissuec.core.version import __version__
from tissuec.results.trajectory import Log
from tissuec.view.player.options import Options
from tissuec.view.player.page import fragment
from tissuec.view.plots import draw
from tissuec.view.plots.page import need_matplotlib
from tissuec.view.report import origins, outcome, page
from tissuec.view.report.content import ReportContent, capital, head
from tissuec.view.report.markup import Content, Html, Section, element, html, link, row, table

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
        page.motion(content),
        outcome.expectations(content),
        page.logs(content),
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


#: Colours that follow the page into the dark.
_THEMED = {INK: "var(--ink)", GRID: "var(--grid)", PAPER: "var(--paper)"}
_DPI = 110  # of pictures for paper


def lacking() -> str:
    """Return why there are no pictures, empty if there are."""
    try:
        need_matplotlib()
    except TissueError as error:
        return str(error)
    return ""


def curves(content: ReportContent, kind: str) -> Html:
    """Return a plot over time as an inline drawing, or why there is none."""
    try:
        drawn: Any = draw(kind, content.trajectory)
    except TissueError as error:
        return element("p", str(error))
    return inline(drawn, kind, f"{kind} of {content.title} over time")


def inline(drawn: Any, key: str, label: str) -> Html:
    """Return a figure of matplotlib as an inline drawing, with label and notes as caption.

    Args:
        drawn: The figure, with ``notes``.
        key: Tells its names from those of other drawings on the page.
        label: Description for those who do not see it.
    """
    written = StringIO()
    drawn.savefig(written, format="svg", outlines=True)
    picture = Html(_inline(written.getvalue(), key))
    caption = ". ".join(capital(text).rstrip(".") for text in (label, *drawn.notes))
    shown = element("div", picture, role="img", aria_label=label)
    return element("figure", shown, element("figcaption", f"{caption}."))


def for_paper(content: ReportContent, kind: str, label: str) -> Html | None:
    """Return a plot that is printed and not shown; None where there is none.

    Args:
        kind: Kind of plot.
        label: Description for those who do not see it.
    """
    try:
        drawn: Any = draw(kind, content.trajectory)
    except TissueError:
        return None
    written = BytesIO()
    drawn.savefig(written, format="png", dpi=_DPI)
    data = f"data:image/png;base64,{b64encode(written.getvalue()).decode()}"
    return element("img", src=data, alt=label, class_="on-paper")


def _inline(svg: str, key: str) -> str:
    """Return a drawing as a part of a page: without a head, and with names of its own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<(metadata|style)\b.*?</\1>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg).replace("xlink:href", "href")
    meant = {f'id="{name}"' for name in re.findall(r"#([\w.:-]+)", svg)}
    svg = re.sub(r' (id="[^"]*")', lambda found: found[0] if found[1] in meant else "", svg)
    svg = re.sub(r'\b(id|href)="(#?)', rf'\1="\2{key}-', svg).replace("url(#", f"url(#{key}-")
    for colour, name in _THEMED.items():
        svg = svg.replace(colour, name)
    return svg


_MOST_ROWS = 200  # of the table of extremes


def logs(content: ReportContent) -> Section | None:
    """Return everything that was logged; None where nothing was."""
    kinds = list(_kinds(content))
    if not kinds:
        return None
    body = html((_figures(content, kinds), _extremes(content)))
    return Section("curves", "Logs and energies", body)


def _kinds(content: ReportContent) -> Iterator[str]:
    """Yield the kinds of plots for which there are rows."""
    trajectory = content.trajectory
    if any(len(log.time) for log in trajectory.logs.values()):
        yield "logs"
    if trajectory.energies is not None and len(trajectory.energies.time):
        yield "energies"
    if trajectory.errors is not None and (trajectory.errors.value > 0.0).any():
        yield "errors"


def _figures(content: ReportContent, kinds: list[str]) -> Content:
    if why := lacking():
        return element("p", f"{capital(why)}.")
    return [curves(content, kind) for kind in kinds]


def _extremes(content: ReportContent) -> Content:
    """Return the numbers that the curves run between."""
    trajectory = content.trajectory
    logs = [*trajectory.logs.values()]
    logs += [trajectory.energies] if trajectory.energies is not None else []
    rows = [cells for log in logs for cells in _rows(log)]
    if not rows:
        return None
    heads = ("log", "minimum", "maximum", "at the end", "unit")
    left = element("p", f"{len(rows) - _MOST_ROWS} more rows are omitted.")
    return (
        table("Extremes of the logs", heads, rows[:_MOST_ROWS]),
        left if len(rows) > _MOST_ROWS else None,
    )


def _rows(log: Log) -> Iterator[Html]:
    """Yield one row for each column of a log."""
    if not len(log.time):
        return
    _, rows = log.with_jumps()
    scale = log.scale
    for number, column in enumerate(log.columns):
        name = log.name if column == "value" else f"{log.name}: {column}"
        values = rows[:, number]
        known = values[np.isfinite(values)]
        numbers = (known.min(), known.max(), values[-1]) if len(known) else (np.nan,) * 3
        yield row(name, *(_shown(one) for one in scale.of(numbers)), scale.unit or "–")


def _shown(number: float) -> str:
    return f"{number:.4g}" if np.isfinite(number) else "–"


#: What the player brings along: positions of all frames, and nodes of one.
MOST_POSITIONS, MOST_NODES = 400_000, 20_000
FEWEST_FRAMES = 20


def motion(content: ReportContent) -> Section:
    """Return the motion, to be played."""
    return Section("motion", "Motion", html(_motion(content)))


def _motion(content: ReportContent) -> Content:
    frames, nodes = len(content.trajectory.times), len(content.trajectory.nodes)
    if not frames or not nodes:
        return element("p", "The run recorded no trajectory, so there is no motion to play.")
    options, less = chosen(frames, nodes)
    label = f"the motion of {content.title}"
    still = None if lacking() else for_paper(content, "frames", label)
    caption = f"{capital(label)}." + (f" Shown are {less}." if less else "")
    played = Html(fragment(content.trajectory, options))
    return element("figure", played, still, element("figcaption", caption))


def chosen(frames: int, nodes: int) -> tuple[Options, str]:
    """Return the parts of a run that fit on a page of some megabytes, and what is left out."""
    shown = min(nodes, MOST_NODES)
    most = max(MOST_POSITIONS // shown, FEWEST_FRAMES)
    left = [
        f"{few} of {many} {what}"
        for few, many, what in ((most, frames, "frames"), (shown, nodes, "nodes"))
        if few < many
    ]
    options = Options(
        frames=most if most < frames else None, nodes=shown if shown < nodes else None
    )
    return options, " and ".join(left)
