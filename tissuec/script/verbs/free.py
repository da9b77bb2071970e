"""``free``: the end of every hold."""

from typing import ClassVar

from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Nodes
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import Freed, let_go, sentence


@VERBS.member("free")
class Free(VerbSentence, frozen=True):
    """Ends every hold on nodes, whether they are fixed, held, grasped or moved.

    Nodes that were moved along a path continue with the velocity of the path.
    """

    meant: ClassVar[str] = "unfix detach unpin"

    group: Nodes

    def holding(self) -> Freed:
        return Freed(self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        text = sentence(self.span)
        if not len(let_go(state, self.group.indices, lambda holder: True)):
            return (LoggedEvent("note", (), f"{text}: not held", self.span),)
        return (LoggedEvent("free", (), text, self.span),)
