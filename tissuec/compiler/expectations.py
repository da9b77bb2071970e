"""Separates expectations about a run from those about learning."""

from collections.abc import Sequence

from tissuec.lang import syntax as s
from tissuec.scene.learning.errors import errors_in


def split_expectations(
    expects: Sequence[s.Expect],
) -> tuple[list[s.Expect], list[s.Expect]]:
    """Return the expectations of a run, and those of learning."""
    of_learning = [item for item in expects if errors_in(item.condition)]
    return [item for item in expects if item not in of_learning], of_learning
