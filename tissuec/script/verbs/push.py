"""``push`` and ``pull``: external forces on nodes."""

from math import inf
from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core import units
from tissuec.core.hints import Edit, Hint, insertion
from tissuec.core.source import Span
from tissuec.forces.load import Load, LoadTerm
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import VERBS, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

#: How a force, and the direction of an amount, can be written.
FORCE, DIRECTION = "with 0.1 N along (0, 0, 1)", "along (0, 0, -1)"


class EndPush(Struct, frozen=True):
    """The end of a force for an interval, unless it was stopped before."""

    load: str
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if state.loads.pop(self.load, None) is None:
            return ()
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("push")
class Push(Struct, frozen=True):
    """Applies an external force to nodes, for the interval or until ``stop pushing``.

    The force is that on the whole set, shared equally by its nodes; with ``on each node``, each
    node gets all of it. It is written as a vector, or as an amount ``along`` a direction. It is
    constant or follows the profile after ``using``. Forces on one set add up. ``push`` and
    ``pull`` mean the same: the force has the direction that is written. A force on a held node
    acts on whatever holds the node.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "push SET with FORCES",
        "push SET with FORCE along VECTOR",
        "push SET with FORCES on each node",
        "push SET with FORCES using PROFILE",
    )
    group: Group
    force: Floats  # [N] on each node, shape (3,)
    profile: TimeProfile
    duration: float | None  # [s]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        group = order.nodes()
        if not order.has("with"):
            order.reject(
                "TIS304",
                "a force is missing",
                hint=Hint(
                    f"write it after the set: {FORCE}", insertion(f" {FORCE}", order.span)
                ),
            )
        force = _written_force(order)
        if not _is_for_each_node(order):
            force = force / max(len(group.indices), 1)
        profile = order.profiles(default="constant")[0]
        return cls(group, force, profile, order.duration, order.span)

    @property
    def shift(self) -> float:
        """Return that it is not known how far nodes move."""
        return inf

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        load = _free_name(state, self.group.name, stop)
        terms = (LoadTerm(self.force, profile),)
        state.loads[load] = Load(self.group.indices, terms, self.span)
        if self.duration is not None:
            queue.add(stop, EndPush(load, self.span))
        return (LoggedEvent("push", (), sentence(self.span), self.span),)


def stop_pushing(state: State, group: str) -> bool:
    """End every force on a set; return whether there was one."""
    loads = [load for load in state.loads if load.rpartition(_FROM)[0] == group]
    for load in loads:
        del state.loads[load]
    return bool(loads)


_FROM = " from "


def _free_name(state: State, group: str, stop: float) -> str:
    """Return a name that no other load has, had or will have, unless both end together."""
    name = f"{group}{_FROM}{state.time!r} s to {stop!r} s"
    count = 1
    while f"{name} #{count}" in state.loads:
        count += 1
    return f"{name} #{count}"


def _written_force(order: Order) -> Floats:
    if order.is_vector("with"):
        if order.has("along"):
            order.reject(
                "TIS306",
                "the force already has a direction",
                hint='write an amount such as 0.1 N before "along", or remove "along"',
                word="along",
            )
        return order.vector("with", units.FORCE)
    amount = order.number("with", units.FORCE)
    if not order.has("along"):
        order.reject(
            "TIS304",
            "the direction of the force is missing",
            hint=Hint(
                f"write a vector such as (0, 0, -0.1) N, or add: {DIRECTION}",
                insertion(f" {DIRECTION}", order.span),
            ),
            word="with",
        )
    return amount * order.direction("along")


def _is_for_each_node(order: Order) -> bool:
    if not order.has("on"):
        return False
    text = order.text("on")
    if text.lower() != "each node":
        order.reject(
            "TIS305",
            f'unexpected "{text}" after "on"',
            hint=Hint("write: on each node", Edit("on each node")),
            word="on",
        )
    return True
