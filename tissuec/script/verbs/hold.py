"""``fix``, ``hold``, ``grasp``, ``release`` and ``free``: nodes that stay where they are."""

from typing import Annotated, ClassVar

from msgspec import Struct

from tissuec.core.arrays import Floats
from tissuec.core.source import Span
from tissuec.mechanics.guiding import DirectedHold
from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Across, Along, Lasting, Moved, Nodes, ToolClause
from tissuec.script.verbs import VERBS, Action, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import (
    FIX,
    Fixed,
    Freed,
    Released,
    Taken,
    gripped,
    guide,
    held_by,
    held_in,
    let_go,
    refuse_both,
    sentence,
    take,
    unguide,
)
from tissuec.script.verbs.motion import joined


class EndHold(Struct, frozen=True):
    """The end of a hold for an interval, unless the set was held again in the meantime."""

    holder: str  # or the key of a hold in some directions
    time: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if state.hold_ends.get(self.holder) != self.time:
            return ()
        if (hold := state.directed.get(self.holder)) is not None:
            unguide(state, hold)
        else:
            nodes = held_by(state, self.holder)
            let_go(state, nodes, lambda holder: holder == self.holder)
        # Kept, so that a release at the same time is known to have been obeyed already.
        state.hold_ends[self.holder] = self.time
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("hold")
class Hold(VerbSentence, frozen=True):
    """Holds nodes where they are, for the interval or until ``release`` or ``free``.

    It ends motions of these nodes. A later ``hold`` or ``move`` of the same set replaces it.
    With ``along`` or ``across``, nodes are held in some directions only, as with ``fix``.
    """

    group: Nodes
    along: Along
    across: Across
    duration: Lasting

    def action(self, order: Order) -> Action:
        refuse_both(self.along, self.across, order)
        return self

    @property
    def directions(self) -> Floats | None:
        """Return those in which nodes are held, as unit vectors of shape (direction, 3).

        None for all.
        """
        return held_in(self.along, self.across)

    def holding(self) -> Taken:
        return Taken(self.group.name, self.group.indices, self.directions)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        name, nodes = self.group.name, self.group.indices
        if (directions := self.directions) is not None:
            hold = DirectedHold(name, nodes, directions, self.span)
            guide(state, hold)
            name = hold.key
        else:
            take(state, name, nodes)
        state.hold_ends.pop(name, None)
        if self.duration is not None:
            end = state.time + self.duration
            state.hold_ends[name] = end
            queue.add(end, EndHold(name, end, self.span))
        return (LoggedEvent("hold", (), sentence(self.span), self.span),)


@VERBS.member("fix")
class Fix(VerbSentence, frozen=True):
    """Holds nodes in place from this time on; only ``free`` ends this.

    Moving nodes stop where they are. ``along`` holds them in one direction only, like rollers
    on a plane at right angles to it; ``across`` holds them in the two directions at right
    angles to one, so that they can slide along it. Several such sentences add up.
    """

    meant: ClassVar[str] = "pin anchor constrain immobilise immobilize clip"

    group: Nodes
    along: Along
    across: Across

    def action(self, order: Order) -> Action:
        refuse_both(self.along, self.across, order)
        return self

    @property
    def directions(self) -> Floats | None:
        """Return those in which nodes are held, as unit vectors of shape (direction, 3).

        None for all.
        """
        return held_in(self.along, self.across)

    def holding(self) -> Fixed:
        return Fixed(self.group.indices, self.directions)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if (directions := self.directions) is not None:
            guide(state, DirectedHold(FIX, self.group.indices, directions, self.span))
        else:
            take(state, FIX, self.group.indices)
        return (LoggedEvent("fix", (), sentence(self.span), self.span),)


@VERBS.member("free")
class Free(VerbSentence, frozen=True):
    """Ends every hold on nodes, whether they are fixed, held, grasped or moved.

    Nodes that were moved along a path continue with the velocity of the path.
    """

    meant: ClassVar[str] = "unfix detach unpin"

    group: Nodes

    def holding(self) -> Freed:
        return Freed(self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        text = sentence(self.span)
        if not len(let_go(state, self.group.indices, lambda holder: True)):
            return (LoggedEvent("note", (), f"{text}: not held", self.span),)
        return (LoggedEvent("free", (), text, self.span),)


@VERBS.member("release")
class Release(VerbSentence, frozen=True):
    """Releases the nodes of a set, or all nodes that a tool holds.

    ``release SET from TOOL`` releases the set from this tool only, ``release SET`` from
    everything that holds it. Released nodes keep their velocity: a node at rest starts from
    rest, and a node on a path continues with the velocity of the path. Fixed nodes stay fixed
    (``free`` releases them). Releasing nodes that nothing holds is an error.
    """

    meant: ClassVar[str] = "drop ungrasp unclamp"

    released: Moved  # of a tool: all that it holds
    holder: Annotated[
        str | None, ToolClause("from", "grasping", what="tool")
    ]  # None: whatever holds it

    def action(self, order: Order) -> Action:
        if self.group is None and self.holder is not None:
            order.reject(
                "TIS306",
                f'"{self.released.name}" is a tool and cannot be released from one',
                hint="write: release SET from TOOL, or: release TOOL",
                word="from",
            )
        return self

    @property
    def group(self) -> Group | None:
        """The released nodes; None for all that the tool holds."""
        name, nodes = self.released.name, self.released.nodes
        return None if nodes is None else Group(name, nodes)

    @property
    def tool(self) -> str | None:
        """The tool that releases them; None for everything that holds them."""
        return self.released.name if self.released.nodes is None else self.holder

    def holding(self) -> Released:
        return Released(self.group, self.tool)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        group = self.group
        nodes = gripped(state, self.released.name) if group is None else group.indices
        text = sentence(self.span)
        if not len(let_go(state, nodes, self._concerns)):
            if group is not None and state.hold_ends.get(group.name) == state.time:
                return ()
            return (LoggedEvent("note", (), f"{text}: no longer held", self.span),)
        return (LoggedEvent("release", (), text, self.span),)

    def _concerns(self, holder: str) -> bool:
        return holder != FIX if self.tool is None else holder == self.tool


@VERBS.member("grasp")
class Grasp(VerbSentence, frozen=True):
    """Takes nodes into the rigid grip of a tool, in addition to those that it already holds.

    The tool must be forceps, a clamp or a needle. Moving nodes stop; if the tool is moving,
    they move with it from now on.
    """

    meant: ClassVar[str] = "clamp grip grab pinch take seize pick catch"

    group: Nodes
    tool: Annotated[str, ToolClause("with", "grasping", what="tool")]

    def holding(self) -> Taken:
        return Taken(self.tool, self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        motion = state.motions.get(self.tool)
        take(state, self.tool, self.group.indices)
        if motion is not None:
            state.motions[self.tool] = joined(motion, state, self.group.indices)
            state.place_held()
        return (LoggedEvent("grasp", (), sentence(self.span), self.span),)
