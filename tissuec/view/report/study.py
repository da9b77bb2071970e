"""The page about a study: what varied, pictures, sensitivities, failures and the table."""

from collections import Counter
from math import isfinite
from pathlib import Path
from typing import Any

from tissuec.core.errors import TissueError, counted
from tissuec.scene.study.entries import GRID, INDICES, LIST, ONE_AT_A_TIME
from tissuec.scene.study.model import called
from tissuec.studies.analysis.completed import Answer
from tissuec.studies.analysis.quantiles import PARTS, quantiles
from tissuec.studies.analysis.sensitivity import ends, sobol_indices
from tissuec.studies.report import doubts_in_words, promises, range_of, values_of
from tissuec.studies.table import DONE, ENDED, StudyTable
from tissuec.view.plots import PLOTS, USUAL, draw
from tissuec.view.report.markup import Content, Html, Section, element, html, row
from tissuec.view.report.markup import table as table_of
from tissuec.view.report.page import document, inline, lacking

MOST_ROWS = 500  # of the table on the page


def render_study(table: StudyTable, path: Path) -> str:
    """Return the whole HTML document about a study.

    Args:
        path: Its file.
    """
    shown = table.shown
    found = (
        _factors(table),
        _measures(shown),
        _pictures(table),
        _indices(table),
        _quantiles(shown),
        _failures(table),
        _runs(shown),
    )
    parts = [section for section in found if section is not None]
    return document(
        f"{called(table.head.name)} of {table.head.scene}", _head(table, path), parts
    )


def verdict(table: StudyTable) -> str:
    """Return one sentence about how a study went."""
    failed = len(table) - int(table.finished.sum())
    if not table.is_complete:
        return f"not finished: {len(table)} of {table.head.planned} runs"
    return f"{counted(failed, 'run')} of {len(table)} failed" if failed else "all runs done"


def _head(table: StudyTable, path: Path) -> Html:
    is_good = table.is_complete and table.finished.all() and not any(table.doubts)
    tone = "good" if is_good else "warned"
    head = table.head
    return element(
        "header",
        element("p", "Report of a study · ", path.name, class_="kicker"),
        element("h1", f"{head.name}: many runs of {head.scene}"),
        element("div", element("p", verdict(table)), class_=f"verdict {tone}"),
        element("p", _sentence(table), class_="summary"),
    )


def _sentence(table: StudyTable) -> str:
    outcomes = ", ".join(f"{count} {name}" for name, count in Counter(table.outcome).items())
    kept = ", ".join(f"{count} {name}" for name, count in promises(table).items())
    sentence = f"Design: {table.head.design}; outcomes: {outcomes}; accuracy: {kept}."
    doubts = doubts_in_words(table)
    return f"{sentence} Doubtful: {doubts}." if doubts else sentence


def _factors(table: StudyTable) -> Section:
    written = {one.name: one.values for one in table.head.factors}
    rows = [row(one.title, written[one.name], values_of(one)) for one in table.factors]
    return Section(
        "factors", "What varied", table_of("Factors", ("factor", "as written", "values"), rows)
    )


def _measures(table: StudyTable) -> Section | None:
    if not table.measures:
        return None
    rows = [row(one.title, range_of(table, one)) for one in table.measures]
    heads = ("measure", "range over the runs that finished")
    return Section("measures", "What was measured", table_of("Measures", heads, rows))


def _pictures(table: StudyTable) -> Section:
    if why := lacking():
        return Section("pictures", "Pictures", element("p", why))
    return Section(
        "pictures", "Pictures", html([_picture(table, kind) for kind in _telling(table)])
    )


def _telling(table: StudyTable) -> list[str]:
    """Return the kinds of plots that suit a table; values that are listed scatter little."""
    members: dict[str, Any] = {kind: PLOTS[kind] for kind in USUAL["table"]}
    kinds = [kind for kind, member in members.items() if member.suits(table)]
    is_listed = table.head.design in (GRID, LIST, ONE_AT_A_TIME)
    return [k for k in kinds if k != "scatter-matrix" or not is_listed] or kinds


def _picture(table: StudyTable, kind: str) -> Html:
    try:
        figure: Any = draw(kind, table)
    except TissueError as error:
        return element("p", f"{kind}: {error}")
    return inline(figure, kind, f"{kind} of {called(table.head.name)}")


def _indices(table: StudyTable) -> Section | None:
    """Return the Sobol indices of all measures; None for other designs."""
    if table.head.design != INDICES:
        return None
    parts: list[Content] = []
    for measure in table.measures:
        try:
            found = sobol_indices(table, measure.name)
        except ValueError as error:
            parts.append(element("p", f"{measure.name}: {error}."))
            continue
        rows = [
            row(
                one.factor,
                f"{one.first:.3f}",
                ends(one.first_interval),
                f"{one.total:.3f}",
                ends(one.total_interval),
            )
            for one in found
        ]
        heads = ("factor", "first order", "95 % interval", "total", "95 % interval")
        parts.append(table_of(f"Sobol indices of {measure.name}", heads, rows))
        parts += _notes(found)
    return Section("indices", "Sensitivities", html(parts))


def _notes(found: Answer[Any]) -> list[Content]:
    """Return paragraphs on what an answer leaves out."""
    return [element("p", f"{found.measure}: {note}.") for note in found.notes()]


def _quantiles(table: StudyTable) -> Section | None:
    """Return quantiles of all measures; None where runs are no sample."""
    rows: list[Html] = []
    notes: list[Content] = []
    for measure in table.measures:
        try:
            found = quantiles(table, measure.name)
        except ValueError:
            continue
        rows.append(row(measure.title, *map(str, found)))
        notes += _notes(found)
    if not rows:
        return None
    heads = ("measure", *(f"{100 * part:g} %" for part in PARTS))
    caption = "Quantiles with 95 % intervals"
    parts = html([table_of(caption, heads, rows), *notes])
    return Section("quantiles", "Distributions", parts)


def _failures(table: StudyTable) -> Section | None:
    """Return why runs failed or ended early; None if none did."""
    reasons = Counter(
        (outcome, reason)
        for outcome, reason in zip(table.outcome, table.reason, strict=True)
        if outcome != DONE
    )
    if not reasons:
        return None
    rows = [
        row(outcome, str(count), reason) for (outcome, reason), count in reasons.most_common()
    ]
    title = "Runs that ended early" if {o for o, _ in reasons} == {ENDED} else "Failed runs"
    return Section("failures", title, table_of("Reasons", ("outcome", "runs", "reason"), rows))


def _runs(table: StudyTable) -> Section:
    shown = min(len(table), MOST_ROWS)
    heads = [
        "run",
        *(column.title for column in table.columns),
        "outcome",
        "accuracy",
        "doubts",
    ]
    rows = [
        row(
            str(table.runs[n]),
            *(_cell(column.values[n]) for column in table.columns),
            table.outcome[n],
            table.promise[n],
            table.doubts[n],
        )
        for n in range(shown)
    ]
    more = None
    if shown < len(table):
        more = element("p", f"The first {shown} of {len(table)} rows; the file has all.")
    return Section("runs", "All runs", html([table_of("Runs", heads, rows), more]))


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.5g}" if isfinite(value) else "–"
