"""Logs, energies and errors over time: as curves, and their extremes as numbers."""

from collections.abc import Iterator

import numpy as np

from tissuec.results.trajectory import Log
from tissuec.view.report import pictures
from tissuec.view.report.content import ReportContent
from tissuec.view.report.head import capital
from tissuec.view.report.markup import Content, Html, Section, element, html, row, table

_MOST_ROWS = 200  # of the table of extremes


def section(content: ReportContent) -> Section | None:
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
    if lacking := pictures.lacking():
        return element("p", f"{capital(lacking)}.")
    return [pictures.curves(content, kind) for kind in kinds]


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
