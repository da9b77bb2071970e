"""The run compared with SciPy's solution, by what ``tissuec validate --json`` prints."""

from collections.abc import Mapping
from typing import Any, cast

from tissuec.results.trajectory import Trajectory
from tissuec.validate import summary
from tissuec.view.report.content import ReportContent
from tissuec.view.report.expectations import mark
from tissuec.view.report.markup import Section, element, html, listing, row, table
from tissuec.view.report.texts import file_name
from tissuec.view.report.verdict import Tone

_TONES: dict[str, Tone] = {
    "kept": "good", "broken": "bad", "diverged": "bad", "undecided": "warned",
}  # fmt: skip


def section(content: ReportContent) -> Section:
    """Return table and verdict, or how to get them."""
    document = content.validation
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


def misfit(document: Any, trajectory: Trajectory) -> str:
    """Return why a document is no validation of a run, empty if it is one."""
    if not _is_validation(document):
        return "is not an output of tissuec validate --json"
    manifest, network = trajectory.manifest, trajectory.network
    mine = {
        "scene": file_name(str(manifest.get("scene"))),
        **network.size.facts,
        "tolerance": manifest.get("tolerance"),
    }
    other = {name: document.get(name) for name in mine}
    other["scene"] = file_name(str(document.get("scene")))
    for name, value in mine.items():
        if name in document and other[name] != value:
            return (
                f'is of another run than "{trajectory.path}": its {name} is {other[name]}, '
                f"and not {value}"
            )
    return ""


def _is_validation(document: Any) -> bool:
    try:
        if not isinstance(document, Mapping) or document["verdict"] not in summary.HEADINGS:
            return False
        known = cast("Mapping[str, Any]", document)
        summary.as_text(known)
    except (KeyError, TypeError, ValueError, AttributeError):
        return False
    return True
