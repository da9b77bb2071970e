"""Bodies that are inflated, but whose volume nothing preserves before."""

from collections.abc import Iterator, Sequence

from tissuec.core.errors import Diagnostic
from tissuec.script.plan import ScheduledAction, Trigger
from tissuec.script.verbs.preserve import Inflate, Preserve


def check_inflations(
    events: Sequence[ScheduledAction], triggers: Sequence[Trigger]
) -> Iterator[Diagnostic]:
    """Reject inflations of bodies whose volume no earlier action preserves.

    Args:
        events: In the order in which they happen.
        triggers: Conditions, which may preserve a volume at any time.
    """
    late = [event.action for trigger in triggers for event in trigger.events]
    preserved = {action.group.name for action in late if isinstance(action, Preserve)}
    for action in (*(event.action for event in events), *late):
        if not isinstance(action, Preserve | Inflate):
            continue
        name = action.group.name
        if isinstance(action, Inflate) and name not in preserved:
            yield Diagnostic(
                "TIS309",
                f"{name} cannot be inflated: nothing preserves its volume before",
                action.span,
                f"add an earlier action: preserve volume of {name} with 10 kPa",
            )
        preserved.add(name)  # or else it was reported, once
