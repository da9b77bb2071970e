"""Runs in words: clauses without full stops, the same in a terminal, on pages and in Python."""

import shlex
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from os import PathLike
from typing import TYPE_CHECKING, Any

from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, TIME, show
from tissuec.results.promise import Promise

if TYPE_CHECKING:
    from tissuec.model.network import Network
    from tissuec.results.recording import ExpectationResult


def span(first: float, last: float) -> str:
    """Return an interval of time [s]: ``0 s to 300 ms``."""
    return f"{show(first, TIME)} to {show(last, TIME)}"


def credits(manifest: Mapping[str, Any]) -> str:
    """Return who wrote a scene, where, and under which licence; empty if it does not say."""
    licence = manifest.get("licence")
    parts = (
        manifest.get("author"),
        manifest.get("laboratory"),
        f"licence: {licence}" if licence else "",
    )
    return " · ".join(filter(None, parts))


def size(count: int) -> str:
    """Return a number of bytes: ``1.2 MB``."""
    for factor, unit in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return counted(count, "byte")


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


def concerned(springs: Sequence[int], network: "Network") -> tuple[int, str]:
    """Return how many elements, edges of elements or springs an event concerned, and which.

    Args:
        springs: Of the event. Where there are marks of elements among them, all others are
            edges of these.
        network: The network.
    """
    marks = sum(spring >= network.first_mark for spring in springs)
    if marks:
        return marks, "element"
    of_elements = bool(springs) and all(map(network.is_edge, springs))
    return len(springs), "element edge" if of_elements else "spring"


def springs_of_events(
    events: Iterable[tuple[str, Sequence[int]]], network: "Network"
) -> list[str]:
    """Return how many springs or elements events concerned: ``rupture: 3 springs``.

    Args:
        events: Kinds with the springs.
        network: The network.
    """
    counts: Counter[tuple[str, str]] = Counter()
    for kind, springs in events:
        count, what = concerned(springs, network)
        counts[kind, what] += count
    return [
        f"{kind}: {counted(count, what)}" for (kind, what), count in counts.items() if count
    ]


def expectations(states: Sequence[str]) -> str:
    """Return how many expectations hold.

    Args:
        states: As in ``ExpectationResult``.
    """
    unreached = states.count("not reached")
    rest = f", {unreached} not reached" if unreached else ""
    return f"{states.count('holds')} of {len(states)} hold{rest}"


def failure(one: "ExpectationResult") -> tuple[str, str]:
    """Return the place and text of an expectation that fails, and what was measured when."""
    when = "" if one.time is None else f"at {show(one.time, TIME)}: "
    return f"{one.place}: {one.expect}", f"{when}{one.measured}"


def accuracy(promise: Promise) -> str:
    """Return how accurate positions are, in one line."""
    allowed = promise.tolerance
    scale = "the largest displacement"
    if promise.least is not None:
        scale = (
            f"{show(promise.least, LENGTH)}, a millionth of the size, as nothing moves further"
        )
    error = "" if promise.error is None else f"{promise.error:.1e} of {scale}"
    limit = f" (tolerance {allowed:g})" if isfinite(allowed) else ""
    if promise.state == "not checked":
        reason = f": {promise.reason}" if promise.reason else ""
        if error and not isfinite(allowed):
            return f"{error} apart from a run with half the step (no tolerance)"
        apart = f", {error} apart" if error else ""
        return f"not checked{reason}{apart}{limit}"
    by = f", checked by {promise.method}" if promise.differs else ""
    if promise.since is None:
        return f"{error}{limit}{by}"
    from_then = f"after {show(promise.since, TIME)}"
    if promise.state == "broken":
        what = f"{from_then} positions are less accurate than the tolerance {allowed:g}"
    else:
        what = f"{from_then} the accuracy of positions is unknown{limit}"
    apart = f"{_other(promise)} differs by {error}; " if error else ""
    return f"{what}: {apart}{promise.reason}"


def _other(promise: Promise) -> str:
    """Return which run a run was compared with."""
    return f"a run with {promise.method}" if promise.differs else "a run with finer steps"


def command(
    scene: str | PathLike[str],
    options: Iterable[tuple[str, str | PathLike[str] | None]],
    *,
    resume: bool = False,
    strict: bool = False,
    blocks: bool = False,
) -> str:
    """Return the command line of a run; options without a value are left out.

    Args:
        scene: The scene.
        options: Options with their values.
        resume: Whether ``--resume`` is given.
        strict: Whether ``--strict`` is given.
        blocks: Whether ``--blocks`` is given.
    """
    given = [str(word) for pair in options if pair[1] is not None for word in pair]
    head = ["tissuec", "run", str(scene), *(["--resume"] if resume else [])]
    flags = [
        name for name, is_given in (("--strict", strict), ("--blocks", blocks)) if is_given
    ]
    return shlex.join([*head, *given, *flags])


def set_options(
    overrides: Iterable[str], libraries: Iterable[str | PathLike[str]]
) -> list[tuple[str, str | PathLike[str] | None]]:
    """Return the settings of a scene, as options."""
    return [
        *(("--set", text) for text in overrides),
        *(("--library", place) for place in libraries),
    ]
