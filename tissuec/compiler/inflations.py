"""Bodies that are inflated, but whose volume nothing preserves before."""

from collections.abc import Iterator, Sequence

from tissuec.core.errors import Diagnostic
from tissuec.script.plan import ScheduledAction, Trigger
from tissuec.script.verbs.preserve import Inflate, Preserve


def check_inflations(
    events: Sequence[ScheduledAction], triggers: Sequence[Trigger]
) -> Iterator[Diagnostic]:
    """Yield what is inflated although no earlier action preserves its volume.

    Args:
        events: In the order in which they happen.
        triggers: Conditions, which may preserve a volume at any time.
    """
    late = [event.action for trigger in triggers for event in trigger.events]
    preserved = {action.group.name for action in late if isinstance(action, Preserve)}
    for action in (event.action for event in events):
        if isinstance(action, Preserve):
            preserved.add(action.group.name)
        elif isinstance(action, Inflate):
            yield from _unpreserved(action, preserved)
    for action in late:
        if isinstance(action, Inflate):
            yield from _unpreserved(action, preserved)


def _unpreserved(action: Inflate, preserved: set[str]) -> Iterator[Diagnostic]:
    name = action.group.name
    if name not in preserved:
        yield Diagnostic(
            "TIS309",
            f"{name} cannot be inflated: nothing preserves its volume before",
            action.span,
            f"write before: preserve volume of {name} with 10 kPa",
        )
        preserved.add(name)  # said once
