"""``tighten`` and ``loosen``: threads and joints that are drawn in or paid out."""

from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.forces.rest_length import ChangingRestLengths
from tissuec.mechanics.state import State
from tissuec.model.network import Indices, Network, numbers_in
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import CHANGING, JOINT, THREAD, Lasting, NumberClause, SubjectPart
from tissuec.script.verbs import VERBS, ActionFailed, EventQueue, Group, LoggedEvent
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule


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
    return bool(len(group.indices)) and int(group.indices[0]) >= network.body_springs


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
