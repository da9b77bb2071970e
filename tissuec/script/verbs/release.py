"""``release``: the end of a hold or of a grip."""

from typing import Annotated, ClassVar

from tissuec.mechanics.state import State
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Moved, ToolClause
from tissuec.script.verbs import VERBS, Action, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import FIX, Released, gripped, let_go, sentence


@VERBS.member("release")
class Release(VerbSentence, frozen=True):
    """Releases the nodes of a set, or all nodes that a tool holds.

    ``release SET from TOOL`` releases the set from this tool only, ``release SET`` from
    everything that holds it. Released nodes keep their velocity: a node at rest starts from
    rest, and a node on a path continues with the velocity of the path. Fixed nodes stay fixed
    (``free`` releases them). Releasing nodes that are not held has no effect.
    """

    meant: ClassVar[str] = "drop ungrasp unclamp"

    released: Moved  # of a tool: all that it holds
    holder: Annotated[
        str | None, ToolClause("from", "grasping", what="tool")
    ]  # None: whatever holds it

    def action(self, order: Order) -> Action:
        if self.group is None and self.holder is not None:
            order.reject(
                "TIS306",
                f'"{self.released.name}" is a tool and cannot be released from one',
                hint="write: release SET from TOOL, or: release TOOL",
                word="from",
            )
        return self

    @property
    def group(self) -> Group | None:
        """The released nodes; None for all that the tool holds."""
        name, nodes = self.released.name, self.released.nodes
        return None if nodes is None else Group(name, nodes)

    @property
    def tool(self) -> str | None:
        """The tool that releases them; None for everything that holds them."""
        return self.released.name if self.released.nodes is None else self.holder

    def holding(self) -> Released:
        return Released(self.group, self.tool)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        group = self.group
        nodes = gripped(state, self.released.name) if group is None else group.indices
        text = sentence(self.span)
        if not len(let_go(state, nodes, self._concerns)):
            if group is not None and state.hold_ends.get(group.name) == state.time:
                return ()
            return (LoggedEvent("note", (), f"{text}: no longer held", self.span),)
        return (LoggedEvent("release", (), text, self.span),)

    def _concerns(self, holder: str) -> bool:
        return holder != FIX if self.tool is None else holder == self.tool
