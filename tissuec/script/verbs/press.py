"""``press``: a prescribed pressure on surfaces."""

from typing import TYPE_CHECKING, Annotated, ClassVar

from tissuec.core.units import FORCE, PRESSURE
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    BODY,
    SET,
    STEADY,
    Cases,
    FlagPart,
    Lasting,
    NumberClause,
    SubjectPart,
    direction,
)
from tissuec.script.verbs import VERBS, EventQueue, Flaw, Group, LoggedEvent
from tissuec.script.verbs.acting import EndActing, free_name, put_as_drawn
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule

if TYPE_CHECKING:
    from tissuec.forces.enclosed.pressure import SurfacePressure


class Press(VerbSentence, frozen=True):
    """A pressure on the surface of a body or set, from outside if it is solid.

    Attributes:
        is_inside: Whether it is on the surface of a space within.
        along: Unit vector, shape (3,).
        amount: [Pa].
        duration: Of the sentence [s]; None without an end.
    """

    instead: ClassVar = {FORCE: "push {} along (0, 0, 1)"}
    is_inside: ClassVar[bool] = False

    group: Annotated[Group, SubjectPart("nodes", (BODY, SET))]
    amount: Annotated[
        float,
        NumberClause("with", PRESSURE, what="pressure", example="with 16 kPa", moves=True),
    ]
    has_caps: Annotated[bool, FlagPart("with caps")]
    along: Annotated[Floats | None, direction("along")]
    profile: Annotated[TimeProfile, STEADY]
    duration: Lasting

    def flaw(self, network: Network) -> str:
        """Return the reason why nothing can be pressed; empty if it can be."""
        from tissuec.forces.enclosed.pressed_sides import NoSide

        try:
            self.made(network, "", self.profile)
        except NoSide as error:
            return Flaw(str(error), error.hint)
        return ""

    def made(self, network: Network, key: str, profile: TimeProfile) -> "SurfacePressure":
        """Return the pressure on the surface.

        Args:
            key: Name of its block.
            profile: Of the pressure.

        Raises:
            NoSide: There is no surface, or the direction of the push is not known.
        """
        from tissuec.forces.enclosed.pressed_sides import Pressed, closed_by_caps, pressed_faces
        from tissuec.forces.enclosed.pressure import SurfacePressure

        group = self.group
        pressed = Pressed(group.name, group.indices, self.is_inside, self.along)
        faces = pressed_faces(network, pressed)
        if self.has_caps:
            closed_by_caps(network, group.name, faces)
        return SurfacePressure.of(
            key, self.group.name, faces, self.amount, profile, self.span, has_caps=self.has_caps
        )

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        (profile,), stop = schedule(queue, (self.profile,), state.time, self.duration)
        what = f"the pressure on {self.group.name}"
        name = free_name(what, state.blocks, state.time, stop)
        made = self.made(state.network, name, profile)
        put_as_drawn(state, made.block)
        if self.duration is not None:
            queue.add(stop, EndActing((made.key,), self.span))
        return (LoggedEvent("press", (), sentence(self.span), self.span),)


class PressInside(Press, frozen=True):
    """A pressure on the surface of the space within a body."""

    is_inside: ClassVar[bool] = True

    group: Annotated[Group, SubjectPart("nodes", (BODY,), "of", what="body")]


@VERBS.member("press")
class PressVerb:
    """Applies a pressure to a surface, for the interval or until ``stop pressing``.

    The pressure always acts normal to the faces as they move. It pushes a wall outwards, from
    the space that the wall encloses. It pushes a solid from outside, on all of its skin;
    ``inside of`` a solid is the part of its skin that faces a space within, such as the lumen
    of a thick tube. A wall that encloses nothing, such as a sheet, needs the direction
    ``along`` which it is pushed. For a set, the pressure acts on the surface triangles all of
    whose corners are in the set.

    The pressure is relative to that on the other side, and may be negative. It is
    constant or follows the profile after ``using``. Pressures on one surface add up. With
    caps, each open end is closed by a light plug that passes the force of the pressure on to
    the rim.
    """

    meant: ClassVar[str] = "pressurise pressurize squeeze"
    cases: ClassVar = Cases("", {"": Press, "inside": PressInside}, "")
