"""``release``: the end of a hold or of a grip."""

from typing import ClassVar, Self

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.tools import grasping
from tissuec.script.verbs import VERBS, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import FIX, Released, gripped, let_go, sentence


@VERBS.member("release")
class Release(Struct, frozen=True):
    """Releases the nodes of a set, or all nodes that a tool holds.

    ``release SET from TOOL`` releases the set from this tool only, ``release SET`` from
    everything that holds it. Released nodes keep their velocity: a node at rest starts from
    rest, and a node on a path continues with the velocity of the path. Fixed nodes stay fixed
    (``free`` releases them). Releasing nodes that are not held has no effect.
    """

    forms: ClassVar[tuple[str, ...]] = ("release SET", "release SET from TOOL", "release TOOL")
    group: Group | None  # None: everything that the tool holds
    tool: str | None  # None: whoever holds it
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        if not order.is_tool():
            return cls(order.nodes(), order.tool("from", kinds=grasping()), order.span)
        if order.has("from"):
            order.reject(
                "TIS306",
                f'"{order.words}" is a tool and cannot be released from one',
                hint="write: release SET from TOOL, or: release TOOL",
                word="from",
            )
        return cls(None, order.mover().name, order.span)

    def holding(self) -> Released:
        return Released(self.group, self.tool)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        nodes = gripped(state, self.tool or "") if self.group is None else self.group.indices
        text = sentence(self.span)
        if not len(let_go(state, nodes, self._concerns)):
            if self.group and state.hold_ends.get(self.group.name) == state.time:
                return ()
            return (LoggedEvent("note", (), f"{text}: no longer held", self.span),)
        return (LoggedEvent("release", (), text, self.span),)

    def _concerns(self, holder: str) -> bool:
        return holder != FIX if self.tool is None else holder == self.tool
