"""Separates expectations about a run from those about learning."""

from collections.abc import Sequence

from tissuec.lang import syntax as s
from tissuec.lang.walk import walk

ERROR = "error"


def errors_in(node: s.Expression) -> list[s.Call]:
    """Return where a condition asks for the error of a learning."""
    calls = (part for part in walk(node) if isinstance(part, s.Call))
    return [call for call in calls if call.function.key == ERROR]


def split_expectations(
    expects: Sequence[s.Expect],
) -> tuple[list[s.Expect], list[s.Expect]]:
    """Return the expectations of a run, and those of learning."""
    of_learning = [item for item in expects if errors_in(item.condition)]
    return [item for item in expects if item not in of_learning], of_learning
