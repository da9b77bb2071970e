"""The run compared with SciPy's solution, as in ``tissuec validate``."""

from tissuec.validate import summary
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import element, html, listing, row, table
from tissuec.view.report.sections import Section
from tissuec.view.report.sections.expectations import mark
from tissuec.view.report.verdict import Tone

_TONES: dict[str, Tone] = {
    "kept": "good", "broken": "bad", "diverged": "bad", "undecided": "warned",
}  # fmt: skip


def section(story: ReportContent) -> Section:
    """Return table and verdict, or how to get them."""
    document = story.validation
    if document is None:
        text = "The run was not compared with SciPy's solvers for this page; "
        how = element("code", "tissuec report --validate")
        return Section("validation", "Validation", element("p", text, how, " compares it."))
    rows = [row(*cells) for cells in summary.table(document)]
    tone = _TONES.get(document["verdict"], "open")
    parts = (
        element("p", mark(tone, summary.verdict(document))),
        listing(document["reasons"]) if document["reasons"] else None,
        table("Errors against SciPy", summary.COLUMNS, rows) if rows else None,
        [element("p", line, class_="remark") for line in summary.remarks(document)],
        listing([*summary.events(document), *summary.efforts(document)]) if rows else None,
    )
    return Section("validation", "Validation", html(parts))
