"""``tie``, ``tighten`` and ``loosen``: knots, and threads that are drawn in or paid out."""

from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import FORCE, LENGTH, show
from tissuec.forces.springs.springs import ChangingRestLengths
from tissuec.mechanics.state import State
from tissuec.model.knots import Knot
from tissuec.model.network import Indices, Network, numbers_in
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    CHANGING,
    JOINT,
    THREAD,
    ChoiceClause,
    Lasting,
    NumberClause,
    SubjectPart,
)
from tissuec.script.verbs import VERBS, ActionFailed, EventQueue, Group, LoggedEvent
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

#: What knots hold, as parts of the force that breaks the thread. Square: 69.5 % of the strength
#: of untied 1-0 polypropylene (A. Nigliazzo et al., Surgical Science 2 (2011) 195-197).
#: Surgeon's: 79.7/82.9 of that, which is the ratio of both knots over four other materials, and
#: no significant difference (T. M. Muffly et al., Journal of Surgical Education 67 (2010)
#: 222-226). Granny: an assumption, half of the square knot; it is known to be the less secure
#: one in several materials (E. Rosin, G. M. Robinson, Veterinary Surgery 18 (1989) 269-273),
#: and how much depends on the material.
KNOTS = {"square knot": 0.695, "surgeons knot": 0.668, "granny knot": 0.35}
_DESCRIBED = {
    knot: f"Holds {part:.1%} of the breaking force of its thread."
    for knot, part in KNOTS.items()
}


@VERBS.member("tie")
class Tie(VerbSentence, frozen=True):
    """Ties the ends of a thread, a loop where it is closed, or the stitches of a joint.

    The knot is a piece of thread between the ends at their present positions, without
    viscosity. It holds up to a limit: the force after ``of``, or a fraction of the ``breaking
    force`` of the thread. The fraction is 69.5 % for a square knot (published for
    polypropylene), 66.8 % for a surgeons knot (from the published ratio of both knots in other
    materials) and 35 % for a granny knot (an assumption). Above the limit the knot slips: the
    ends part, or the thread is drawn in without them, at this constant force, until the force
    decreases and the knot holds again. A thread whose ``rupture`` is not allowed has no
    breaking force, so the force must be written. Before it is tied, a loop is held together by
    hand and does not slip.

    Each spring of a joint is a stitch with its own knot. Above its limit, the knot comes
    undone: the spring ruptures. The breaking force of each stitch becomes the smaller of the
    force of the knot and the breaking force that the scene gives the stitch.
    """

    meant: ClassVar[str] = "knot ligate"

    group: Annotated[Group, SubjectPart("springs", (THREAD, JOINT))]
    kind: Annotated[str, ChoiceClause("with", _DESCRIBED, what="knot")]
    force: Annotated[
        float | None,
        NumberClause(
            "of",
            FORCE,
            "positive",
            what="force of a knot",
            example="of 1 N",
        ),
    ]

    def flaw(self, network: Network) -> str:
        """Return why it can never be tied, empty if it can."""
        if text := not_to_be_drawn(network, self.group):
            return text
        thread = network.threads.get(self.group.name)
        knots = self.group.indices if thread is None else [thread.hold]
        if self.force is None and not np.isfinite(network.springs.strength[knots]).all():
            return (
                f"{self.group.name} has no breaking force, on which the force of its "
                f"{self.kind} depends: "
                f"allow its rupture, or write the force: with {self.kind} of 2 N"
            )
        return ""

    def breakable(self, network: Network) -> Indices:
        """Return the springs of its knots, shape (n,)."""
        thread = network.threads.get(self.group.name)
        return self.group.indices if thread is None else np.array([thread.hold])

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if is_of_joints(state.network, self.group):
            return self._sew(state)
        thread = state.network.threads[self.group.name]
        hold, slip = thread.hold, thread.slip
        # Without the piece of the knot, which may have been tied before.
        along = np.setdiff1d(np.r_[thread.pieces], thread.hold)
        whole = float(state.springs.strength[along].min())
        limit = KNOTS[self.kind] * whole if self.force is None else self.force
        alive, springs = state.alive.copy(), state.springs
        first, second = state.position[state.springs.ends[hold]]
        apart = float(np.linalg.norm(second - first))
        logged_events = [LoggedEvent("tie", (), sentence(self.span), self.span)]
        if not alive[hold]:
            springs = springs.changed("rest", hold, apart)
            if apart > springs.rest[thread.pieces].max():
                note = (
                    f"the ends of {self.group.name} are {show(apart, LENGTH)} apart when tied"
                )
                logged_events.append(LoggedEvent("note", (), note, self.span))
        alive[hold], alive[slip] = True, False
        springs = springs.changed("strength", hold, min(limit, whole))
        springs = springs.changed("damping", slip, limit)
        # So that it slips by being drawn out, never by being let in.
        state.springs = springs.changed("damping", hold, 0.0)
        state.alive = alive
        knot = Knot(self.kind, hold, slip, limit, whole, None, self.span)
        state.knots = {**state.knots, self.group.name: knot}
        return tuple(logged_events)

    def _sew(self, state: State) -> tuple[LoggedEvent, ...]:
        """Let each stitch bear what its knot holds."""
        whole = state.network.springs.strength[self.group.indices]
        limit = KNOTS[self.kind] * whole if self.force is None else self.force
        limits = np.minimum(limit, whole)
        state.springs = state.springs.changed("strength", self.group.indices, limits)
        return (LoggedEvent("tie", (), sentence(self.span), self.span),)


