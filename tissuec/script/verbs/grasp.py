"""``grasp``: a tool takes hold of nodes."""

from typing import Annotated, ClassVar

from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Nodes, ToolClause
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import Taken, sentence, take
from tissuec.script.verbs.motion import joined


@VERBS.member("grasp")
class Grasp(VerbSentence, frozen=True):
    """Takes nodes into the rigid grip of a tool, in addition to those that it already holds.

    The tool must be forceps, a clamp or a needle. Moving nodes stop; if the tool is moving,
    they move with it from now on.
    """

    meant: ClassVar[str] = "clamp grip grab pinch take seize pick catch"

    group: Nodes
    tool: Annotated[str, ToolClause("with", "grasping", what="tool")]

    def holding(self) -> Taken:
        return Taken(self.tool, self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        motion = state.motions.get(self.tool)
        take(state, self.tool, self.group.indices)
        if motion is not None:
            state.motions[self.tool] = joined(motion, state, self.group.indices)
            state.place_held()
        return (LoggedEvent("grasp", (), sentence(self.span), self.span),)
