"""Outcome of a run: how it went, its error, expectations, events, and the validation."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

from tissuec.core.errors import counted, shown_size
from tissuec.core.units import LENGTH, TIME, show, show_interval
from tissuec.results.export import ELEMENT, event_facts
from tissuec.results.promise import methods
from tissuec.results.recording import Event, ExpectationResult
from tissuec.results.trajectory import Trajectory
from tissuec.validate.report import VERDICTS, measured, validation_report, verdict
from tissuec.view.report.content import SIGNS, ReportContent, Tone, file_name
from tissuec.view.report.markup import (
    Content,
    Html,
    Section,
    element,
    folded,
    html,
    listing,
    pairs,
    row,
    shown,
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
    yield "accuracy in time", content.promise.sentence


def run(content: ReportContent) -> Section:
    """Return the outcome of the run, and its cost."""
    parts = (
        pairs(_run_facts(content)),
        _changes(content.statistics),
        (element("h3", "Doubtful"), listing(map(str, content.doubts)))
        if content.doubts
        else None,
        (element("h3", "Notes"), listing(content.notes)) if content.notes else None,
        _recorded(content),
    )
    return Section("run", "The run", html(parts))


def _run_facts(content: ReportContent) -> Iterator[tuple[Content, Content]]:
    manifest, statistics = content.manifest, content.statistics
    yield "outcome", manifest["outcome"]
    yield "computing time", show(manifest["wall_time"], TIME)
    if content.promise.seconds:
        yield "error estimate", f"{show(content.promise.seconds, TIME)} more"
    if statistics is None:
        yield "statistics", "None, because the run did not finish."
        return
    yield "method", methods(statistics)
    yield "steps", _steps(statistics)
    yield "step size", _step_range(statistics)
    yield "force evaluations", f"{statistics['evaluations']:,}"
    if statistics["factorisations"] or statistics["solutions"]:
        both = f"{statistics['factorisations']:,} and {statistics['solutions']:,}"
        yield "factorisations and solutions", both


def _steps(statistics: Any) -> str:
    rejected = f", {statistics['rejected']:,} rejected"
    stalls = f", {statistics['stalls']:,} stalled" if statistics["stalls"] else ""
    return f"{statistics['accepted']:,} ({statistics['backend']}){rejected}{stalls}"


def _step_range(statistics: Any) -> str:
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
    """Return the contents of the file."""
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
            table(f"Recorded in {shown_size(facts['bytes'])}", heads, rows),
        )
    )


def _span(one: Any) -> str:
    if one["first_time"] is None:
        return "–"
    return show_interval(one["first_time"], one["last_time"])


TONES: Mapping[str, Tone] = {
    "holds": "good", "fails": "bad", "not reached": "open", "not recorded": "open",
}  # fmt: skip


def expectations(content: ReportContent) -> Section | None:
    """Return the table of expectations; None of a scene without any."""
    if not content.expectations:
        return None
    heads = ("verdict", "expectation", "measured", "at", "line")
    rows = [_expectation(content, one) for one in content.expectations]
    body = table("Expectations and measured values", heads, rows, "expectations")
    return Section("expectations", "Expectations", html((_lead(content), body)))


def _lead(content: ReportContent) -> Html | None:
    if content.count("not recorded"):
        return element("p", "The result does not record which of them hold.")
    if content.count("holds") and any(one.time is not None for one in content.expectations):
        text = "For an expectation that holds over an interval, the last measurement is shown."
        return element("p", text, class_="remark")
    return None


def _expectation(content: ReportContent, one: ExpectationResult) -> Html:
    clock = content.trajectory.clock
    time: Content = "–" if one.time is None else clock.text(one.time, digits=6)
    return row(
        mark(TONES[one.state], one.state),
        element("code", one.expect.removeprefix("expect ")),
        element("code", one.measured) if one.measured else "–",
        element("span", time, class_="number-cell"),
        content.texts.link(one.place),
    )


def mark(tone: Tone, word: str) -> Html:
    """Return a word with the sign that goes with it."""
    sign = element("span", SIGNS[tone], aria_hidden="true")
    return element("span", sign, " ", word, class_=f"mark {tone}")


MOST = 2000  # rows; more make a page that no browser likes
SHOWN = 8  # springs that are named by default
NAMED = 400  # springs of one event that are named at all


def events(content: ReportContent) -> Section:
    """Return the table of events."""
    events = content.events
    if not events:
        return Section("events", "Events", element("p", "There were no events."))
    rows = [_event(content, event) for event in events[:MOST]]
    heads = ("at", "event", "cause", "springs", "line")
    body = table("Events in order of time", heads, rows)
    return Section("events", "Events", html((body, _rest(content, len(events)))))


def _rest(content: ReportContent, count: int) -> Html | None:
    if count <= MOST:
        return None
    command = f'tissuec export "{content.trajectory.path.name}" events'
    return element(
        "p", f"{counted(count - MOST, 'more event')} follow: ", element("code", command)
    )


def _event(content: ReportContent, event: Event) -> Html:
    kind, springs, cause, place = event_facts(content.trajectory, event)
    time = content.trajectory.clock.text(event.time, digits=6)
    return row(
        time, element("b", kind), cause, _springs(springs.split()),
        content.texts.link(place),
    )  # fmt: skip


def _springs(names: Sequence[str]) -> Content:
    if len(names) <= SHOWN:
        return " ".join(names)
    rest = f" … and {len(names) - NAMED} more" if len(names) > NAMED else ""
    what = "element" if names[0].rpartition(":")[2].startswith(ELEMENT) else "spring"
    return folded(counted(len(names), what), element("p", " ".join(names[:NAMED]), rest))


_TONES: dict[str, Tone] = {
    "kept": "good", "broken": "bad", "diverged": "bad", "undecided": "warned",
}  # fmt: skip


def validation(content: ReportContent) -> Section:
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
