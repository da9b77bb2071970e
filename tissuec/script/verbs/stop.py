"""``stop``: the end of a force, of a jet or of a motion."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.verbs import VERBS, EventQueue, LoggedEvent, Order
from tissuec.script.verbs.holding import Stopped, sentence
from tissuec.script.verbs.irrigate import stop_irrigating
from tissuec.script.verbs.motion import stop_shifting, stop_turning
from tissuec.script.verbs.press import stop_pressing
from tissuec.script.verbs.push import stop_pushing

_STOPS = {
    "pushing": stop_pushing,
    "pulling": stop_pushing,
    "pressing": stop_pressing,
    "moving": stop_shifting,
    "turning": stop_turning,
    "irrigating": stop_irrigating,
}


@VERBS.member("stop")
class Stop(Struct, frozen=True):
    """Ends all forces on a set, or stops the motion or turn of a set or tool where it is.

    Whatever was moved or turned stays held. ``pushing`` and ``pulling`` mean the same. ``stop
    pressing SET`` ends the pressures that were ordered for this set or body. ``stop
    irrigating SET`` ends the jets that were ordered for this set or body, ``stop irrigating``
    all jets.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "stop pushing SET",
        "stop pulling SET",
        "stop moving SET",
        "stop moving TOOL",
        "stop turning SET",
        "stop turning TOOL",
        "stop pressing SET",
        "stop irrigating SET",
        "stop irrigating",
    )
    what: str  # such as "pushing"
    name: str  # of the set or mover; empty for all jets
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        what = (order.words.lower().split() or [""])[0]
        if what not in _STOPS:
            hint = alternatives(what, _STOPS, what="it can be")
            if not what:
                hint = f"write: {', or: '.join(cls.forms[i] for i in (0, 2, 6))}"
            if not what:
                order.reject("TIS304", "the action to stop is missing", hint=hint)
            order.reject("TIS305", f'"{what}" cannot be stopped', hint=hint)
        if what == "irrigating" == order.words.lower():
            return cls(what, "", order.span)
        is_mover = what in ("moving", "turning")
        named = order.mover(after=what) if is_mover else order.nodes(after=what)
        return cls(what, named.name, order.span)

    def holding(self) -> Stopped | None:
        return Stopped(self.name) if self.what in ("moving", "turning") else None

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        text = sentence(self.span)
        if not _STOPS[self.what](state, self.name):
            return (LoggedEvent("note", (), f"{text}: nothing to stop", self.span),)
        return (LoggedEvent("stop", (), text, self.span),)
