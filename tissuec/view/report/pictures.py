"""Plots as parts of the page."""

import re
from base64 import b64encode
from io import BytesIO, StringIO
from typing import Any

from tissuec.core.errors import TissueError
from tissuec.core.palette import GRID, INK, PAPER
from tissuec.view.plots import draw
from tissuec.view.plots.page import need_matplotlib
from tissuec.view.report.content import ReportContent
from tissuec.view.report.head import capital
from tissuec.view.report.markup import Html, element

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
        content: Contents of the report.
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
