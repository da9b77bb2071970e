"""Outcome and accuracy of the run."""

from collections.abc import Iterator
from typing import Any

from tissuec.core.units import LENGTH, TIME, show
from tissuec.results import wording
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import (
    Content,
    Html,
    Section,
    element,
    html,
    listing,
    pairs,
    row,
    table,
)


def exactness(content: ReportContent) -> Section:
    """Return the known error of the run."""
    return Section("exactness", "Accuracy", pairs(_exactness(content)))


def _exactness(content: ReportContent) -> Iterator[tuple[Content, Content]]:
    manifest, errors = content.manifest, content.trajectory.errors
    if manifest.get("tolerance") is not None:
        text = f"{manifest['tolerance']:g} of the largest displacement so far"
        yield "tolerance", text
    elif manifest.get("step") is not None:
        step = show(manifest["step"], TIME)
        yield "tolerance", f"none: fixed step of {step}"
    if errors is not None and len(errors.value):
        worst = show(float(errors.value.max()), LENGTH)
        yield "estimate", f"{worst}, summed over all steps"
    yield "accuracy", wording.accuracy(content.promise)


def run(content: ReportContent) -> Section:
    """Return the outcome of the run, and its cost."""
    parts = (
        pairs(_facts(content)),
        _changes(content.statistics),
        (element("h3", "Doubtful"), listing(map(str, content.doubts)))
        if content.doubts
        else None,
        (element("h3", "Notes"), listing(content.notes)) if content.notes else None,
        _recorded(content),
    )
    return Section("run", "The run", html(parts))


def _facts(content: ReportContent) -> Iterator[tuple[Content, Content]]:
    manifest, statistics = content.manifest, content.statistics
    yield "outcome", manifest["outcome"]
    yield "computing time", show(manifest["wall_time"], TIME)
    if content.promise.seconds:
        yield "error estimate", f"{show(content.promise.seconds, TIME)} more"
    if statistics is None:
        yield "statistics", "None, because the run did not finish."
        return
    yield "method", wording.methods(statistics)
    yield "steps", _steps(statistics)
    yield "step size", _range(statistics)
    yield "force evaluations", f"{statistics['evaluations']:,}"
    if statistics["factorisations"] or statistics["solutions"]:
        both = f"{statistics['factorisations']:,} and {statistics['solutions']:,}"
        yield "factorisations and solutions", both


def _steps(statistics: Any) -> str:
    rejected = f", {statistics['rejected']:,} rejected"
    stalls = f", {statistics['stalls']:,} stalled" if statistics["stalls"] else ""
    return f"{statistics['accepted']:,} ({statistics['backend']}){rejected}{stalls}"


def _range(statistics: Any) -> str:
    low, high = (show(statistics[name], TIME) for name in ("smallest", "largest"))
    return low if low == high else f"{low} to {high}"


def _changes(statistics: Any) -> Html | None:
    """Return which method took over when, and why."""
    if statistics is None or not statistics["changes"]:
        return None
    rows = [
        row(show(one["time"], TIME), one["method"], one["reason"])
        for one in statistics["changes"]
    ]
    return table("Sequence of methods", ("from", "method", "reason"), rows)


def _recorded(content: ReportContent) -> Html:
    """Return what the file holds."""
    facts = content.facts
    frames = facts["frames"]
    rows = [row("frames", f"{frames['count']:,}", f"{frames['nodes']:,} nodes", _span(frames))]
    tables = {**facts["logs"], **({"energies": facts["energies"]} if facts["energies"] else {})}
    rows += [
        row(name, f"{log['rows']:,}", ", ".join(map(str, log["columns"][:8])), _span(log))
        for name, log in tables.items()
    ]
    rows += [
        row(f"surface of {name}", f"{one['count']:,}", one["kind"], _span(one))
        for name, one in facts["surfaces"].items()
    ]
    heads = ("recorded", "rows", "of", "time")
    return html(
        (
            element("h3", "Contents of the file"),
            table(f"Recorded in {wording.size(facts['bytes'])}", heads, rows),
        )
    )


def _span(one: Any) -> str:
    if one["first_time"] is None:
        return "–"
    return wording.span(one["first_time"], one["last_time"])
