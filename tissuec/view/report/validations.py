"""Checks that a file is the output of ``tissuec validate --json`` for the scene of a run."""

from collections.abc import Mapping
from typing import Any, cast

from tissuec.results.trajectory import Trajectory
from tissuec.validate import summary
from tissuec.view.report.texts import file_name


def misfit(document: Any, trajectory: Trajectory) -> str:
    """Return why a document is no validation of a run, empty if it is one."""
    if not _is_validation(document):
        return "is not an output of tissuec validate --json"
    manifest, network = trajectory.manifest, trajectory.network
    mine = {
        "scene": file_name(str(manifest.get("scene"))),
        "nodes": network.body_nodes,
        "springs": network.spring_count,
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
