"""Title, verdict, one sentence about the run, and its numbers at a glance."""

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from tissuec.core.report import holding
from tissuec.core.units import TIME, show
from tissuec.model.net_size import NetSize
from tissuec.results.manifest import credits
from tissuec.results.promise import stepping
from tissuec.results.recording import springs_of_events
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, element, html, link


def head(content: ReportContent) -> Html:
    """Return the part above all sections."""
    about, authors = content.manifest.get("about"), credits(content.manifest)
    return element(
        "header",
        element("p", "Report of a run · ", content.trajectory.path.name, class_="kicker"),
        element("h1", content.title),
        element("p", about, class_="about") if about else None,
        element("p", authors, class_="credits") if authors else None,
        _verdict(content),
        element("p", f"{'; '.join(sentence(content))}.", class_="summary"),
        _tiles(content),
        element("p", _made(content), class_="made"),
        _doubts(content),
    )


def capital(text: str) -> str:
    """Return a text that begins a sentence."""
    return text[:1].upper() + text[1:]


def _verdict(content: ReportContent) -> Html:
    verdict = content.verdict
    sign = element("span", verdict.sign, aria_hidden="true")
    reasons = [element("li", link(target, reason)) for reason, target in verdict.reasons]
    return element(
        "div",
        element("p", sign, " ", capital(verdict.word)),
        element("ul", reasons) if reasons else None,
        class_=f"verdict {verdict.tone}",
    )


def sentence(content: ReportContent) -> Iterator[str]:
    """Yield the clauses of the sentence that sums a run up."""
    net = content.facts["network"]
    yield str(NetSize(net["nodes"], net["springs"], net.get("elements", 0)))
    yield from _reached(content)
    if content.statistics is not None:
        yield stepping(content.manifest)
    yield from springs_of_events(
        ((one.kind, one.springs) for one in content.events),
        content.trajectory.network,
    )
    states = [one.state for one in content.expectations]
    if states and content.kind == "done" and "not recorded" not in states:
        yield f"expectations: {holding(states)}"
    if content.promise.since is None and content.promise.error is not None:
        yield f"accuracy: {content.promise.sentence}"


def _reached(content: ReportContent) -> Iterator[str]:
    duration = content.manifest.get("duration")
    if duration is None:
        return
    if content.kind == "done":
        yield f"{show(duration, TIME)} simulated"
        return
    known = [content.trajectory.times, *(log.time for log in content.trajectory.logs.values())]
    known.append(np.array([event.time for event in content.events]))
    last = [float(times[-1]) for times in known if len(times)]
    if last:
        yield f"{show(max(last), TIME)} of {show(duration, TIME)} simulated"


def _tiles(content: ReportContent) -> Html:
    tiles = [
        element("div", element("dt", name), element("dd", value, element("small", unit)))
        for name, value, unit in _numbers(content)
    ]
    return element("dl", tiles, class_="tiles")


def _numbers(content: ReportContent) -> Iterator[tuple[str, str, Content]]:
    """Yield name, number, and what it is measured in or by."""
    net, statistics = content.facts["network"], content.statistics
    yield "nodes", f"{net['nodes']:,}", ""
    yield "springs", f"{net['springs']:,}", ""
    yield "frames", f"{content.facts['frames']['count']:,}", ""
    if statistics is not None:
        yield "steps", f"{statistics['accepted']:,}", ""
    number, _, unit = show(content.manifest["wall_time"], TIME).partition(" ")
    yield "computing", number, unit
    if content.expectations:
        yield (
            "expectations",
            f"{content.count('holds')}",
            f"of {len(content.expectations)} hold",
        )
    if content.promise.error is not None:
        allowed = content.manifest.get("tolerance")
        promise = f"{allowed:g} allowed" if allowed else ""
        yield "error", f"{content.promise.error:.1e}", promise


def _made(content: ReportContent) -> Html:
    """Return when the scene was run, and with which versions."""
    return html((_when(content), "; ", versions(content), "."))


def versions(content: ReportContent) -> str:
    """Return the versions that a run was made with."""
    return ", ".join(f"{name} {one}" for name, one in content.manifest["versions"].items())


def _when(content: ReportContent) -> Content:
    begun = content.manifest.get("begun")
    if begun is None:
        return "Run at an unknown time"
    moment = datetime.fromisoformat(begun)
    return "Run on ", element("time", f"{moment:%d %B %Y, %H:%M} UTC", datetime=begun)


def _doubts(content: ReportContent) -> Html | None:
    doubts = content.recompiled.doubts
    if not doubts:
        return None
    items = [
        element("li", f"{doubt.text}.", [element("pre", text) for text in doubt.details])
        for doubt in doubts
    ]
    lead = element("p", "This page may differ from the run:")
    return element("div", lead, element("ul", items), class_="doubts")
