"""``press``: a prescribed pressure on surfaces."""

from typing import TYPE_CHECKING, ClassVar, Self

from msgspec import Struct

from tissuec.core import units
from tissuec.core.hints import Hint, insertion
from tissuec.core.source import Span
from tissuec.forces.pressed_sides import NoSide, Pressed, pressed_faces
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import VERBS, EventQueue, Flaw, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

if TYPE_CHECKING:
    from tissuec.forces.pressure import SurfacePressure

EXAMPLE = "with 16 kPa"
CAPS = "with caps"
INSIDE = "inside"
_FROM = " from "


class EndPress(Struct, frozen=True):
    """The end of a pressure for an interval, unless it was stopped earlier."""

    key: str
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if self.key not in state.blocks:
            return ()
        state.remove(state.blocks[self.key])
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("press")
class Press(Struct, frozen=True):
    """Applies a pressure to a surface, for the interval or until ``stop pressing``.

    The pressure always acts normal to the faces as they move. It pushes a wall
    outwards, from the space that the wall encloses. It pushes a solid from outside; ``inside
    of`` a solid is the part of its skin that faces a space within, such as the lumen of a thick
    tube. A wall that encloses nothing, such as a sheet, needs the direction ``along`` which
    it is pushed. For a set, the pressure acts on the surface triangles all of whose corners are
    in the set.

    The pressure is relative to that on the other side, and may be negative. It is
    constant or follows the profile after ``using``. Pressures on one surface add up. With
    caps, each open end is closed by a light plug that passes the force of the pressure on to
    the rim.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "press BODY with PRESSURE",
        "press SET with PRESSURE",
        "press inside of BODY with PRESSURE",
        "press BODY with PRESSURE with caps",
        "press SET with PRESSURE along VECTOR",
        "press BODY with PRESSURE using PROFILE",
    )
    group: Group
    is_inside: bool
    along: Floats | None  # unit vector, shape (3,)
    amount: float  # [Pa]
    has_caps: bool
    profile: TimeProfile
    duration: float | None  # [s]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        is_inside = order.words.lower() == INSIDE and order.has("of")
        group = order.nodes_of("of") if is_inside else order.nodes()
        if not order.has("with"):
            hint = Hint(f"for example: {EXAMPLE}", insertion(f" {EXAMPLE}", order.span))
            order.reject("TIS304", "the pressure is missing", hint=hint)
        amount = order.number("with", units.PRESSURE)
        along = order.direction("along") if order.has("along") else None
        profile = order.profiles(default="constant")[0]
        return cls(
            group,
            is_inside,
            along,
            amount,
            order.has(CAPS),
            profile,
            order.duration,
            order.span,
        )

    @property
    def _pressed(self) -> Pressed:
        return Pressed(self.group.name, self.group.indices, self.is_inside, self.along)

    def flaw(self, network: Network) -> str:
        """Return the reason why nothing can be pressed; empty if it can be."""
        try:
            self.made(network, "", self.profile)
        except NoSide as error:
            return Flaw(str(error), error.hint)
        return ""

    def made(self, network: Network, key: str, profile: TimeProfile) -> "SurfacePressure":
        """Return the pressure on the surface.

        Args:
            network: The network.
            key: Name of its block.
            profile: Of the pressure.

        Raises:
            NoSide: There is no surface, or the direction of the push is not known.
        """
        from tissuec.forces.pressed_sides import closed_by_caps
        from tissuec.forces.pressure import SurfacePressure

        faces = pressed_faces(network, self._pressed)
        if self.has_caps:
            closed_by_caps(network, self.group.name, faces)
        return SurfacePressure.of(
            key, self.group.name, faces, self.amount, profile, self.span, has_caps=self.has_caps
        )

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        made = self.made(state.network, self._free_name(state, stop), profile)
        state.put(made.block)
        if self.duration is not None:
            queue.add(stop, EndPress(made.key, self.span))
        return (LoggedEvent("press", (), sentence(self.span), self.span),)

    def _free_name(self, state: State, stop: float) -> str:
        """Return a name that no other pressure has, had or will have, as for pushes."""
        name = f"the pressure on {self.group.name}{_FROM}{state.time!r} s to {stop!r} s"
        count = 1
        while f"{name} #{count}" in state.blocks:
            count += 1
        return f"{name} #{count}"


def stop_pressing(state: State, name: str) -> bool:
    """End every pressure on a set or body; return whether there was one."""
    ended = [
        block
        for block in state.blocks.values()
        if block.kind == "pressure" and block.field.name == name
    ]
    state.remove(*ended)
    return bool(ended)
