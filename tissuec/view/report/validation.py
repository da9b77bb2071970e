"""The run compared with SciPy's solution, by what ``tissuec validate --json`` prints."""

from collections.abc import Mapping
from typing import Any, cast

from tissuec.results.trajectory import Trajectory
from tissuec.validate.report import VERDICTS, measured, validation_report, verdict
from tissuec.view.report.content import ReportContent
from tissuec.view.report.expectations import mark
from tissuec.view.report.markup import Section, element, html, shown
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
    tone = _TONES.get(document["verdict"], "open")
    parts = (
        element("p", mark(tone, verdict(document))),
        shown(document["reasons"]),
        shown(measured(document)),
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
        if not isinstance(document, Mapping) or document["verdict"] not in VERDICTS:
            return False
        known = cast("Mapping[str, Any]", document)
        validation_report(known, {})
    except (KeyError, TypeError, ValueError, AttributeError):
        return False
    return True
