"""``fix``: nodes that stay where they are until they are freed."""

from typing import ClassVar

from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Nodes
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import FIX, Fixed, sentence, take


@VERBS.member("fix")
class Fix(VerbSentence, frozen=True):
    """Holds nodes in place from this time on; only ``free`` ends this.

    Moving nodes stop where they are.
    """

    meant: ClassVar[str] = "pin anchor constrain immobilise immobilize clip"

    group: Nodes

    def holding(self) -> Fixed:
        return Fixed(self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        take(state, FIX, self.group.indices)
        return (LoggedEvent("fix", (), sentence(self.span), self.span),)
