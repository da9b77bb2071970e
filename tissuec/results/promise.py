"""How far the numbers of a run can be trusted: its steps, accuracy and doubts."""

from collections.abc import Iterable, Mapping
from math import inf, isfinite
from typing import Any, Self

from msgspec import Struct, convert

from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, TIME, show


class LogError(Struct, frozen=True):
    """Estimated error of a log, which the tolerance does not bound.

    Attributes:
        error: Largest error of a number of the log, relative to ``largest``.
        apart: The same in the unit of the log.
        largest: Size of the largest number of the log.
        unit: SI unit of the log; "" for plain numbers.
    """

    error: float
    apart: float
    largest: float
    unit: str


class Promise(Struct, frozen=True):
    """Whether positions are as accurate as the tolerance asks for.

    Attributes:
        state: "kept", "broken", "unknown" or "not checked".
        since: From when on it is broken or unknown [s]; None otherwise.
        error: Estimated error, relative to the largest displacement; None if not estimated.
        tolerance: What was promised; infinite where nothing was.
        reason: Why it is unknown or was not checked; what helps if it is broken.
        seconds: Wall time that the check took after the run [s].
        method: Of the companion run that checked it; "" without one.
        differs: Whether that is of another kind than all methods of the run.
        steps: How many times shorter the steps of the companion run are, where those of the run
            are fixed; below 1, they are longer.
        least: What the error is relative to [m] if the net moves less than a millionth of its
            size; None otherwise.
        logs: Errors of logs, by name, as far as they are known. No tolerance bounds them.
    """

    state: str
    since: float | None = None
    error: float | None = None
    tolerance: float = inf
    reason: str = ""
    seconds: float = 0.0
    method: str = ""
    differs: bool = False
    steps: float = 2.0
    least: float | None = None
    logs: Mapping[str, LogError] = {}

    @classmethod
    def of(cls, manifest: Mapping[str, Any]) -> Self:
        """Return the accuracy in the manifest of a result."""
        if (written := manifest.get("promise")) is not None:
            tolerance = inf if written["tolerance"] is None else float(written["tolerance"])
            logs = convert(written.get("logs", {}), dict[str, LogError])
            entries: dict[str, Any] = {**written, "tolerance": tolerance, "logs": logs}
            return cls(**entries)
        return cls("not checked")

    def __str__(self) -> str:
        return self.state if self.since is None else f"{self.state} from {self.since:g} s"

    @property
    def sentence(self) -> str:
        """Return how accurate positions are, in one line."""
        allowed = self.tolerance
        scale = "the largest displacement"
        if self.least is not None:
            scale = (
                f"{show(self.least, LENGTH)}, a millionth of the size, as nothing moves further"
            )
        error = "" if self.error is None else f"{self.error:.1e} of {scale}"
        limit = f" (tolerance {allowed:g})" if isfinite(allowed) else ""
        if self.state == "not checked":
            reason = f": {self.reason}" if self.reason else ""
            if error and not isfinite(allowed):
                step = (
                    "half the step"
                    if self.steps > 1.0
                    else f"{1.0 / self.steps:g} times the step"
                )
                if not self.error:
                    return f"equal to a run with {step} (no tolerance)"
                return f"differs by {error} from a run with {step} (no tolerance)"
            apart = f", differs by {error}" if error else ""
            return f"not checked{reason}{apart}{limit}"
        by = f", checked by {self.method}" if self.differs else ""
        if self.since is None:
            return f"{error}{limit}{by}"
        from_then = f"after {show(self.since, TIME)}"
        if self.state == "broken":
            what = f"{from_then} positions are less accurate than the tolerance {allowed:g}"
        else:
            what = f"{from_then} the accuracy of positions is unknown{limit}"
        apart = f"{self._other} differs by {error}; " if error else ""
        return f"{what}: {apart}{self.reason}"

    @property
    def sentence_on_logs(self) -> str:
        """Return how accurate logs are, in one line; empty if that is not known."""
        if not self.logs:
            return ""
        name, worst = max(self.logs.items(), key=lambda one: one[1].error)
        error = f"{worst.error:.1e} of the largest value"
        return f"{error} of {name}" if len(self.logs) == 1 else f"up to {error} ({name})"

    @property
    def _other(self) -> str:
        """Return which run the run was compared with."""
        return f"a run with {self.method}" if self.differs else "a run with finer steps"


def methods(statistics: Mapping[str, Any]) -> str:
    """Return the methods in turn, such as "dop853, esdirk43 from 2.14 ms on"."""
    first, *others = statistics["changes"] or [statistics]
    later = (f", {one['method']} from {show(one['time'], TIME)} on" for one in others)
    return first["method"] + "".join(later)


def stepping(manifest: Mapping[str, Any]) -> str:
    """Return how a run was stepped and how long that took; the method if no more is known."""
    statistics = manifest.get("statistics")
    if not statistics:
        return str(manifest.get("method") or manifest.get("integrator") or "")
    code, threads = statistics["backend"], statistics.get("threads", 1)
    code = code if threads == 1 else f"{code}, {threads} threads"
    steps = counted(statistics["accepted"], "step")
    return f"{methods(statistics)}, {steps} ({code}), {manifest['wall_time']:.2f} s"


class Doubt(Struct, frozen=True):
    """A finding that makes numbers of a run doubtful from some time on.

    Attributes:
        kind: A few words that are the same in all runs, such as "inside out".
        subject: What it concerns, such as "block" or "needle in block".
        what: A clause with what is wrong, such as "cells of block are inside out".
        time: When it was seen first [s]; of contacts, when the force was largest.
        where: Place where it was seen first, such as "at node 63 of block".
        most: How many there were at most.
        last: How many there were when the run was looked at last.
        unit: Noun for one of them, such as "cell".
        remedy: How to avoid it.
        place: ``file:line`` of the sentence that is concerned.
    """

    kind: str
    subject: str
    what: str
    time: float
    where: str
    most: int
    last: int
    unit: str
    remedy: str
    place: str

    def __str__(self) -> str:
        most = counted(self.most, self.unit)
        number = most if self.most == self.last else f"up to {most}, {self.last} at the end"
        seen = f"first at {show(self.time, TIME)} {self.where}".rstrip()
        return f"{self.what} ({number}, {seen}): {self.remedy} ({self.place})"


def doubts_of(manifest: Mapping[str, Any]) -> tuple[Doubt, ...]:
    """Return the doubts in the manifest of a result; none of results without the entry."""
    return tuple(convert(written, Doubt) for written in manifest.get("doubts", ()))


def kinds(doubts: Iterable[Doubt]) -> str:
    """Return the kinds of doubts, each once: "inside out, tool in tissue"."""
    return ", ".join(dict.fromkeys(doubt.kind for doubt in doubts))
