"""Facts about one run that the sections of its page share, its title and verdict."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from msgspec import Struct

from tissuec.analysis.result_scene import RecompiledScene, recompile
from tissuec.compiler.prediction import Prediction, predict
from tissuec.core.errors import counted
from tissuec.core.report import holding
from tissuec.core.units import TIME, show
from tissuec.model.blocks import NetSize
from tissuec.results.info import summary
from tissuec.results.manifest import RUNNING, credits
from tissuec.results.promise import Doubt, Promise, kinds, stepping
from tissuec.results.recording import Event, ExpectationResult, springs_of_events
from tissuec.results.trajectory import Trajectory
from tissuec.script.verbs.end import KIND as END
from tissuec.validate.report import VERDICTS
from tissuec.view.report.markup import Content, Html, element, html, link


def file_name(path: str) -> str:
    """Return the last part of a path of any system."""
    return path.replace("\\", "/").rpartition("/")[2]


class Texts:
    """The scene and its imports, by name.

    Attributes:
        texts: The scene first.
        linked: The lines that the page leads to, by name; they must be shown.
    """

    def __init__(self, scene: str, text: str, used: Mapping[str, str]):
        self.scene = scene
        self.texts = {scene: text} | {name: used[name] for name in used if name != scene}
        self.linked: dict[str, set[int]] = {name: set() for name in self.texts}
        self._lines = {name: text.count("\n") + 1 for name, text in self.texts.items()}
        self._keys = {name: f"text-{number}" for number, name in enumerate(self.texts)}

    def key(self, name: str) -> str:
        """Return the anchor of a text."""
        return self._keys[name]

    def anchor(self, name: str, line: int) -> str:
        """Return the anchor of a line."""
        return f"{self._keys[name]}-{line}"

    def link(self, place: str) -> Html:
        """Return ``file:line`` as a link to that line; as text if it is not on the page.

        The scene is shown without the folder that it lay in.
        """
        name, _, digits = place.rpartition(":")
        if name not in self.texts or not digits.isdecimal():
            return html(place)
        line = int(digits)
        if not 1 <= line <= self._lines[name]:
            return html(place)
        self.linked[name].add(line)
        shown = f"{file_name(name)}:{line}" if name == self.scene else place
        return element("span", link(self.anchor(name, line), shown), class_="place")


Kind = Literal["done", "stopped", "unfinished"]
Tone = Literal["good", "bad", "warned", "open"]
SIGNS: Mapping[Tone, str] = {"good": "✓", "bad": "✗", "warned": "!", "open": "…"}


class Headline(Struct, frozen=True):
    """The headline of a report.

    Attributes:
        tone: Also shown by a colour.
        word: A few words.
        reasons: Why, each with the section of the page that explains it.
    """

    tone: Tone
    word: str
    reasons: tuple[tuple[str, str], ...]

    @property
    def sign(self) -> str:
        """Return the sign that says the same as the colour."""
        return SIGNS[self.tone]


def kind_of(manifest: Mapping[str, Any]) -> Kind:
    """Return whether a run reached its end, failed, or can be resumed."""
    if manifest["finished"]:
        return "done"
    outcome = str(manifest["outcome"])
    is_open = manifest.get("kind") == "interrupted" or outcome.startswith("interrupted")
    return "unfinished" if is_open or outcome == RUNNING else "stopped"


#: Verdicts of a validation that nobody has to be warned of.
_FINE = ("kept", "nothing promised")
_BAD = ("broken", "diverged")
#: What an expectation can come to; ``ExpectationResult`` knows all but the last.
State = Literal["holds", "fails", "not reached", "not recorded"]


class ReportContent:
    """One run, from its result file alone.

    Args:
        validation: Plain data of ``tissuec validate``; None without one.
        libraries: Folders of files that results do not keep, such as meshes.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        *,
        validation: Mapping[str, Any] | None = None,
        recompiled: RecompiledScene | None = None,
        libraries: Sequence[Path] = (),
    ):
        self.trajectory = trajectory
        self.validation = validation
        self.manifest = trajectory.manifest
        self.recompiled = recompiled or recompile(trajectory, libraries)
        self.texts = Texts(
            self.recompiled.request.source.name,
            trajectory.text,
            self.manifest.get("sources", {}),
        )

    @property
    def title(self) -> str:
        """Return the name of the scene, without the folder that it lay in."""
        return file_name(self.texts.scene)

    @cached_property
    def facts(self) -> Mapping[str, Any]:
        """What ``tissuec info`` says."""
        return summary(self.trajectory)

    @cached_property
    def kind(self) -> Kind:
        """How the run ended."""
        return kind_of(self.manifest)

    @property
    def statistics(self) -> Mapping[str, Any] | None:
        """What the run cost; None of one that was killed."""
        return self.manifest.get("statistics")

    @property
    def notes(self) -> Sequence[str]:
        """What else is to be known of the run."""
        return self.manifest.get("notes", ())

    @property
    def promise(self) -> Promise:
        """Whether positions are as accurate as the tolerance requires."""
        return self.trajectory.promise

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """What makes numbers of the run doubtful."""
        return self.trajectory.doubts

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Everything that happened."""
        return self.trajectory.events

    @cached_property
    def prediction(self) -> Prediction | None:
        """What ``explain --plan`` says; None where the scene cannot be compiled again."""
        compiled = self.recompiled.compiled
        return None if compiled is None else predict(compiled)

    @cached_property
    def expectations(self) -> tuple[ExpectationResult, ...]:
        """All expectations, as far as they are known."""
        if known := self.trajectory.expectations:
            return known
        compiled = self.recompiled.compiled
        spans = () if compiled is None else [one.span for one in compiled.plan.expectations]
        counts = [self.manifest.get(f"{word}_expectations") for word in ("failed", "unreached")]
        state: State = "holds" if counts == [0, 0] else "not recorded"
        return tuple(
            ExpectationResult(span.one_line, span.place, state, None, "") for span in spans
        )

    def count(self, state: State) -> int:
        """Return how many expectations are in a state."""
        return sum(one.state == state for one in self.expectations)

    @cached_property
    def verdict(self) -> Headline:
        """What a reader sees first."""
        failed = self.count("fails")
        if self.kind == "stopped":
            return Headline("bad", "stopped", self._reasons)
        if failed:
            return Headline("bad", "expectations fail", self._reasons)
        if self.kind == "done" and self.count("not reached"):
            return Headline("bad", "ended too early for expectations", self._reasons)
        if self.validation is not None and self.validation["verdict"] in _BAD:
            heading, *_ = VERDICTS[self.validation["verdict"]]
            return Headline("bad", f"validated: {heading}", self._reasons)
        if self.kind == "unfinished":
            return Headline("open", "unfinished", self._reasons)
        word = "done, expectations hold" if self.count("holds") else "done"
        tone: Tone = "warned" if self._reasons else "good"
        return Headline(
            tone, f"{word}, with warnings" if self._reasons else word, self._reasons
        )

    @cached_property
    def _reasons(self) -> tuple[tuple[str, str], ...]:
        """The objections to a run, each with the section that explains it."""
        found: list[tuple[str, str]] = []
        if self.kind != "done":
            found.append((str(self.manifest["outcome"]), "run"))
        if failed := self.count("fails"):
            found.append((f"{counted(failed, 'expectation')} failed", "expectations"))
        if self.kind == "done" and (left := self.count("not reached")):
            found.append((f"{counted(left, 'expectation')} not reached", "expectations"))
        if self.validation is not None and self.validation["verdict"] not in _FINE:
            verdict, *_ = VERDICTS[self.validation["verdict"]]
            found.append((f"validation: {verdict}", "validation"))
        if self.promise.since is not None:
            found.append((f"accuracy in time: {self.promise}", "exactness"))
        if self.doubts:
            found.append((f"doubtful: {kinds(self.doubts)}", "run"))
        if self.notes:
            found.append((counted(len(self.notes), "note"), "run"))
        if self.recompiled.warnings:
            number = counted(len(self.recompiled.warnings), "warning")
            found.append((number, "warnings"))
        return tuple(found)


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
        yield f"accuracy in time: {content.promise.sentence}"


def _reached(content: ReportContent) -> Iterator[str]:
    duration = content.manifest.get("duration")
    if duration is None:
        return
    if content.kind == "done" and not any(event.kind == END for event in content.events):
        yield f"{show(duration, TIME)} simulated"
        return
    last = max([content.trajectory.last_time, *(event.time for event in content.events)])
    yield f"{show(last, TIME, digits=6)} of {show(duration, TIME)} simulated"


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
