"""``stop``: the end of a force or of a motion."""

from dataclasses import dataclass
from typing import ClassVar, Self

from tissuec.core.errors import alternatives
from tissuec.core.source import Span
from tissuec.situation import Situation
from tissuec.verbs import VERBS, Agenda, Happening, Order
from tissuec.verbs.holding import sentence
from tissuec.verbs.motion import stop_shifting, stop_turning
from tissuec.verbs.push import stop_pushing

_STOPS = {
    "pushing": stop_pushing,
    "pulling": stop_pushing,
    "moving": stop_shifting,
    "turning": stop_turning,
}


@VERBS.member("stop")
@dataclass(frozen=True, slots=True)
class Stop:
    """Ends every force on a set, or freezes the motion or the turn of a mover where it is.

    What was moved or turned stays held. ``pushing`` and ``pulling`` mean the same.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "stop pushing SET",
        "stop pulling SET",
        "stop moving SET",
        "stop moving TOOL",
        "stop turning SET",
        "stop turning TOOL",
    )
    what: str  # such as "pushing"
    name: str  # of the set or mover
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        what = (order.words.lower().split() or [""])[0]
        if what not in _STOPS:
            hint = alternatives(what, _STOPS, what="it can be")
            order.reject("TIS305", f'"{what}" is nothing that can be stopped', hint=hint)
        is_force = _STOPS[what] is stop_pushing
        named = order.nodes(after=what) if is_force else order.mover(after=what)
        return cls(what, named.name, order.span)

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        text = sentence(self.span)
        if not _STOPS[self.what](situation, self.name):
            return (Happening("note", (), f"{text}: there is nothing to stop", self.span),)
        return (Happening("stop", (), text, self.span),)
