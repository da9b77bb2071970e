"""``activate``: an active stress along the fibres of muscle."""

from typing import TYPE_CHECKING, Annotated, ClassVar

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import NUMBER, PRESSURE
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    BODY,
    SET,
    STEADY,
    Lasting,
    NumberClause,
    RangeClause,
    SubjectPart,
)
from tissuec.script.verbs import VERBS, EventQueue, Flaw, Group, LoggedEvent
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

if TYPE_CHECKING:
    from tissuec.forces.activation import Activation


class EndActivation(Struct, frozen=True):
    """The end of an activation for an interval, unless it was stopped earlier."""

    keys: tuple[str, ...]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        acting = [state.blocks[key] for key in self.keys if key in state.blocks]
        if not acting:
            return ()
        state.remove(*acting)
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("activate")
class Activate(VerbSentence, frozen=True):
    """Lets muscle pull along its fibres, for the interval or until ``stop activating``.

    The number is the active stress along the fibres: a force per drawn cross-section, in
    addition to the passive stress of the tissue. It is constant or follows the profile after
    ``using``. It acts in the elements of a body or set that have fibres, along all of their
    families; of a set, in those all of whose nodes are in it. Activations add up.

    With ``over 60 % to 160 %``, fibres pull only while their length is between these parts of
    their drawn length: with all of the stress in the middle, and less and less towards both
    limits. Work of the fibres is work from outside.
    """

    meant: ClassVar[str] = "contract stimulate excite"

    group: Annotated[Group, SubjectPart("nodes", (BODY, SET))]
    amount: Annotated[  # [Pa]
        float,
        NumberClause(
            "with", PRESSURE, what="active stress", example="with 30 kPa", place="PRESSURE"
        ),
    ]
    limits: Annotated[  # of the length
        tuple[float, float] | None,
        RangeClause(
            "over", NUMBER, what="length", example="over 60 % to 160 %", place="FACTOR"
        ),
    ]
    profile: Annotated[TimeProfile, STEADY]
    duration: Lasting

    def flaw(self, network: Network) -> str:
        """Return the reason why nothing can be active; empty if something can be."""
        from tissuec.forces.activation import activated

        if any(True for _ in activated(network, self.group.indices)):
            return ""
        inside = set(self.group.indices.tolist())
        made = any(not inside.isdisjoint(f.nodes.ravel().tolist()) for f in network.elements)
        if not made:
            return Flaw(
                f"{self.group.name} does not consist of elements, along whose fibres it could "
                "pull",
                "make a body of elements: with a Young's modulus and a fibre modulus in its "
                "tissue, fibres in the body, and not made of springs",
            )
        with_fibres = any(f.fibres.along.shape[1] for f in network.elements)
        if with_fibres:
            return Flaw(
                f"{self.group.name} contains no element with fibres as a whole",
                "name a body that has fibres, or all nodes of some of its elements",
            )
        return Flaw(
            f"{self.group.name} has no fibres along which it could pull",
            "write fibres = (1, 0, 0) in the body and a fibre modulus in its tissue, which may "
            "be as small as Young's modulus",
        )

    def made(self, network: Network, name: str, profile: TimeProfile) -> "list[Activation]":
        """Return the active elements, shape by shape.

        Args:
            network: The network.
            name: Beginning of the names of their blocks.
            profile: Of the stress.
        """
        from tissuec.forces.activation import UNLIMITED, Activation, activated

        return [
            Activation.of(
                f"{name} in {field.block.name.removeprefix('the ')}", self.group.name, field,
                items, self.amount, self.limits or UNLIMITED, profile, self.span,
            )
            for field, items in activated(network, self.group.indices)
        ]  # fmt: skip

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        made = self.made(state.network, self._free_name(state, stop), profile)
        state.put(*(one.block for one in made))
        if self.duration is not None:
            queue.add(stop, EndActivation(tuple(one.key for one in made), self.span))
        return (LoggedEvent("activate", (), sentence(self.span), self.span),)

    def _free_name(self, state: State, stop: float) -> str:
        """Return the beginning of a name that no other activation has, had or will have."""
        name = f"the activation of {self.group.name} from {state.time!r} s to {stop!r} s"
        count = 1
        while any(key.startswith(f"{name} #{count} ") for key in state.blocks):
            count += 1
        return f"{name} #{count}"


def stop_activating(state: State, name: str) -> bool:
    """End every activation of a set or body; return whether there was one."""
    ended = [
        block
        for block in state.blocks.values()
        if block.kind == "activation" and block.field.name == name
    ]
    state.remove(*ended)
    return bool(ended)
