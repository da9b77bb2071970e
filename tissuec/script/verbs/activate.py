"""``activate``: an active stress along the fibres of muscle."""

from typing import TYPE_CHECKING, Annotated, ClassVar

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
from tissuec.script.verbs.acting import EndActing, free_name, put_as_drawn
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

if TYPE_CHECKING:
    from tissuec.forces.solids.activation import Activation


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
        from tissuec.forces.solids.activation import activated

        if any(True for _ in activated(network, self.group.indices)):
            return ""
        inside = set(self.group.indices.tolist())
        made = any(not inside.isdisjoint(f.nodes.ravel().tolist()) for f in network.elements)
        if not made:
            return Flaw(
                f"{self.group.name} does not consist of elements, along whose fibres it could "
                "pull",
                "make a body of elements: with a Young's modulus and a fibre modulus in its "
                "tissue and fibres in the body",
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
            name: Beginning of the names of their blocks.
            profile: Of the stress.
        """
        from tissuec.forces.solids.activation import UNLIMITED, Activation, activated

        return [
            Activation.of(
                f"{name} in {field.block.name.removeprefix('the ')}", self.group.name, field,
                items, self.amount, self.limits or UNLIMITED, profile, self.span,
            )
            for field, items in activated(network, self.group.indices)
        ]  # fmt: skip

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        what = f"the activation of {self.group.name}"
        name = free_name(what, state.blocks, state.time, stop)
        made = self.made(state.network, name, profile)
        put_as_drawn(state, *(one.block for one in made))
        if self.duration is not None:
            queue.add(stop, EndActing(tuple(one.key for one in made), self.span))
        return (LoggedEvent("activate", (), sentence(self.span), self.span),)
