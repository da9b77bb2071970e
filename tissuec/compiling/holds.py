"""Who holds what along the script, as far as it is known before the run.

Conditions (``when``) are left out: they may or may not fire.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tissuec.core.errors import Diagnostic, Note
from tissuec.core.source import Span
from tissuec.core.units import TIME, show
from tissuec.network import Indices
from tissuec.plan import Event
from tissuec.verbs import Mover
from tissuec.verbs.grasp import Grasp
from tissuec.verbs.hold import Hold
from tissuec.verbs.move import Move
from tissuec.verbs.release import Release
from tissuec.verbs.turn import Turn

_NOTHING = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class Taken:
    """Nodes that a tool or set holds from some time on."""

    holder: str
    nodes: Indices
    time: float
    span: Span


@dataclass(frozen=True, slots=True)
class Driven:
    """Nodes that a mover drives for some time."""

    mover: str
    nodes: Indices
    start: float
    stop: float
    span: Span


def check_holds(events: Sequence[Event], *, certain: bool) -> Iterator[Diagnostic]:
    """Yield releases of what nothing holds (TIS401) and conflicting motions (TIS402).

    Args:
        events: In the order in which they happen.
        certain: False if conditions may add grasps, so that a missing one is no mistake.
    """
    taken: list[Taken] = []
    driven: list[Driven] = []
    for event in events:
        match event.action:
            case Grasp(group=group, tool=tool, span=span):
                taken.append(Taken(tool, group.indices, event.time, span))
            case Hold(group=group, span=span):
                taken.append(Taken(group.name, group.indices, event.time, span))
            case (
                Move(mover=mover, duration=duration, span=span)
                | Turn(mover=mover, duration=duration, span=span)
            ):
                nodes = _moved(mover, taken)
                taken.append(Taken(mover.name, nodes, event.time, span))
                stop = event.time + (duration if duration is not None else np.inf)
                new = Driven(mover.name, nodes, event.time, stop, span)
                yield from _conflicts(new, driven)
                driven.append(new)
            case Release() as release if certain:
                yield from _unheld(release, event.time, taken)
            case _:
                pass


def _moved(mover: Mover, taken: Sequence[Taken]) -> Indices:
    if mover.nodes is not None:
        return mover.nodes
    return np.unique(
        np.concatenate([_NOTHING, *(t.nodes for t in taken if t.holder == mover.name)])
    )


def _conflicts(new: Driven, driven: Sequence[Driven]) -> Iterator[Diagnostic]:
    for old in driven:
        overlaps = new.start < old.stop * (1 - 1e-12) and old.mover != new.mover
        common = np.intersect1d(old.nodes, new.nodes) if overlaps else _NOTHING
        if len(common):
            yield Diagnostic(
                "TIS402",
                f"{new.mover} and {old.mover} would move {len(common)} nodes along two paths at {show(new.start, TIME)}",
                new.span,
                "let one motion end before the other begins, or make the sets differ",
                (Note("the other motion", old.span),),
            )


def _unheld(release: Release, time: float, taken: Sequence[Taken]) -> Iterator[Diagnostic]:
    who = release.tool
    mine = [t for t in taken if who is None or t.holder == who]
    if release.group is not None:
        mine = [t for t in mine if len(np.intersect1d(t.nodes, release.group.indices))]
    if mine:
        return
    what = release.group.name if release.group is not None else "anything"
    subject = f"{who} cannot release {what}" if who else f"{what} cannot be released"
    reason = "it grasped nothing before" if who else "nothing held it before"
    places = ", ".join(f"by {t.holder} since {show(t.time, TIME)}" for t in taken)
    yield Diagnostic(
        "TIS401", f"{subject} at {show(time, TIME)}: {reason}", release.span,
        f"held are others: {places}" if places else "grasp or hold it first",
    )  # fmt: skip
