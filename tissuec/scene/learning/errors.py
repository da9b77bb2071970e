"""Errors of learning in conditions: ``expect error(held out) < 8 %``."""

from tissuec.lang import syntax as s
from tissuec.lang.walk import walk

ERROR = "error"


def errors_in(node: s.Expression) -> list[s.Call]:
    """Return the places where a condition uses an error of learning."""
    calls = (part for part in walk(node) if isinstance(part, s.Call))
    return [call for call in calls if call.function.key == ERROR]
