"""Facts that a result file records of its run: origin, settings, and how it went."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.profile_tables import table_texts
from tissuec.core.data import as_data
from tissuec.scene.force_numbers import numbers_of
from tissuec.scene.request import Request
from tissuec.script.plan import Plan
from tissuec.script.procedures import stated
from tissuec.script.tools import HandTool, NamedTool

if TYPE_CHECKING:
    from tissuec.engine.execution.companion import ErrorEstimate
    from tissuec.engine.execution.run import Outcome


def outcome_facts(
    plan: Plan, outcome: "Outcome", estimate: "ErrorEstimate | None"
) -> Mapping[str, Any]:
    """Return the facts about a run that its result records.

    Args:
        plan: Of the run.
        outcome: Of the run.
        estimate: Of its error, if one was made.
    """
    facts = {
        "kind": outcome.kind,
        "method": outcome.statistics.method,
        "statistics": as_data(outcome.statistics),
        "notes": list(outcome.notes),
        "doubts": [as_data(doubt) for doubt in outcome.doubts],
        "without_effect": [as_data(one) for one in outcome.without_effect],
        "expectations": list(_judged(plan, outcome, estimate)),
        "failed_expectations": len(outcome.failures),
        "unreached_expectations": len(outcome.unreached),
    }
    return facts if estimate is None else facts | {"promise": estimate.as_dict()}


def _judged(
    plan: Plan, outcome: "Outcome", estimate: "ErrorEstimate | None"
) -> Iterator[Mapping[str, Any]]:
    """Yield whether each expectation holds, with the time and the numbers that decide it."""
    undecided: Mapping[int, str] = {} if estimate is None else estimate.undecided
    failures = {failure.expectation: failure for failure in outcome.failures}
    for number, expectation in enumerate(plan.expectations):
        state, time, measured = "holds", *outcome.held.get(number, (None, ""))
        if number in failures:
            state, time = "fails", failures[number].time
            measured = failures[number].measured
        elif number in outcome.unreached:
            state = "not reached"
        span = expectation.span
        yield {
            "expect": span.with_values, "place": span.place, "state": state,
            "time": time, "measured": measured, "undecided": undecided.get(number, ""),
        }  # fmt: skip


def digests(compiled: Compiled) -> Mapping[str, str]:
    """Return the SHA-256 digests of mesh files, by the names that the scene has for them."""
    meshes = (placed.drawing.mesh for placed in compiled.groups.bodies.values())
    origins = (mesh.origin for mesh in meshes if mesh.origin is not None)
    return {origin.file.name: origin.digest for origin in origins}


def sources_of(compiled: Compiled) -> Mapping[str, str]:
    """Return the other texts of a scene: the files that it uses, and its tables."""
    declarations = compiled.scene.declarations
    script = declarations.single.get("script")
    tables = table_texts(script.items, declarations.library) if script is not None else {}
    return {source.name: source.text for source in compiled.scene.imports} | tables


def manifest_of(compiled: Compiled, request: Request) -> Mapping[str, Any]:
    """Return the facts of a result about its origin: text, settings and plan."""
    from tissuec.compiler.prediction import skipped

    simulation = compiled.plan.simulation
    return {
        "scene": request.source.name,
        "about": "",
        **compiled.scene.metadata.written,
        "sources": sources_of(compiled),
        "files": digests(compiled),
        "overrides": list(request.overrides),
        "libraries": [str(folder) for folder in request.libraries],
        "integrator": simulation.integrator,
        "tolerance": simulation.tolerance,
        "step": simulation.step,
        "choices": stated(simulation.choices, defaults=False) or None,
        "duration": simulation.duration,
        "plan": {"skipped": list(skipped(compiled))},
        "tissues": _tissues_of(compiled),
        "tools": _tools_of(compiled),
        "forces": as_data(numbers_of(compiled.scene.forces)),
    }


def _tools_of(compiled: Compiled) -> Mapping[str, Any]:
    """Return the kind of each tool, and how it is drawn as far as the scene says it."""
    found: dict[str, dict[str, Any]] = {}
    for tool in compiled.scene.tools.values():
        found[tool.name] = {"kind": tool.kind}
        if isinstance(tool.entries, HandTool) and tool.entries.shaft is not None:
            found[tool.name]["shaft"] = tool.entries.shaft.tolist()
        if isinstance(tool.entries, NamedTool) and tool.entries.size is not None:
            found[tool.name]["size"] = tool.entries.size
    return found


def _tissues_of(compiled: Compiled) -> Mapping[str, Any]:
    """Return the tissue of each body and of its regions, and how it looks."""
    found: dict[str, dict[str, Any]] = {}
    for body in compiled.scene.bodies.values():
        parts = {"": body.tissue} | {
            one.name: one.tissue or body.tissue for one in body.regions
        }
        found[body.name] = {
            part: {"name": tissue.name, **as_data(tissue.appearance)}
            for part, tissue in parts.items()
            if tissue is not None
        }
    return found
