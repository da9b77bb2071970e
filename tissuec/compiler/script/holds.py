"""Which nodes are held when, as far as the script determines it before the run.

Conditions (``when``) are left out: they may or may not fire.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
from msgspec import Struct

from tissuec.core.arrays import distinct
from tissuec.core.errors import Diagnostic, Note, counted
from tissuec.core.hints import proposal
from tissuec.core.source import Span
from tissuec.core.units import TIME, show
from tissuec.mechanics.guiding import overlap
from tissuec.model.network import Floats, Indices, ToolPart, numbers_in
from tissuec.script.plan import ScheduledAction, Trigger
from tissuec.script.verbs import Mover, follows
from tissuec.script.verbs.holding import (
    Driven,
    Fixed,
    Freed,
    HoldChange,
    Holding,
    JawsMoved,
    Released,
    Stopped,
    Taken,
)

_NOTHING = np.zeros(0, dtype=np.int64)


class HeldNodes(Struct, frozen=True):
    """Nodes that a tool or set holds from some time on."""

    holder: str
    nodes: Indices
    time: float
    span: Span


class DrivenNodes(Struct, frozen=True):
    """Nodes that a mover drives for some time."""

    mover: str
    nodes: Indices
    start: float
    stop: float
    span: Span
    directions: Floats | None = None


class DirectedNodes(Struct, frozen=True, eq=False):
    """Nodes that are held in some directions from some time on."""

    nodes: Indices
    directions: Floats
    span: Span


def check_holds(
    events: Sequence[ScheduledAction],
    triggers: Sequence[Trigger],
    tools: Sequence[ToolPart],
    *,
    shaped: bool,
) -> Iterator[Diagnostic]:
    """Yield releases of what nothing holds, conflicting motions, motions of what is fixed, and
    tools that move nothing.

    Args:
        events: In the order in which they happen.
        tools: Those that have a shape, and so move something always.
        triggers: What conditions may add: a grasp, so that a missing one is no mistake, or
            that fixed nodes are free.
        shaped: False if tools that are wrong may have shapes, and so move something.
    """
    story = _HoldHistory(tools, triggers, shaped)
    said: set[tuple[str, Span | None]] = set()  # a repeated sentence is reported once
    for event in events:
        for finding in story.tell(event):
            if (finding.code, finding.span) not in said:
                said.add((finding.code, finding.span))
                yield finding


class _HoldHistory:
    """What is held and driven up to some event; a repeated sentence takes no more room."""

    def __init__(self, tools: Sequence[ToolPart], triggers: Sequence[Trigger], shaped: bool):
        self.certain = shaped and not triggers
        followed = (change_of(event) for trigger in triggers for event in trigger.events)
        self.may_free = any(isinstance(change, Freed) for change in followed)
        self.shapes: dict[str, Indices] = {tool.name: numbers_in(tool.nodes) for tool in tools}
        self.taken: dict[tuple[str, Span], HeldNodes] = {}
        self.driven: dict[tuple[str, Span], DrivenNodes] = {}
        self.fixed: dict[Span, Indices] = {}
        self.directed: list[DirectedNodes] = []

    def tell(self, event: ScheduledAction) -> Iterator[Diagnostic]:
        """Enter an event, and yield its errors."""
        time, span = event.time, event.action.span
        match change_of(event):
            case Fixed(nodes=nodes, directions=None):
                self.fixed[span] = nodes
            case Fixed(nodes=nodes, directions=directions):
                yield from self._guide(nodes, directions, span)
            case Taken(holder=holder, nodes=nodes, directions=directions):
                self._take(holder, nodes, time, span)
                yield from self._guide(nodes, directions, span)
            case Driven(mover=mover, duration=duration, directions=directions):
                nodes = self._moved(mover)
                yield from self._guide(nodes, directions, span)
                if self.certain and mover.nodes is None and not len(nodes):
                    yield _idle(mover, time, span)
                self._take(mover.name, nodes, time, span)
                lasting = np.inf if duration is None else duration
                new = DrivenNodes(mover.name, nodes, time, time + lasting, span, directions)
                yield from _conflicts(new, tuple(self.driven.values()))
                self.driven[mover.name, span] = new
                if not self.may_free:
                    yield from self._fixed(new)
            case JawsMoved(tool=tool):
                yield from self._moved_meanwhile(tool, time, span)
            case Stopped(mover=name):
                self._end(lambda old: old.mover == name)
            case Released(group=group, tool=tool) as release:
                if self.certain:
                    yield from _unheld(
                        release, event, tuple(self.taken.values()), self.fixed.values()
                    )
                self._release(release)
                if group is None:
                    self._end(lambda old: old.mover == tool)
                else:
                    self._let_go(group.indices)
            case Freed(nodes=nodes):
                self._let_go(nodes)
                self.directed = [
                    DirectedNodes(np.setdiff1d(one.nodes, nodes), one.directions, one.span)
                    for one in self.directed
                ]
                self.fixed = {
                    span: np.setdiff1d(fixed, nodes) for span, fixed in self.fixed.items()
                }
            case None:
                pass

    def _guide(
        self, nodes: Indices, directions: Floats | None, span: Span
    ) -> Iterator[Diagnostic]:
        """Enter a hold in some directions; yield an error if these depend on earlier ones."""
        if directions is None:
            return
        beside = [
            one
            for one in self.directed
            if one.span != span and not overlap(one.directions, directions)
        ]
        shared = np.array([np.isin(nodes, one.nodes) for one in beside]).reshape(-1, len(nodes))
        for kind in np.unique(shared, axis=1).T:
            own = [one for one, has in zip(beside, kind, strict=True) if has]
            if len(own) > 1 and overlap(
                np.concatenate([one.directions for one in own]), directions
            ):
                yield Diagnostic(
                    "TIS402",
                    "the directions in which these nodes are held depend on one another",
                    span,
                    "leave one of them out, or make the directions perpendicular",
                    tuple(Note("another direction", one.span) for one in own),
                )
                return
        self.directed.append(DirectedNodes(nodes, directions, span))

    def _take(self, holder: str, nodes: Indices, time: float, span: Span) -> None:
        former = self.taken.get((holder, span))
        since = time if former is None else former.time
        self.taken[holder, span] = HeldNodes(holder, nodes, since, span)

    def _release(self, release: Released) -> None:
        """Forget nodes that are no longer held, so that they cannot be released again."""
        for key, held in tuple(self.taken.items()):
            if release.tool in (None, held.holder):
                gone = held.nodes if release.group is None else release.group.indices
                left = np.setdiff1d(held.nodes, gone, assume_unique=True)
                if len(left):
                    self.taken[key] = HeldNodes(held.holder, left, held.time, held.span)
                else:
                    del self.taken[key]

    def _moved(self, mover: Mover) -> Indices:
        if mover.nodes is not None:
            return mover.nodes
        shape = self.shapes.get(mover.name, _NOTHING)
        taken = (t.nodes for t in self.taken.values() if t.holder == mover.name)
        return distinct(np.concatenate([shape, *taken]))

    def _fixed(self, new: DrivenNodes) -> Iterator[Diagnostic]:
        """Yield a warning if nodes are moved that a sentence fixes: the later order wins."""
        for span, nodes in self.fixed.items():
            common = int(np.isin(nodes, new.nodes).sum())
            if common and new.directions is None:
                yield Diagnostic(
                    "W409",
                    f"{new.mover} moves {counted(common, 'fixed node')} from "
                    f"{show(new.start, TIME)} "
                    f"on: the motion overrides fix",
                    new.span,
                    "free them first, or exclude them from what is fixed or moved",
                    (Note("fixed here", span),),
                )

    def _moved_meanwhile(self, tool: str, time: float, span: Span) -> Iterator[Diagnostic]:
        """Yield an error if jaws open or close while the forceps move."""
        for old in self.driven.values():
            if old.mover == tool and time < old.stop * (1 - 1e-12):
                yield Diagnostic(
                    "TIS402",
                    f"{tool} cannot open or close while it is moved, at {show(time, TIME)}",
                    span,
                    "let one motion end before the other begins",
                    (Note("the other motion", old.span),),
                )

    def _end(self, is_over: Callable[[DrivenNodes], bool]) -> None:
        self.driven = {key: old for key, old in self.driven.items() if not is_over(old)}

    def _let_go(self, nodes: Indices) -> None:
        self._end(lambda old: bool(np.isin(old.nodes, nodes).all()))


def change_of(event: ScheduledAction) -> HoldChange | None:
    """Return the change that an event makes to held or driven nodes, if any."""
    return event.action.holding() if follows(event.action, Holding) else None


def _idle(mover: Mover, time: float, span: Span) -> Diagnostic:
    message = f"{mover.name} holds nothing when it starts to move, at {show(time, TIME)}"
    return Diagnostic(
        "W401", message, span, f"write before the motion: grasp … with {mover.name}"
    )


def _conflicts(new: DrivenNodes, driven: Sequence[DrivenNodes]) -> Iterator[Diagnostic]:
    for old in driven:
        overlaps = new.start < old.stop * (1 - 1e-12) and old.mover != new.mover
        overlaps = overlaps and overlap(old.directions, new.directions)
        common = np.intersect1d(old.nodes, new.nodes) if overlaps else _NOTHING
        if len(common):
            yield Diagnostic(
                "TIS402",
                f"{new.mover} and {old.mover} would move {counted(len(common), 'node')} "
                f"along two paths at {show(new.start, TIME)}",
                new.span,
                "let one motion end before the other begins, or make the sets differ",
                (Note("the other motion", old.span),),
            )


def _unheld(
    release: Released,
    event: ScheduledAction,
    taken: Sequence[HeldNodes],
    fixed: Iterable[Indices],
) -> Iterator[Diagnostic]:
    who = release.tool
    mine = [t for t in taken if who is None or t.holder == who]
    if release.group is not None:
        mine = [t for t in mine if np.isin(t.nodes, release.group.indices).any()]
    if mine:
        return
    what = release.group.name if release.group is not None else "anything"
    subject = f"{who} cannot release {what}" if who else f"{what} cannot be released"
    reason = "nothing holds it"
    if who:
        holds_some = any(t.holder == who for t in taken)
        reason = f"it does not hold {what}" if holds_some else "it has not grasped anything"
    group = release.group
    if (
        who is None
        and group is not None
        and any(np.isin(group.indices, n).any() for n in fixed)
    ):
        yield Diagnostic(
            "TIS401", f"{subject} at {show(event.time, TIME)}: it is fixed, and not held",
            event.action.span, proposal(f"free {group.name}"),
        )  # fmt: skip
        return
    # One hold of each holder: what it moves on the way is no hold of its own.
    since = {t.holder: t.time for t in reversed(taken)}
    places = ", ".join(
        f"by {holder} since {show(time, TIME)}" for holder, time in since.items()
    )
    yield Diagnostic(
        "TIS401", f"{subject} at {show(event.time, TIME)}: {reason}",
        event.action.span,
        f"other holds: {places}" if places else "grasp or hold it first",
    )  # fmt: skip
