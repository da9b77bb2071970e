"""How a run went, in sentences without their stops."""

import shlex
from collections.abc import Iterable, Sequence
from math import isfinite
from os import PathLike

from tissuec.core.errors import counted
from tissuec.core.units import TIME, show

CHAOS = "take a finer tolerance; where that does not help the motion is chaotic"


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


def stepping(methods: str, steps: int, tier: str, wall_time: float) -> str:
    """Return how a run was stepped and how long that took."""
    return f"{methods}, {counted(steps, 'step')} ({tier}), {wall_time:.2f} s"


def expectations(total: int, failed: int, unreached: int) -> str:
    """Return how many expectations hold."""
    rest = f", {unreached} not reached" if unreached else ""
    return f"{total - failed - unreached} of {total} hold{rest}"


def error(worst: float, allowed: float, until: float | None) -> str:
    """Return how far a run is from its twin.

    Args:
        worst: Relative to the largest displacement.
        allowed: What the tolerance allows; infinite where it promises nothing.
        until: When the twin was left [s]; None if it came to the end.
    """
    short = "" if until is None else f" until {show(until, TIME)}"
    promise = f" (tolerance {allowed:g})" if isfinite(allowed) else ""
    return f"about {worst:.1e} of the largest displacement{short}{promise}"


def parting(worst: float, allowed: float, time: float) -> tuple[str, str, str]:
    """Return what there is to say of a run that its twin has left: what, how far, remedy."""
    return (
        f"from {show(time, TIME)} on positions are not known within the tolerance {allowed:g}",
        f"a run stepped more finely is {worst:.1e} of the largest displacement away",
        CHAOS,
    )


def command(
    scene: str | PathLike[str],
    options: Iterable[tuple[str, str | PathLike[str] | None]],
    *,
    resume: bool = False,
    strict: bool = False,
) -> str:
    """Return the command line of a run; options without a value are left out."""
    given = [str(word) for pair in options if pair[1] is not None for word in pair]
    head = ["tissuec", "run", str(scene), *(["--resume"] if resume else [])]
    return shlex.join([*head, *given, *(["--strict"] if strict else [])])


def set_options(
    overrides: Iterable[str], libraries: Iterable[str | PathLike[str]]
) -> list[tuple[str, str | PathLike[str] | None]]:
    """Return what a scene was compiled with, as options."""
    return [
        *(("--set", text) for text in overrides),
        *(("--library", place) for place in libraries),
    ]
