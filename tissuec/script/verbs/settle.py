"""``settle``: nodes that go to their equilibrium at once, or for an interval."""

from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import SET, Lasting, SubjectPart
from tissuec.script.verbs import (
    VERBS,
    Action,
    ActionFailed,
    EventQueue,
    Group,
    LoggedEvent,
    Order,
)
from tissuec.script.verbs.holding import sentence


@VERBS.member("settle")
class Settle(VerbSentence, frozen=True):
    """Moves nodes, of a set or of everything, to static equilibrium, where all forces balance.

    The forces are those of this moment: springs, weight, pressure, tools and pushes. Dashpots
    and friction do not act. Held and moved nodes keep their positions, as do all nodes outside
    the named set. No time passes, and nothing breaks before equilibrium is reached; springs
    that are then under too much tension break immediately afterwards. Relaxing branches carry
    no force afterwards. Plastic deformation is kept; springs above their yield force and
    elements above their yield stress continue to flow. A free body keeps its centre of mass,
    and its orientation unless loads turn it. If gravity acts on a free body, there is no
    equilibrium and the run ends with an error. The event log notes where the net buckled, and
    where it can move without any force.

    Over an interval, everything stays in equilibrium while holders and loads change: inertia,
    dashpots and friction do not act, as with the method ``equilibrium``. Afterwards, motion
    starts from rest in the last equilibrium.
    """

    meant: ClassVar[str] = "relax equilibrate"

    group: Annotated[Group | None, SubjectPart("nodes", (SET,))]  # None for all nodes
    duration: Lasting

    def action(self, order: Order) -> Action:
        if self.duration is None:
            return self
        if self.group is not None:
            order.reject(
                "TIS403",
                "a part of the scene cannot settle over an interval",
                hint="write settle alone, which is everything, or: at T: settle SET",
            )
        return StaticInterval(self.duration, self.span)

    def chosen(self, state: State) -> np.ndarray:
        """Return which nodes may move unless they are held, without a unit, shape (node,)."""
        count = state.network.node_count
        if self.group is None:
            return np.ones(count, dtype=bool)
        return np.isin(np.arange(count), self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Move the nodes to equilibrium.

        Raises:
            ActionFailed: There is no equilibrium, or none was found.
        """
        from tissuec.mechanics.settling import (
            Unsettled,
            settle,
        )  # SciPy: only where it is needed

        text = sentence(self.span)
        state.place_held()
        try:
            remarks = settle(state, self.chosen(state))
        except Unsettled as failure:
            raise ActionFailed(
                f"{text}: {failure.message}", failure.node, self.span
            ) from failure
        ids = state.network.node_ids
        above = ("" if r.node is None else f", above all node {ids[r.node]}" for r in remarks)
        notes = tuple(
            LoggedEvent("note", (), f"{text}: {r.message}{r.numbers}{node}", self.span)
            for r, node in zip(remarks, above, strict=True)
        )
        return (LoggedEvent("settle", (), text, self.span), *notes)


class EndStaticInterval(Struct, frozen=True):
    """The end of the interval; the scene moves again from its last equilibrium."""

    stop: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if state.still_until != self.stop:
            return ()  # another interval lasts longer
        state.still_until = -np.inf
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


class StaticInterval(Struct, frozen=True):
    """The start of an interval in which the engine goes from one equilibrium to the next."""

    duration: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Begin the interval.

        Raises:
            ActionFailed: The net relaxes or yields, which takes time.
        """
        text = sentence(self.span)
        if state.network.relaxes:
            message = f"{text}: what relaxes or yields cannot settle over an interval"
            raise ActionFailed(message, None, self.span)
        state.velocity[state.free] = 0.0
        stop = state.time + self.duration
        state.still_until = max(state.still_until, stop)
        queue.add(stop, EndStaticInterval(stop, self.span))
        return (LoggedEvent("settle", (), text, self.span),)
