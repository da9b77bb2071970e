"""Title, verdict, one sentence about the run, and its numbers at a glance."""

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from tissuec.core.units import TIME, show
from tissuec.results import wording
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, element, html, link


def head(story: ReportContent) -> Html:
    """Return what stands above all sections."""
    about = story.manifest.get("about")
    return element(
        "header",
        element("p", "Report of a run · ", story.trajectory.path.name, class_="kicker"),
        element("h1", story.title),
        element("p", about, class_="about") if about else None,
        _verdict(story),
        element("p", f"{'; '.join(sentence(story))}.", class_="summary"),
        _tiles(story),
        element("p", _made(story), class_="made"),
        _doubts(story),
    )


def capital(text: str) -> str:
    """Return a text that begins a sentence."""
    return text[:1].upper() + text[1:]


def _verdict(story: ReportContent) -> Html:
    verdict = story.verdict
    sign = element("span", verdict.sign, aria_hidden="true")
    reasons = [element("li", link(target, reason)) for reason, target in verdict.reasons]
    return element(
        "div",
        element("p", sign, " ", capital(verdict.word)),
        element("ul", reasons) if reasons else None,
        class_=f"verdict {verdict.tone}",
    )


def sentence(story: ReportContent) -> Iterator[str]:
    """Yield the clauses of the sentence that sums a run up."""
    net = story.facts["network"]
    yield wording.net(net["nodes"], net["springs"])
    yield from _reached(story)
    if story.statistics is not None:
        yield wording.stepping(story.manifest)
    yield from wording.springs_of_events((one.kind, one.springs) for one in story.events)
    states = [one.state for one in story.expectations]
    if states and story.kind == "done" and "not recorded" not in states:
        yield f"expectations: {wording.expectations(states)}"
    if story.promise.since is None and story.promise.error is not None:
        yield f"accuracy: {wording.accuracy(story.promise)}"


def _reached(story: ReportContent) -> Iterator[str]:
    duration = story.manifest.get("duration")
    if duration is None:
        return
    if story.kind == "done":
        yield f"{show(duration, TIME)} simulated"
        return
    known = [story.trajectory.times, *(log.time for log in story.trajectory.logs.values())]
    known.append(np.array([event.time for event in story.events]))
    last = [float(times[-1]) for times in known if len(times)]
    if last:
        yield f"{show(max(last), TIME)} of {show(duration, TIME)} simulated"


def _tiles(story: ReportContent) -> Html:
    tiles = [
        element("div", element("dt", name), element("dd", value, element("small", unit)))
        for name, value, unit in _numbers(story)
    ]
    return element("dl", tiles, class_="tiles")


def _numbers(story: ReportContent) -> Iterator[tuple[str, str, Content]]:
    """Yield name, number, and what it is measured in or by."""
    net, statistics = story.facts["network"], story.statistics
    yield "nodes", f"{net['nodes']:,}", ""
    yield "springs", f"{net['springs']:,}", ""
    yield "frames", f"{story.facts['frames']['count']:,}", ""
    if statistics is not None:
        yield "steps", f"{statistics['accepted']:,}", ""
    number, _, unit = show(story.manifest["wall_time"], TIME).partition(" ")
    yield "computing", number, unit
    if story.expectations:
        yield "expectations", f"{story.count('holds')}", f"of {len(story.expectations)} hold"
    if story.promise.error is not None:
        allowed = story.manifest.get("tolerance")
        promise = f"{allowed:g} allowed" if allowed else ""
        yield "error", f"{story.promise.error:.1e}", promise


def _made(story: ReportContent) -> Html:
    """Return when the scene was run, and with which versions."""
    return html((_when(story), "; ", versions(story), "."))


def versions(story: ReportContent) -> str:
    """Return the versions that a run was made with."""
    return ", ".join(f"{name} {one}" for name, one in story.manifest["versions"].items())


def _when(story: ReportContent) -> Content:
    begun = story.manifest.get("begun")
    if begun is None:
        return "Run at an unknown time"
    moment = datetime.fromisoformat(begun)
    return "Run on ", element("time", f"{moment:%d %B %Y, %H:%M} UTC", datetime=begun)


def _doubts(story: ReportContent) -> Html | None:
    doubts = story.retelling.doubts
    if not doubts:
        return None
    items = [
        element("li", f"{doubt.text}.", [element("pre", text) for text in doubt.details])
        for doubt in doubts
    ]
    lead = element("p", "This page may differ from the run:")
    return element("div", lead, element("ul", items), class_="doubts")
