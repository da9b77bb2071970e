"""``free``: the end of every hold."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.situation import Situation
from tissuec.script.verbs import VERBS, Agenda, Group, Happening, Order
from tissuec.script.verbs.holding import let_go, sentence


@VERBS.member("free")
class Free(Struct, frozen=True):
    """Ends every hold on nodes: fixed, held, grasped or driven, they move freely from now on.

    What was driven along a path flies on with the velocity of that path.
    """

    forms: ClassVar[tuple[str, ...]] = ("free SET",)
    group: Group
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        return cls(order.nodes(), order.span)

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        text = sentence(self.span)
        if not len(let_go(situation, self.group.indices, lambda holder: True)):
            return (Happening("note", (), f"{text}: nobody holds it", self.span),)
        return (Happening("free", (), text, self.span),)
