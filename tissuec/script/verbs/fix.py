"""``fix``: nodes that stay where they are until they are freed."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.verbs import VERBS, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import FIX, Fixed, sentence, take


@VERBS.member("fix")
class Fix(Struct, frozen=True):
    """Holds nodes in place from this time on; only ``free`` ends this.

    Moving nodes stop where they are.
    """

    forms: ClassVar[tuple[str, ...]] = ("fix SET",)
    group: Group
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        return cls(order.nodes(), order.span)

    def holding(self) -> Fixed:
        return Fixed(self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        take(state, FIX, self.group.indices)
        return (LoggedEvent("fix", (), sentence(self.span), self.span),)
