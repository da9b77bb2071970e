"""``move`` and ``turn``: nodes that follow a prescribed path."""

from math import inf
from typing import Annotated, ClassVar

import numpy as np

from tissuec.core.arrays import norm
from tissuec.core.source import Span
from tissuec.core.units import LENGTH
from tissuec.forces.acting.load import LoadTerm
from tissuec.mechanics.state import PrescribedRotation as Path
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    MOVING,
    Across,
    Along,
    AngleClause,
    Lasting,
    Moved,
    ProfileClause,
    Refusal,
    VectorClause,
    direction,
    point,
)
from tissuec.script.verbs import VERBS, Action, EventQueue, LoggedEvent, Mover, Order
from tissuec.script.verbs.holding import Driven, held_in, refuse_both, sentence
from tissuec.script.verbs.motion import EndMotion, driven_by, schedule, set_off

#: How the vector of a motion can be written.
SHIFT = "by (0, 0, 1) mm"
ASLANT = 1e-9  # part of a vector outside of the directions of a hold, by rounding


@VERBS.member("move")
class Move(VerbSentence, frozen=True):
    """Moves a set, or everything that a tool holds, by a vector multiplied by a profile.

    With ``table "path.csv"`` and without ``by``, the table gives the displacements, in columns
    for time, x, y and z, relative to the positions at the start. After the motion, a set stays
    held exactly where it ended, at rest, until it is released. A tool moves the nodes that it
    holds; a tool that holds nothing moves no nodes. Simultaneous motions of a set or tool add
    up. Motions of two sets or tools cannot drive the same node at the same time. With ``along``
    or ``across``, nodes are moved and held in some directions only, as with ``fix``, and follow
    the forces on them in the others.
    """

    meant: ClassVar[str] = "lift raise lower drag shift translate displace advance retract draw"
    refused: ClassVar = {
        "to": Refusal(
            "a motion is given by how far it goes, not by where to", f"for example: {SHIFT}"
        )
    }

    mover: Moved
    by: Annotated[
        Floats | None,
        VectorClause("by", LENGTH, what="vector of the motion", example=SHIFT, moves=True),
    ]
    along: Along
    across: Across
    profiles: Annotated[tuple[TimeProfile, ...], ProfileClause("", "", path="by")]
    duration: Lasting

    def action(self, order: Order) -> Action:
        refuse_both(self.along, self.across, order)
        word = "across" if self.along is None else "along"
        if (directions := self.directions) is None:
            return self
        if self.mover.nodes is None:
            order.reject(
                "TIS306", "a tool holds its nodes in all directions",
                hint=f"write a set instead of {self.mover.name}, or leave this out", word=word,
            )  # fmt: skip
        if self.by is None:
            order.reject(
                "TIS304", f'a path in a table does not go with "{word}"',
                hint=f"write {SHIFT} before it, and a table of time and factor", word=word,
            )  # fmt: skip
        to = "perpendicular" if self.along is None else "parallel"
        missing = self.by - directions.T @ (directions @ self.by)
        if norm(missing) > ASLANT * norm(self.by):
            order.reject(
                "TIS306", "the motion leaves the directions in which the nodes are held",
                hint=f"its vector must be {to} to this direction",
                word=word,
            )  # fmt: skip
        return self

    @property
    def directions(self) -> Floats | None:
        """Return those in which nodes are held, as unit vectors of shape (direction, 3).

        None for all.
        """
        return held_in(self.along, self.across)

    def holding(self) -> Driven:
        return Driven(self.mover, self.duration, self.directions)

    @property
    def vectors(self) -> tuple[Floats, ...]:
        """What each profile is multiplied by [m], shape (3,) each; axes for a path."""
        return tuple(np.eye(3)) if self.by is None else (self.by,)

    @property
    def shift(self) -> float:
        """Return the length of the vector [m]; infinite for a path in a table."""
        return np.inf if self.by is None else float(np.linalg.norm(self.by))

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if not len(driven_by(state, self.mover)):
            return (nothing_to_move(self.mover, self.span),)
        begun, stop = schedule(queue, self.profiles, state.time, self.duration)
        shifts = tuple(map(LoadTerm, self.vectors, begun))
        name = set_off(state, self.mover, self.span, shifts=shifts, directions=self.directions)
        if np.isfinite(stop):
            queue.add(stop, EndMotion(name, stop, self.span))
        return (LoggedEvent("move", (), sentence(self.span), self.span),)


def nothing_to_move(mover: Mover, span: Span) -> LoggedEvent:
    """Return the note that a tool holds nothing."""
    return LoggedEvent("note", (), f"{sentence(span)}: {mover.name} holds nothing", span)


@VERBS.member("turn")
class Turn(VerbSentence, frozen=True):
    """Turns a set, or everything that a tool holds, about an axis by an angle times a profile.

    The axis passes through the mean position of the turned nodes at the beginning of the turn,
    or through the point after ``through``. The turn is right-handed about the direction after
    ``around``. Nodes are held during and after the turn as with ``move``. A simultaneous motion
    of the same set or tool carries the axis with it. A second turn starts at the present angle
    and ends the first.
    """

    meant: ClassVar[str] = "rotate twist tilt spin"

    mover: Moved
    angle: Annotated[
        float, AngleClause("by", what="angle", place="ANGLE", example="by 90 deg", moves=True)
    ]
    axis: Annotated[Floats, direction("around")]  # unit vector, shape (3,)
    centre: Annotated[Floats | None, point("through")]  # None: the mean position
    profile: Annotated[TimeProfile, MOVING]
    duration: Lasting

    def holding(self) -> Driven:
        return Driven(self.mover, self.duration)

    @property
    def shift(self) -> float:
        """Infinity: it is not known how far nodes move."""
        return inf

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        nodes = driven_by(state, self.mover)
        if not len(nodes):
            return (nothing_to_move(self.mover, self.span),)
        state.place_held()
        centre = state.position[nodes].mean(axis=0) if self.centre is None else self.centre
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        path = Path(centre, self.axis, self.angle, profile)
        set_off(state, self.mover, self.span, turn=path)
        if np.isfinite(stop):
            queue.add(stop, EndMotion(self.mover.name, stop, self.span))
        return (LoggedEvent("turn", (), sentence(self.span), self.span),)
