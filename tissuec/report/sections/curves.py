"""Logs, energies and errors over time: as curves, and their extremes as numbers."""

import re
from collections.abc import Iterator
from io import StringIO
from typing import Any

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.core.looks import GRID, INK, PAPER
from tissuec.report.markup import Content, Html, element, html, row, table
from tissuec.report.sections import Section
from tissuec.report.story import Story
from tissuec.results.trajectory import Log

#: Colours that follow the page into the dark.
_THEMED = {INK: "var(--ink)", GRID: "var(--grid)", PAPER: "var(--paper)"}
_MOST_ROWS = 200  # of the table of extremes


def section(story: Story) -> Section | None:
    """Return everything that was logged; None where nothing was."""
    kinds = list(_kinds(story))
    if not kinds:
        return None
    body = html((_figures(story, kinds), _extremes(story)))
    return Section("curves", "Logs and energies", body)


def _kinds(story: Story) -> Iterator[str]:
    """Yield the kinds of plots for which there are rows."""
    trajectory = story.trajectory
    if any(len(log.time) for log in trajectory.logs.values()):
        yield "logs"
    if trajectory.energies is not None and len(trajectory.energies.time):
        yield "energies"
    if trajectory.errors is not None and (trajectory.errors.value > 0.0).any():
        yield "errors"


def _figures(story: Story, kinds: list[str]) -> Content:
    try:
        from tissuec.drawing.page import need_matplotlib

        need_matplotlib()
    except TissueError as error:
        return element("p", f"{str(error)[:1].upper()}{str(error)[1:]}.")
    except ImportError:
        return element("p", "plots pending")
    return [figure(story, kind) for kind in kinds]


def figure(story: Story, kind: str, class_: str | None = None, **options: Any) -> Html:
    """Return a plot of a run as a figure of the page, or why there is none."""
    from tissuec.plots import draw

    try:
        drawn: Any = draw(kind, story.trajectory, **options)
    except TissueError as error:
        return element("p", str(error))
    written = StringIO()
    drawn.savefig(written, format="svg")
    picture = _inline(written.getvalue(), kind)
    label = f"{kind} of {story.title} over time"
    notes = [element("figcaption", note) for note in drawn.notes]
    content = element("div", Html(picture), role="img", aria_label=label)
    return element("figure", content, notes, class_=class_)


def _inline(svg: str, key: str) -> str:
    """Return a picture as a part of a page: without a head, and with names of its own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<(metadata|style)\b.*?</\1>", "", svg, flags=re.DOTALL)
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg).replace("xlink:href", "href")
    meant = {f'id="{name}"' for name in re.findall(r"#([\w.:-]+)", svg)}
    svg = re.sub(r' (id="[^"]*")', lambda m: m[0] if m[1] in meant else "", svg)
    svg = re.sub(r'\b(id|href)="(#?)', rf'\1="\2{key}-', svg).replace("url(#", f"url(#{key}-")
    for colour, name in _THEMED.items():
        svg = svg.replace(colour, name)
    return svg


def _extremes(story: Story) -> Html:
    trajectory = story.trajectory
    logs = [*trajectory.logs.values()]
    logs += [trajectory.energies] if trajectory.energies is not None else []
    rows = [cells for log in logs for cells in _rows(log)]
    heads = ("logged", "smallest", "largest", "at the end", "unit")
    left = element("p", f"{len(rows) - _MOST_ROWS} more rows are left out.")
    return html(
        (
            table("Extremes of what was logged", heads, rows[:_MOST_ROWS], "numbers"),
            left if len(rows) > _MOST_ROWS else None,
        )
    )


def _rows(log: Log) -> Iterator[Html]:
    """Yield one row for each column of a log."""
    if not len(log.time):
        return
    for number, column in enumerate(log.columns):
        name = log.name if column == "value" else f"{log.name}: {column}"
        values = log.value[:, number]
        known = values[np.isfinite(values)]
        numbers = (known.min(), known.max(), values[-1]) if len(known) else (np.nan,) * 3
        yield row(name, *(_shown(one) for one in numbers), log.unit or "–")


def _shown(number: float) -> str:
    return f"{number:.4g}" if np.isfinite(number) else "–"
