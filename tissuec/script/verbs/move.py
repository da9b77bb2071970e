"""``move``: nodes that follow a prescribed path."""

from typing import ClassVar, Self

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.hints import Edit, Hint, insertion
from tissuec.core.source import Span
from tissuec.forces.load import LoadTerm
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent, Mover, Order
from tissuec.script.verbs.holding import Driven, sentence
from tissuec.script.verbs.motion import EndMotion, driven_by, schedule, set_off

#: How the vector of a motion can be written.
SHIFT = "by (0, 0, 1) mm"


@VERBS.member("move")
class Move(Struct, frozen=True):
    """Moves a set, or everything that a tool holds, by a vector multiplied by a profile.

    With ``table "path.csv"`` and without ``by``, the table gives the displacements, in columns
    for time, x, y and z, relative to the positions at the start. After the motion, a set stays
    held exactly where it ended, at rest, until it is released. A tool moves the nodes that it
    holds; a tool that holds nothing moves no nodes. Simultaneous motions of a set or tool add
    up. If the motions of two sets or tools drive the same node, the later order applies.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "move SET by VECTOR using PROFILE",
        "move TOOL by VECTOR using PROFILE",
        'move SET using table "path.csv" in mm',
        'move SET along table "path.csv" in mm',
    )
    mover: Mover
    vectors: tuple[Floats, ...]  # [m], one per profile, each of shape (3,)
    profiles: tuple[TimeProfile, ...]
    duration: float | None  # [s]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        is_shift = order.has("by")
        if is_shift and order.has("in"):
            order.reject(
                "TIS306",
                "a motion has a vector or a path in a table, not both",
                hint=f"write: {cls.forms[0]} or: {cls.forms[3]}",
                word="in",
            )
        vectors = (order.vector("by", units.LENGTH),) if is_shift else tuple(np.eye(3))
        profiles = order.profiles(default="", columns=len(vectors))
        if not is_shift and order.has("to"):
            message = "a motion is given by how far it goes, not by where to"
            order.reject("TIS303", message, word="to", hint="for example: by (0, 0, 1) mm")
        if not is_shift and profiles[0].kind != "table":
            order.reject(
                "TIS304",
                "the vector of the motion is missing",
                hint=Hint(f"for example: {SHIFT}", insertion(f" {SHIFT}", order.span)),
            )
        refuse_jump(order, profiles)
        return cls(order.mover(), vectors, profiles, order.duration, order.span)

    def holding(self) -> Driven:
        return Driven(self.mover, self.duration)

    @property
    def shift(self) -> float:
        """Return the length of the vector [m]; infinite for a path in a table."""
        return float(np.linalg.norm(self.vectors[0])) if len(self.vectors) == 1 else np.inf

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if not len(driven_by(state, self.mover)):
            return (nothing_to_move(self.mover, self.span),)
        begun, stop = schedule(queue, self.profiles, state.time, self.duration)
        shifts = tuple(map(LoadTerm, self.vectors, begun))
        set_off(state, self.mover, self.span, shifts=shifts)
        if np.isfinite(stop):
            queue.add(stop, EndMotion(self.mover.name, stop, self.span))
        return (LoggedEvent("move", (), sentence(self.span), self.span),)


_SMOOTH = (Edit("using constant speed"), Edit("using smooth profile"))


def refuse_jump(order: Order, profiles: tuple[TimeProfile, ...]) -> None:
    """Refuse a path that begins elsewhere than where the nodes are."""
    if any(profile.at(profile.start)[0] != 0.0 for profile in profiles):
        is_constant = profiles[0].kind == "constant"
        order.reject(
            "TIS306",
            "this motion begins with a jump: its first value is not 0",
            hint=Hint("write using constant speed, or using smooth profile", *_SMOOTH)
            if is_constant
            else "change the first value to 0",
            word="using" if order.has("using") else None,
        )


def nothing_to_move(mover: Mover, span: Span) -> LoggedEvent:
    """Return the note that a tool holds nothing."""
    return LoggedEvent("note", (), f"{sentence(span)}: {mover.name} holds nothing", span)
