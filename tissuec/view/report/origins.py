"""The origin of every number, and the plan of the run, as in ``tissuec explain``."""

from collections.abc import Iterable

from tissuec.compiler.provenance import SET, ProvenanceRow, Reason, tissue_rows, used_tissues
from tissuec.core.report import FactSection
from tissuec.scene.model import Tissue
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, Section, element, html, row, shown, table
from tissuec.view.summaries.plan import plan_sections


def numbers(content: ReportContent) -> Section:
    """Return params, and the table of each tissue that bodies are made of."""
    words = content.recompiled.words
    if words is None:
        text = (
            "This version cannot read the files of this run, so the origin of numbers is "
            "unknown."
        )
        return Section("numbers", "Origin of the numbers", element("p", text))
    parts = [_params(content, words), *(_tissue(content, one) for one in used_tissues(words))]
    known = [part for part in parts if part is not None]
    body = html(known) if known else element("p", "The scene has neither params nor tissues.")
    return Section("numbers", "Origin of the numbers", body)


def _params(content: ReportContent, words: ResolvedProgram) -> Html | None:
    parameters = words.constants.parameters()
    if not parameters:
        return None
    rows = [
        row(
            one.name,
            str(one.value),
            SET if one.overridden else "written",
            content.texts.link(one.item.span.place),
        )
        for one in parameters
    ]
    heads = ("param", "value", "how", "line")
    return html((element("h3", "Params"), table("Params of the scene", heads, rows)))


def _tissue(content: ReportContent, tissue: Tissue) -> Html:
    heads = ("name", "value", "how", "because", "line")
    rows = [line for one in tissue_rows(tissue) for line in _rows(content, one)]
    missing = [
        element("p", element("b", name), f": none: {reason}")
        for name, reason in tissue.gaps.items()
    ]
    return html(
        (
            element("h3", tissue.name, " ", content.texts.link(tissue.span.place)),
            element("p", tissue.about) if tissue.about else None,
            table(f"Entries of {tissue.name}", heads, rows, "tissue") if rows else None,
            missing,
        )
    )


def _rows(content: ReportContent, entry: ProvenanceRow) -> Iterable[Html]:
    """Yield an entry as one row for each of its reasons."""
    first, *others = entry.reasons
    span = len(entry.reasons) if others else None
    cells = (
        element("th", entry.name, scope="row", rowspan=span),
        element("td", entry.value, rowspan=span),
        element("td", _how(entry), rowspan=span),
    )
    yield element("tr", cells, _reason(content, first), class_=entry.kind)
    for reason in others:
        yield element("tr", _reason(content, reason), class_=entry.kind)


def _how(entry: ProvenanceRow) -> str:
    return f"value: {entry.how}" if entry.kind == "property" else entry.how


def _reason(content: ReportContent, reason: Reason) -> Html:
    bar: Content = None
    if reason.degree is not None:
        # The number is beside it; the bar is for the eye.
        width = f"width:{100.0 * min(max(reason.degree, 0.0), 1.0):.0f}%"
        bar = element("span", element("i", style=width), class_="bar", aria_hidden="true")
    facts = element("small", reason.facts) if reason.facts else None
    because = element("td", bar, reason.said, " " if facts else None, facts)
    return html((because, element("td", content.texts.link(reason.place))))


def plan(content: ReportContent) -> Section:
    """Return the plan; that in the file where the scene cannot be compiled."""
    plan = content.prediction
    if plan is not None:
        return Section("plan", "Plan", shown(plan_sections(plan)))
    text = "Arrays and cost are unknown, because the scene could not be compiled again."
    skipped = content.manifest.get("plan", {}).get("skipped") or ["nothing"]
    parts = (element("p", text), shown([FactSection("skipped", skipped)]))
    return Section("plan", "Plan", html(parts))
