"""Outcome of a run, in sentences without full stops."""

import shlex
from collections.abc import Iterable, Sequence
from math import isfinite
from os import PathLike
from typing import Protocol

from tissuec.core.errors import counted
from tissuec.core.units import TIME, show


def methods(changes: Sequence[tuple[float, str]]) -> str:
    """Return the methods in turn, such as "dop853, esdirk43 from 2.14 ms on".

    Args:
        changes: When each took over [s], and its name.
    """
    (_, first), *others = changes
    return first + "".join(f", {method} from {show(time, TIME)} on" for time, method in others)


def net(nodes: int, springs: int) -> str:
    """Return the size of a net."""
    return f"{counted(nodes, 'node')}, {counted(springs, 'spring')}"


def stepping(methods: str, steps: int, backend: str, threads: int, wall_time: float) -> str:
    """Return how a run was stepped and how long that took.

    Args:
        methods: Names of the integrators.
        steps: Number of steps.
        backend: How steps were computed.
        threads: Number of threads.
        wall_time: Time of the run [s].
    """
    code = backend if threads == 1 else f"{backend}, {threads} threads"
    return f"{methods}, {counted(steps, 'step')} ({code}), {wall_time:.2f} s"


def expectations(total: int, failed: int, unreached: int) -> str:
    """Return how many expectations hold.

    Args:
        total: Number of expectations.
        failed: How many do not hold.
        unreached: How many were not evaluated.
    """
    rest = f", {unreached} not reached" if unreached else ""
    return f"{total - failed - unreached} of {total} hold{rest}"


class AccuracyStatement(Protocol):
    """Accuracy of a run."""

    @property
    def state(self) -> str: ...
    @property
    def since(self) -> float | None: ...
    @property
    def error(self) -> float | None: ...
    @property
    def reason(self) -> str: ...


def accuracy(promise: AccuracyStatement, allowed: float) -> str:
    """Return how accurate positions are, in one line.

    Args:
        allowed: By the tolerance, relative to the largest displacement; infinite where nothing
            is promised.
    """
    error = "" if promise.error is None else f"{promise.error:.1e} of the largest displacement"
    limit = f" (tolerance {allowed:g})" if isfinite(allowed) else ""
    if promise.state == "not checked":
        known = (
            f"{error} (fixed steps: no tolerance)"
            if error
            else f"not checked: {promise.reason}"
        )
        return known
    if promise.since is None:
        return f"{error}{limit}"
    from_then = f"after {show(promise.since, TIME)}"
    if promise.state == "broken":
        what = f"{from_then} positions are less accurate than the tolerance {allowed:g}"
    else:
        what = f"{from_then} the accuracy of positions is unknown (tolerance {allowed:g})"
    apart = f"a run with finer steps differs by {error}; " if error else ""
    return f"{what}: {apart}{promise.reason}"


def command(
    scene: str | PathLike[str],
    options: Iterable[tuple[str, str | PathLike[str] | None]],
    *,
    resume: bool = False,
    strict: bool = False,
) -> str:
    """Return the command line of a run; options without a value are left out.

    Args:
        scene: The scene.
        options: Options with their values.
        resume: Whether ``--resume`` is given.
        strict: Whether ``--strict`` is given.
    """
    given = [str(word) for pair in options if pair[1] is not None for word in pair]
    head = ["tissuec", "run", str(scene), *(["--resume"] if resume else [])]
    return shlex.join([*head, *given, *(["--strict"] if strict else [])])


def set_options(
    overrides: Iterable[str], libraries: Iterable[str | PathLike[str]]
) -> list[tuple[str, str | PathLike[str] | None]]:
    """Return the settings of a scene, as options."""
    return [
        *(("--set", text) for text in overrides),
        *(("--library", place) for place in libraries),
    ]
