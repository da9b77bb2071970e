"""``end the run``: nothing happens any more after this time."""

from typing import ClassVar

from tissuec.core.structs import replace
from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Cases
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import sentence

#: Of the event; "end" is that of the end of a motion.
KIND = "end the run"


class End(VerbSentence, frozen=True):
    """The end of the run."""

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        ended = LoggedEvent(KIND, (), sentence(self.span), self.span)
        queue.end(ended)
        return (ended,)


@VERBS.member("end")
class EndVerb:
    """Ends the run at this time, after all other events of this time.

    With ``when``, a run ends as soon as a condition is true: ``when count(pieces of vessel) >
    1: end the run``. The summary and the event log show this sentence. Expectations over an
    interval are evaluated up to this time. Expectations about later times cannot be checked:
    they are reported as not reached, with exit code 1. The last sample of each log, and the
    last frame, show the state at this time.
    """

    meant: ClassVar[str] = "finish quit exit"
    cases: ClassVar = Cases("", {"the run": End}, "only the run can be ended", "TIS404")


def without_end(plan: Plan) -> Plan:
    """Return a plan whose run lasts for its whole duration, whatever happens."""

    def others(events: tuple[ScheduledAction, ...]) -> tuple[ScheduledAction, ...]:
        return tuple(event for event in events if not isinstance(event.action, End))

    triggers = tuple(replace(one, events=others(one.events)) for one in plan.triggers)
    return replace(plan, events=others(plan.events), triggers=triggers)
