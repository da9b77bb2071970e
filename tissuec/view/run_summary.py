"""The report on a run."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tissuec.compiler.manifest import outcome_facts
from tissuec.core.errors import Diagnostic, as_dict
from tissuec.core.report import (
    DONE,
    FAILED,
    STOPPED,
    Fact,
    FactSection,
    Part,
    Report,
    judged,
)
from tissuec.core.signals import exit_code
from tissuec.core.units import TIME, show
from tissuec.results.promise import Promise, stepping
from tissuec.results.recording import ExpectationResult, concerned, springs_of_events

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.engine.execution.run import Outcome
    from tissuec.model.network import Network
    from tissuec.pipeline import Result

MOST_SPRINGS_NAMED = 6
_TAKEN = ("wall_time", "statistics", "notes", "doubts", "without_effect")


def run_report(
    scene: str,
    compiled: "Compiled",
    result: "Result",
    warnings: Sequence[Diagnostic],
    again: str,
    *,
    strict: bool,
    details: bool = False,
) -> Report:
    """Return the report on a run.

    Args:
        scene: The path of the scene.
        compiled: The scene.
        result: The outcome and its files.
        warnings: About the text.
        again: The command line that resumes the run if it was interrupted.
        strict: Whether doubtful numbers and an unknown error are failures.
        details: Whether all events are listed.
    """
    outcome = result.outcome
    known = outcome_facts(compiled.plan, outcome, result.estimate)
    facts = {**known, "wall_time": outcome.wall_time}
    is_interrupted = outcome.kind == "interrupted"
    document = {"scene": scene, **_document(compiled, result, facts)}
    parts: list[Part] = [*_said(compiled, result, facts, details=details)]
    if is_interrupted and outcome.is_saved:
        document["go_on_with"] = again
        parts.append(Fact("resume with", again))
    is_fine = is_interrupted or outcome.kind == "done"
    title = Fact("", f"{scene}: {outcome.message}", "remark" if is_fine else "failure")
    document["diagnostics"] = [*map(as_dict, warnings)]
    code = _code(outcome, facts, strict=strict)
    return Report((title, FactSection("", parts)), document, code, level="remark")


def _code(outcome: "Outcome", facts: Mapping[str, Any], *, strict: bool) -> int:
    if outcome.kind == "interrupted" or outcome.signal is not None:
        return exit_code(outcome.signal)
    if outcome.kind != "done":
        return STOPPED
    undecided = any(one["undecided"] for one in facts["expectations"])
    is_off = strict and (Promise.of(facts).since is not None or outcome.doubts or undecided)
    return FAILED if outcome.failures or outcome.unreached or is_off else DONE


def _said(
    compiled: "Compiled", result: "Result", facts: Mapping[str, Any], *, details: bool
) -> Iterator[Part]:
    outcome, network = result.outcome, compiled.network
    yield f"{network.size}; {stepping(facts)}"
    yield from (Fact("note", note) for note in outcome.notes)
    yield from _events(outcome, network, details=details)
    yield from springs_of_events(
        ((e.kind, e.springs) for _, e in outcome.logged_events), network
    )
    expectations = [ExpectationResult(**one) for one in facts["expectations"]]
    states = ("fails", "not reached") if outcome.kind == "done" else ("fails",)
    failures = (one.failure for one in expectations if one.state in states)
    yield from judged([one.state for one in expectations], failures)
    for one in expectations:
        if one.undecided:
            yield Fact("undecided", f"{one.place}: {one.expect}: {one.undecided}", "failure")
    for doubt in outcome.doubts:
        yield Fact("doubtful", str(doubt), "failure")
    yield from (Fact("note", str(one)) for one in outcome.without_effect)
    if "promise" in facts:
        promise = Promise.of(facts)
        yield _accuracy(promise)
        if promise.logs:
            yield Fact("accuracy of logs in time", promise.sentence_on_logs)
    if network.size.elements:
        yield Fact("mesh", "not checked; tissuec validate SCENE --mesh estimates its error")
    yield Fact("result", str(result.path))
    yield from (Fact(f"surface of {name}", str(view)) for name, view in result.views.items())
    if result.blocks is not None:
        yield Fact("blocks", str(result.blocks))
    yield from (Fact("note", sentence) for sentence in result.left_out)


def _events(outcome: "Outcome", network: "Network", *, details: bool) -> Iterator[Fact]:
    """Yield notes, events of conditions, and first slips and leaks; or all events."""
    known: set[str] = set()
    doubted = {doubt.what for doubt in outcome.doubts}
    for time, event in outcome.logged_events:
        subject = event.cause if event.kind == "slip" else ""
        subject = event.span.place if event.kind == "leak" else subject
        is_first = bool(subject) and subject not in known
        known.add(subject)
        is_note = event.kind == "note" and event.cause not in doubted
        if details or is_first or is_note or event.kind == "trigger":
            what = f"{event.kind}{_springs(network, event.springs)}: {event.cause}"
            yield Fact(show(time, TIME), f"{what} ({event.span.place})")


def _springs(network: "Network", springs: Sequence[int]) -> str:
    """Return which springs something happened to, by the author's ids."""
    if not springs or max(springs) >= network.line_count:  # of elements, the cause says which
        return ""
    ids = ", ".join(str(network.number_of(spring)) for spring in springs[:MOST_SPRINGS_NAMED])
    more = ", …" if len(springs) > MOST_SPRINGS_NAMED else ""
    what = concerned(springs, network)[1]
    return f" of {what}{'s' if len(springs) > 1 else ''} {ids}{more}"


def _accuracy(promise: Promise) -> Fact:
    """Return how accurate positions are; a failure if less than the tolerance demands."""
    said = promise.sentence
    if promise.since is not None:
        return Fact("warning", said, "failure")
    verb = "" if promise.differs else "; checked"
    took = "" if promise.error is None else f"{verb} in {promise.seconds:.2f} s"
    return Fact("accuracy in time", f"{said}{took}")


def _document(
    compiled: "Compiled", result: "Result", facts: Mapping[str, Any]
) -> dict[str, Any]:
    outcome, expectations = result.outcome, facts["expectations"]
    return {
        "result": str(result.path),
        "surfaces": {name: str(view) for name, view in result.views.items()},
        "blocks": None if result.blocks is None else str(result.blocks),
        "left_out": list(result.left_out),
        "outcome": outcome.kind,
        "message": outcome.message,
        **compiled.network.size.facts,
        **{name: facts[name] for name in _TAKEN},
        "events": [
            {
                "time": time,
                "kind": event.kind,
                "springs": list(event.springs),
                "cause": event.cause,
                "place": event.span.place,
            }
            for time, event in outcome.logged_events
        ],
        "expectations": len(expectations),
        "failures": [
            {name: one[name] for name in ("expect", "time", "measured")}
            for one in expectations
            if one["state"] == "fails"
        ],
        "promise": str(Promise.of(facts)),
        "error_estimate": facts.get("promise"),
        "unreached": [one["expect"] for one in expectations if one["state"] == "not reached"],
    }
