"""``push`` and ``pull``: external forces on nodes."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core import units
from tissuec.core.errors import Edit, Hint, insertion
from tissuec.core.source import Span
from tissuec.forces.load import Load, Term
from tissuec.mechanics.situation import Situation
from tissuec.model.network import Floats
from tissuec.model.profiles import Course
from tissuec.script.verbs import VERBS, Agenda, Group, Happening, Order
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

#: How a force, and the direction of an amount, can be written.
FORCE, DIRECTION = "with 0.1 N along (0, 0, 1)", "along (0, 0, -1)"


class EndPush(Struct, frozen=True):
    """The end of a force for an interval, unless it was stopped before."""

    load: str
    span: Span

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        if situation.loads.pop(self.load, None) is None:
            return ()
        return (Happening("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("push")
class Push(Struct, frozen=True):
    """Lets an external force act on nodes, for the interval or until ``stop pushing``.

    The force is that on the whole set and is shared equally by its nodes; with ``on each
    node`` each of them gets all of it. It is written as a vector, or as an amount ``along`` a
    direction, and is constant or follows the course after ``using``. Forces on one set add up.
    ``push`` and ``pull`` are two words for one thing: the direction is the one that is
    written. A force on a held node is taken up by whoever holds it.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "push SET with FORCES",
        "push SET with FORCE along VECTOR",
        "push SET with FORCES on each node",
        "push SET with FORCES using COURSE",
    )
    group: Group
    force: Floats  # [N] on each node, shape (3,)
    course: Course
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
        course = order.courses(default="constant")[0]
        return cls(group, force, course, order.duration, order.span)

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        (course,), stop = schedule(agenda, (self.course,), situation.time, self.duration)
        load = _free_name(situation, self.group.name, stop)
        terms = (Term(self.force, course),)
        situation.loads[load] = Load(self.group.indices, terms, self.span)
        if self.duration is not None:
            agenda.add(stop, EndPush(load, self.span))
        return (Happening("push", (), sentence(self.span), self.span),)


def stop_pushing(situation: Situation, group: str) -> bool:
    """End every force on a set; return whether there was one."""
    loads = [load for load in situation.loads if load.rpartition(_FROM)[0] == group]
    for load in loads:
        del situation.loads[load]
    return bool(loads)


_FROM = " from "


def _free_name(situation: Situation, group: str, stop: float) -> str:
    """Return a name that no other load has, had or will have, unless both end together."""
    name = f"{group}{_FROM}{situation.time!r} s to {stop!r} s"
    count = 1
    while f"{name} #{count}" in situation.loads:
        count += 1
    return f"{name} #{count}"


def _written_force(order: Order) -> Floats:
    if order.is_vector("with"):
        if order.has("along"):
            order.reject(
                "TIS306",
                "the force has a direction already",
                hint='write an amount such as 0.1 N before "along", or leave "along" out',
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
            f'"{text}" cannot stand after "on"',
            hint=Hint("write: on each node", Edit("on each node")),
            word="on",
        )
    return True
