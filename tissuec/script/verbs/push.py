"""``push`` and ``pull``: external forces on nodes."""

from math import inf
from typing import Annotated, ClassVar

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import FORCE, PRESSURE
from tissuec.forces.acting.load import Load, LoadTerm
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import STEADY, DirectedClause, FlagPart, Lasting, Nodes
from tissuec.script.verbs import VERBS, Action, EventQueue, LoggedEvent, Order
from tissuec.script.verbs.acting import FROM, free_name
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule


class EndPush(Struct, frozen=True):
    """The end of a force for an interval, unless it was stopped before."""

    load: str
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if state.loads.pop(self.load, None) is None:
            return ()
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("push")
class Push(VerbSentence, frozen=True):
    """Applies an external force to nodes, for the interval or until ``stop pushing``.

    The force is the total on the set. On faces of elements or walls, it is distributed evenly
    over their area as drawn, like a pressure of any direction. On edges, points, parts of a
    volume and nets of springs, or if it is written ``in equal parts``, all nodes get the same
    share. With ``on each node``, each node gets the whole force. It is written as a vector, or
    as an amount ``along`` a direction. It is constant or follows the profile after ``using``.
    Forces on one set add up. ``push`` and ``pull`` mean the same: the force has the direction
    that is written. A force on a held node acts on whatever holds the node.
    """

    meant: ClassVar[str] = "load"
    instead: ClassVar = {PRESSURE: "press {}"}

    group: Nodes
    force: Annotated[  # [N] as it is written, shape (3,)
        Floats,
        DirectedClause(
            "with",
            FORCE,
            "along",
            "along (0, 0, -1)",
            what="force",
            example="with 0.1 N along (0, 0, 1)",
            moves=True,
        ),
    ]
    each_node: Annotated[bool, FlagPart("on each node")]
    in_parts: Annotated[bool, FlagPart("in equal parts")]
    profile: Annotated[TimeProfile, STEADY]
    duration: Lasting

    @property
    def shift(self) -> float:
        """Infinity: it is not known how far nodes move."""
        return inf

    def action(self, order: Order) -> Action:
        if self.each_node and self.in_parts:
            message = "each node gets the whole force or an equal part, not both"
            order.reject(
                "TIS306", message, hint='remove "on each node" or "in equal parts"', word="in"
            )
        return self

    def shares(self, network: Network) -> Floats | None:
        """Return the parts of nodes, dimensionless, shape (n,); None if they are equal."""
        if self.each_node or self.in_parts or not network.elements:
            return None
        from tissuec.forces.acting.traction import area_shares

        return area_shares(network, self.group.indices)

    def load(self, network: Network, profile: TimeProfile) -> Load:
        """Return the forces on nodes that follow a profile."""
        nodes, shares, force = self.group.indices, self.shares(network), self.force
        if shares is None and not self.each_node:
            force = force / max(len(nodes), 1)
        return Load(nodes, (LoadTerm(force, profile),), self.span, shares)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        load = free_name(self.group.name, state.loads, state.time, stop)
        state.loads[load] = self.load(state.network, profile)
        if self.duration is not None:
            queue.add(stop, EndPush(load, self.span))
        return (LoggedEvent("push", (), sentence(self.span), self.span),)


def stop_pushing(state: State, group: str) -> bool:
    """End every force on a set; return whether there was one."""
    loads = [load for load in state.loads if load.rpartition(FROM)[0] == group]
    for load in loads:
        del state.loads[load]
    return bool(loads)


@VERBS.member("pull")
class Pull(Push, frozen=True):
    """Applies an external force to nodes, exactly as ``push`` does."""

    meant: ClassVar[str] = ""
