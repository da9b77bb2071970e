"""``end the run``: nothing happens any more after this time."""

from typing import ClassVar, Self

from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent, Order
from tissuec.script.verbs.holding import sentence

OBJECT = "the run"
#: Of the event; "end" is that of the end of a motion.
KIND = "end the run"


@VERBS.member("end")
class End(Struct, frozen=True):
    """Ends the run at this time, after all other events of this time.

    With ``when``, a run ends as soon as a condition is true: ``when count(pieces of vessel) >
    1: end the run``. The summary and the event log show this sentence. Expectations over an
    interval are evaluated up to this time; expectations about later times are not reached.
    """

    forms: ClassVar[tuple[str, ...]] = ("end the run",)
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        if order.words.lower() != OBJECT:
            order.reject("TIS404", "only the run can be ended")
        return cls(order.span)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        ended = LoggedEvent(KIND, (), sentence(self.span), self.span)
        queue.end(ended)
        return (ended,)


def without_end(plan: Plan) -> Plan:
    """Return a plan whose run lasts for its whole duration, whatever happens."""

    def others(events: tuple[ScheduledAction, ...]) -> tuple[ScheduledAction, ...]:
        return tuple(event for event in events if not isinstance(event.action, End))

    triggers = tuple(replace(one, events=others(one.events)) for one in plan.triggers)
    return replace(plan, events=others(plan.events), triggers=triggers)