def slipped(name: str, knot: Knot) -> LoggedEvent:
    """Return the entry of a knot that begins to slip."""
    text = f"the {knot.kind} of {name} slips at {show(knot.limit, FORCE)}"
    return LoggedEvent("slip", (), text, knot.span)


def seized(name: str, knot: Knot) -> LoggedEvent:
    """Return the entry of a knot that holds again."""
    return LoggedEvent("seize", (), f"the {knot.kind} of {name} holds again", knot.span)


class ChangeRestLength(VerbSentence, frozen=True):
    """Another length for a thread, or for every spring of a joint.

    A thread gets it by shares of the lengths that its pieces have.

    Attributes:
        shorter: Whether springs can only become shorter; otherwise only longer.
        length: [m].
        duration: Of the sentence [s]; None at once.
    """

    shorter: ClassVar[bool]

    group: Annotated[Group, SubjectPart("springs", (THREAD, JOINT))]
    length: Annotated[
        float,
        NumberClause(
            "to", LENGTH, "positive", what="length without tension", example="to 10 mm",
        ),
    ]  # fmt: skip
    profile: Annotated[TimeProfile, CHANGING]
    duration: Lasting

    def flaw(self, network: Network) -> str:
        """Return why it cannot be done, empty if it can."""
        return not_to_be_drawn(network, self.group)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Begin the change of rest lengths.

        Raises:
            ActionFailed: Nothing is left of the thread or joint.
        """
        name = self.group.name
        springs = intact(state, self.group)
        state.stop_reeling(self.group.indices)
        rest = state.springs.rest[springs]
        if rest.sum() <= 0.0:
            message = f"all springs of {name} are broken, so its length cannot change"
            first = state.springs.ends[self.group.indices[0], 0]
            raise ActionFailed(message, int(first), self.span)
        text = sentence(self.span)
        if name in state.network.threads:
            present = float(rest.sum())
            wanted = rest * (self.length / present)
            idle = f"its length is already {show(present, LENGTH)}"
        else:
            wanted = np.full(len(rest), self.length)
            idle = f"its springs are already that {'short' if self.shorter else 'long'}"
        change = wanted - rest
        change = np.minimum(change, 0.0) if self.shorter else np.maximum(change, 0.0)
        if not change.any():
            return (LoggedEvent("note", (), f"{text}: {idle}", self.span),)
        if self.profile.kind == "constant":
            own = state.springs.rest[springs] + change
            state.springs = state.springs.changed("rest", springs, own)
            return (LoggedEvent("tighten", (), text, self.span),)
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        reeling = ChangingRestLengths(springs, rest, change, profile, self.span)
        state.reelings = {**state.reelings, name: reeling}
        if np.isfinite(stop):
            queue.add(stop, EndRestLengthChange(name, self.span, stop))
        return (LoggedEvent("tighten", (), text, self.span),)


class EndRestLengthChange(Struct, frozen=True):
    """The end of drawing in or paying out, unless another order took its place."""

    thread: str
    span: Span
    stop: float  # [s]

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        reeling = state.reelings.get(self.thread)
        if reeling is None or reeling.profile.stop > self.stop:
            return ()
        state.reelings = {
            name: other for name, other in state.reelings.items() if other is not reeling
        }
        rest = reeling.rest(self.stop)
        state.springs = state.springs.changed("rest", reeling.springs, rest)
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("tighten")
class Tighten(ChangeRestLength, frozen=True):
    """Shortens a thread or joint to a rest length, gradually within the interval or at once.

    The length is that without tension. For a thread, it is the total length of all intact
    pieces and of a tied knot: for a sling, its circumference when slack. All pieces become
    shorter in proportion, as when a sling is drawn through its knot while it slides over
    tissue. For a joint, or a set of its springs, it is the length of each spring. The profile
    after ``using`` gives the course of the shortening, which otherwise has constant speed.
    Parts that are already shorter do not change. If nothing changes, a note says so.
    """

    shorter: ClassVar[bool] = True


@VERBS.member("loosen")
class Loosen(ChangeRestLength, frozen=True):
    """Lengthens a thread or joint to a rest length: the opposite of ``tighten``."""

    shorter: ClassVar[bool] = False


def is_of_joints(network: Network, group: Group) -> bool:
    """Return whether springs are those of joints, or some of them."""
    lines = group.indices  # ascending; edges of elements follow joints
    return (
        bool(len(lines))
        and int(lines[0]) >= network.body_springs
        and int(lines[-1]) < network.spring_count
    )


def not_to_be_drawn(network: Network, group: Group) -> str:
    """Return a complaint if springs are neither a thread nor a joint, else an empty text."""
    if group.name in network.threads or is_of_joints(network, group):
        return ""
    return f"{group.name} is neither a body with mesh thread nor a joint"


def intact(state: State, group: Group) -> Indices:
    """Return the intact springs along a thread or of a joint, ascending, shape (n,).

    Those of a thread include the spring of its knot.
    """
    thread = state.network.threads.get(group.name)
    every = group.indices
    if thread is not None:
        pieces = numbers_in(thread.pieces)
        every = np.unique(np.append(pieces, thread.hold))
    return every[state.alive[every]]
