"""``open`` and ``close``: relative motion of the jaws of forceps."""

import re
from typing import Annotated, ClassVar

import numpy as np

from tissuec.core.hints import Edit, Hint
from tissuec.core.units import LENGTH, show
from tissuec.forces.acting.load import LoadTerm
from tissuec.mechanics.state import State
from tissuec.model.network import Network, ToolPart
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import MOVING, Lasting, NumberClause, ToolClause
from tissuec.script.verbs import (
    VERBS,
    Action,
    ActionFailed,
    EventQueue,
    LoggedEvent,
    Mover,
    Order,
)
from tissuec.script.verbs.holding import JawsMoved, sentence
from tissuec.script.verbs.motion import EndMotion, schedule, set_off

JAWS = ("upper jaw", "lower jaw")


class JawMotion(VerbSentence, frozen=True):
    """Moves both jaws by half of a length each, along the line between their centres.

    Attributes:
        apart: Whether they move apart; otherwise towards each other.
        tool: Name of the forceps.
        way: How far they go [m].
        profile: Time profile of the motion.
        duration: Of the order [s]; None if it ends with the profile.
    """

    apart: ClassVar[bool]

    tool: Annotated[str, ToolClause("", "forceps", what="tool")]
    way: Annotated[float, NumberClause("by", LENGTH, what="length", example="by 2 mm")]
    profile: Annotated[TimeProfile, MOVING]
    duration: Lasting

    def action(self, order: Order) -> Action:
        if self.way <= 0.0:
            hint = Hint(
                "for the opposite direction, write close instead of open, or open instead of "
                "close",
                *_turned_round(order),
            )
            order.reject(
                "TIS308", "the length of a motion of jaws must be above 0", hint=hint, word="by"
            )
        return self

    def flaw(self, network: Network) -> str:
        """Return why a tool has no jaws, empty if it has."""
        part = _forceps(network, self.tool)
        if part is not None and part.jaws is not None:
            return ""
        return f"{self.tool} has no jaws: it needs radius, upper and lower"

    def holding(self) -> JawsMoved:
        return JawsMoved(self.tool)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Begin the motion of both jaws at the present time.

        Raises:
            ActionFailed: The forceps are moving as a whole.
        """
        if self.tool in state.motions:
            node = int(state.motions[self.tool].nodes[0])
            raise ActionFailed(
                f"{self.tool} cannot open or close while it is moved", node, self.span
            )
        part = _forceps(state.network, self.tool)
        assert part is not None and part.jaws is not None, "reported before the run"
        jaws = part.jaws
        upper, lower = (state.position[jaw].mean(axis=0) for jaw in jaws)
        across = (upper - lower) / np.linalg.norm(upper - lower)
        way = self.way if self.apart else -self.way
        begun, stop = schedule(queue, (self.profile,), state.time, self.duration)
        for name, jaw, sign in zip(JAWS, jaws, (0.5, -0.5), strict=True):
            mover = Mover(f"{self.tool} {name}", jaw)
            set_off(state, mover, self.span, shifts=(LoadTerm(sign * way * across, begun[0]),))
            if np.isfinite(stop):
                queue.add(stop, EndMotion(mover.name, stop, self.span))
        kind = "open" if self.apart else "close"
        done = LoggedEvent(kind, (), sentence(self.span), self.span)
        gap = float(np.linalg.norm(upper - lower)) - 2.0 * part.shapes[0].radius
        if self.apart or self.way <= gap * (1.0 + 1e-9):
            return (done,)
        over = show(self.way - gap, LENGTH)
        told = f"{sentence(self.span)}: the jaws pass through each other, by {over}"
        return done, LoggedEvent("note", (), told, self.span)


def _turned_round(order: Order) -> list[Edit]:
    """Return the edit that writes the other verb and a length above 0, if one is negative."""
    verb, _, rest = order.span.text.partition(" ")
    other = {"open": "close", "close": "open"}.get(verb.lower())
    way, count = re.subn(r"\bby\s*-\s*(?=[0-9])", "by ", rest)
    return [Edit(f"{other} {way}", order.span)] if other and count == 1 else []


def _forceps(network: Network, tool: str) -> ToolPart | None:
    """Return the tool of a name, if it has a shape."""
    return next((part for part in network.tools if part.name == tool), None)


@VERBS.member("open")
class Open(JawMotion, frozen=True):
    """Opens the jaws of forceps by a length; each jaw moves by half of it.

    The forceps must not be moved as a whole at the same time. Tissue between the jaws is held
    only by friction, and slips when the pull exceeds it. The forces on the jaws are contact
    forces.
    """

    apart: ClassVar[bool] = True


@VERBS.member("close")
class Close(JawMotion, frozen=True):
    """Closes the jaws of forceps by a length; each jaw moves by half of it.

    The forceps must not be moved as a whole at the same time. Tissue between the jaws is held
    only by friction, and slips when the pull exceeds it. The forces on the jaws are contact
    forces.
    """

    apart: ClassVar[bool] = False
