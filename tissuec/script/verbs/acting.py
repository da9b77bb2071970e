"""Blocks that act for the interval of an order, or until another order stops them."""

from collections.abc import Collection

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.model.blocks import FieldBlock
from tissuec.script.verbs import EventQueue, LoggedEvent
from tissuec.script.verbs.holding import sentence

#: Between the subject of an order and its interval, in names.
FROM = " from "


class EndActing(Struct, frozen=True):
    """The end of the blocks of an order for an interval, unless they were stopped earlier.

    Attributes:
        keys: Names of the blocks.
        span: The order.
    """

    keys: tuple[str, ...]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        acting = [state.blocks[key] for key in self.keys if key in state.blocks]
        if not acting:
            return ()
        state.remove(*acting)
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


def put_as_drawn(state: State, *blocks: FieldBlock) -> None:
    """Add blocks on the drawn net, such that they also act on the parts that cuts have made."""
    if state.cut_cells is not None:
        from tissuec.mechanics.cut_effects import on_parts  # where solids are cut

        blocks = on_parts(state, blocks)
    state.put(*blocks)


def stop_acting(state: State, name: str, *, kind: str) -> bool:
    """End all blocks of a kind on a set or body; return whether there was one.

    Args:
        state: Whose blocks end.
        name: Name of the set or body.
        kind: Kind of the blocks, such as "pressure".
    """
    ended = [
        block
        for block in state.blocks.values()
        if block.kind == kind and block.field.name == name
    ]
    state.remove(*ended)
    return bool(ended)


def free_name(what: str, taken: Collection[str], start: float, stop: float) -> str:
    """Return a name that no other order has, had or will have, unless both end together.

    Args:
        what: Beginning of the name.
        taken: Names that begin with those of acting orders.
        start, stop: Interval of the order [s].
    """
    name, count = f"{what}{FROM}{start!r} s to {stop!r} s", 1
    while any(f"{one} ".startswith(f"{name} #{count} ") for one in taken):
        count += 1
    return f"{name} #{count}"
