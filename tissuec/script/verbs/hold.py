"""``hold``: nodes that stay where they are for a while."""

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Lasting, Nodes
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import Taken, held_by, let_go, sentence, take


class EndHold(Struct, frozen=True):
    """The end of a hold for an interval, unless the set was held again in the meantime."""

    holder: str
    time: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if state.hold_ends.get(self.holder) != self.time:
            return ()
        nodes = held_by(state, self.holder)
        let_go(state, nodes, lambda holder: holder == self.holder)
        # Kept, so that a release at the same time is known to have been obeyed already.
        state.hold_ends[self.holder] = self.time
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("hold")
class Hold(VerbSentence, frozen=True):
    """Holds nodes where they are, for the interval or until ``release`` or ``free``.

    It ends motions of these nodes. A later ``hold`` or ``move`` of the same set replaces it.
    """

    group: Nodes
    duration: Lasting

    def holding(self) -> Taken:
        return Taken(self.group.name, self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        take(state, self.group.name, self.group.indices)
        state.hold_ends.pop(self.group.name, None)
        if self.duration is not None:
            end = state.time + self.duration
            state.hold_ends[self.group.name] = end
            queue.add(end, EndHold(self.group.name, end, self.span))
        return (LoggedEvent("hold", (), sentence(self.span), self.span),)
