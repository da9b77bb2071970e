"""``settle``: nodes that go to their equilibrium at once."""

from typing import ClassVar, Self

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.verbs import VERBS, ActionFailed, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.holding import sentence


@VERBS.member("settle")
class Settle(Struct, frozen=True):
    """Moves nodes, of a set or of everything, to static equilibrium, where all forces balance.

    Forces are those of this moment: springs, weight, pressure, tools and pushes;
    dashpots and friction do not act. Held and driven nodes stay, and so does whatever is not
    named. No time passes, and nothing breaks on the way; what is under too much tension then,
    breaks right after. Relaxing branches have given way for good, and rest lengths stay as they
    have flowed; what is above its yield force flows on right after. The event log notes where
    the net buckled, and where it could move without any force. What nothing holds keeps its
    centre of mass, and its orientation unless loads turn it; under a weight it has no
    equilibrium, and the run ends.
    """

    forms: ClassVar[tuple[str, ...]] = ("settle", "settle SET")
    group: Group | None  # None for all nodes
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        if order.duration is not None:
            order.reject("TIS403", "settle cannot have an interval", hint="write: at T: settle")
        return cls(order.nodes() if order.words else None, order.span)

    def chosen(self, state: State) -> np.ndarray:
        """Return which nodes may move unless they are held, without a unit, shape (node,)."""
        count = state.network.node_count
        if self.group is None:
            return np.ones(count, dtype=bool)
        return np.isin(np.arange(count), self.group.indices)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Move the nodes to equilibrium.

        Raises:
            ActionFailed: There is no equilibrium, or none was found.
        """
        from tissuec.mechanics.settling import (
            Unsettled,
            settle,
        )  # SciPy: only where it is needed

        text = sentence(self.span)
        state.place_held()
        try:
            remarks = settle(state, self.chosen(state))
        except Unsettled as failure:
            raise ActionFailed(
                f"{text}: {failure.message}", failure.node, self.span
            ) from failure
        ids = state.network.node_ids
        above = ("" if r.node is None else f", above all node {ids[r.node]}" for r in remarks)
        notes = tuple(
            LoggedEvent("note", (), f"{text}: {r.message}{node}", self.span)
            for r, node in zip(remarks, above, strict=True)
        )
        return (LoggedEvent("settle", (), text, self.span), *notes)
