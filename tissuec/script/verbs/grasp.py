"""``grasp``: a tool takes hold of nodes."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.tools import grasping
from tissuec.script.verbs import VERBS, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import Taken, sentence, take
from tissuec.script.verbs.motion import joined


@VERBS.member("grasp")
class Grasp(Struct, frozen=True):
    """Takes nodes into the rigid grip of a tool, in addition to those that it already holds.

    The tool must be forceps, a clamp or a needle. Moving nodes stop; if the tool is moving,
    they move with it from now on.
    """

    forms: ClassVar[tuple[str, ...]] = ("grasp SET with TOOL",)
    group: Group
    tool: str
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        tool = order.tool("with", kinds=grasping())
        if tool is None:
            order.reject("TIS304", '"grasp" needs a tool', hint="write: grasp SET with TOOL")
        return cls(order.nodes(), tool, order.span)

    def holding(self) -> Taken:
        return Taken(self.tool, self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        motion = state.motions.get(self.tool)
        take(state, self.tool, self.group.indices)
        if motion is not None:
            state.motions[self.tool] = joined(motion, state, self.group.indices)
            state.place_held()
        return (LoggedEvent("grasp", (), sentence(self.span), self.span),)
