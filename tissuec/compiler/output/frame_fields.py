"""Fields that a trajectory records: ``trajectory with [pressure, …] every 10 ms``."""

from collections.abc import Collection, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.engine.execution.field_samples import preserved_bodies
from tissuec.lang import syntax as s
from tissuec.model.network import BodyPart, Network
from tissuec.results.fields import FIELDS, Place
from tissuec.scene.reading.findings import Findings
from tissuec.script.plan import Plan

_WHAT: dict[Place, str] = {
    "node": "node", "spring": "spring", "triangle": "triangle of a skin",
    "cell": "cell of a preserved volume", "element": "element of a solid that is shown whole",
}  # fmt: skip

#: Why a field is always 0, by what it needs.
_LACKING = {
    "elements": "the trajectory contains no elements",
    "springs": "the trajectory contains no springs but edges of elements",
    "faces": "nothing touches faces of elements",
}

#: What follows from positions, and need not be recorded.
_DERIVED = {
    name: f"it follows from the positions: tissuec view --field {name} shows it, and a blocks "
    "file, as by output { blocks }, contains it"
    for name in ("stress", "strain", "displacement")
}


def asked_fields(names: Sequence[s.Name], findings: Findings) -> dict[str, Span]:
    """Return the fields that are named after "with", with their places."""
    found: dict[str, Span] = {}
    for name in names:
        with findings.item():
            field = FIELDS.called(name.key)
            if not field:
                known = [one for one in FIELDS if not FIELDS[one].always]
                hint = _DERIVED.get(name.key) or alternatives(name.key, known, what="fields")
                findings.reject(
                    "TIS701", f'"{name.text}" is not a field of frames', name.span, hint=hint
                )
            if FIELDS[field].always:
                findings.reject(
                    "TIS303",
                    f"every trajectory contains the {field} of each {FIELDS[field].at}",
                    name.span,
                    hint="omit it",
                )
            if field in found:
                findings.refuse_second(f'"{field}"', name.span, found[field])
            found[field] = name.span
    return found


def _is_shown_whole(shown: NDArray[np.bool_], body: BodyPart) -> bool:
    """Return whether frames show all of a solid of elements; the nodes shown, (node,)."""
    return body.is_solid and body.is_made_of_elements and bool(shown[body.nodes].all())


def check_fields(
    asked: Mapping[str, Span],
    network: Network,
    plan: Plan,
    kinds: Collection[str],
    touched: str,
    findings: Findings,
) -> None:
    """Report fields that are about nothing that the frames show.

    Args:
        asked: Fields by name, with their places.
        plan: Of the run.
        kinds: Of the forces of the scene.
        touched: Where contact acts: on "faces", on those of "elements" only, on "nodes", or "".
        findings: Takes the errors.
    """
    shown = np.zeros(network.node_count, dtype=bool)
    shown[plan.output.frames] = True
    there: dict[Place, bool] = {
        "node": bool(shown.any()),
        "spring": bool((shown[network.line_ends].all(axis=1) & network.bears).any()),
        "triangle": bool(shown[network.skin].all(axis=1).any()),
        "cell": bool(preserved_bodies(network, plan)),
        "element": any(map(partial(_is_shown_whole, shown), network.bodies)),
    }
    elements = np.zeros_like(shown)
    for field in network.elements:
        elements[field.nodes] = True
    has = {
        "elements": bool((shown & elements).any()),
        "springs": there["spring"],
        "faces": touched == "faces" or (touched == "elements" and bool(elements.any())),
    }
    for name, span in asked.items():
        at, kind = FIELDS[name].at, FIELDS[name].of_force
        if kind and kind not in kinds:
            findings.add(
                "TIS304",
                f"the {name} is that of forces of the kind {kind}, but the scene has none",
                span,
                hint=f"for example: force NAME {{ kind is {kind}; acts on BODY; … }}",
            )
        elif not there[at]:
            findings.add(
                "TIS304",
                f"{name} has a value for each {_WHAT[at]}, but the trajectory contains none",
                span,
                hint="for example: at 0 s: preserve volume of BODY with 10 kPa"
                if at == "cell"
                else "",
            )
        elif lacking := next((one for one in FIELDS[name].needs if not has[one]), ""):
            findings.add(
                "TIS304",
                f"{name} is always 0: {_LACKING[lacking]}",
                span,
                hint="omit it",
            )
