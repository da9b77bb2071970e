"""``turn``: nodes that are turned about an axis."""

from math import inf
from typing import Annotated, ClassVar

import numpy as np

from tissuec.core.units import NUMBER
from tissuec.mechanics.state import PrescribedRotation as Path
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import MOVING, Lasting, Moved, NumberClause, direction, point
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import Driven, sentence
from tissuec.script.verbs.motion import EndMotion, driven_by, schedule, set_off
from tissuec.script.verbs.move import nothing_to_move


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
    angle: Annotated[float, NumberClause("by", NUMBER, what="angle", example="by 90 deg")]
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
