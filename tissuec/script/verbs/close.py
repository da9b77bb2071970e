"""``close``: jaws that move towards each other."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent, Order
from tissuec.script.verbs.jaws import drive_jaws, flaw_of_jaws, read_jaws


@VERBS.member("close")
class Close(Struct, frozen=True):
    """Closes the jaws of forceps by a length, half of it each, across both.

    The forceps must not be moved as a whole at the same time. What lies between the jaws is
    held by friction only, as long as that bears; the forces on them are those of contact.
    """

    forms: ClassVar[tuple[str, ...]] = ("close TOOL by LENGTH using PROFILE",)
    tool: str
    way: float  # [m]
    profile: TimeProfile
    duration: float | None  # [s]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        return cls(*read_jaws(order), order.duration, order.span)

    def flaw(self, network: Network) -> str:
        """Return why these forceps cannot close, empty if they can."""
        return flaw_of_jaws(network, self.tool)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        way = -self.way
        return tuple(
            drive_jaws(state, queue, self.tool, way, self.profile, self.duration, self.span)
        )
