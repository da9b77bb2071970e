"""Ranges that were read as something else: ``5-6 kPa`` as a difference, ``5 to 6 kPa``."""

from tissuec.core.hints import Hint
from tissuec.lang import syntax as s
from tissuec.lang.ranges import MESSAGE, one_of
from tissuec.scene.reading.findings import Findings


def difference(node: s.Expression) -> Hint | None:
    """Return the hint about a difference of two written numbers that can be a range."""
    match node:
        case s.Sum(first=s.Number() | s.Quantity() as low, rest=(("-", s.Quantity() as high),)):
            return one_of(low.span.text, high.span.text, node.span)
        case _:
            return None


def refuse_range(item: s.Assign, findings: Findings) -> None:
    """Reject ``NAME = 5 to 6 kPa``."""
    if [clause.word for clause in item.clauses] != ["to"]:
        return
    low, high = item.value.span, item.clauses[0].value.span
    place = low.to(high)
    findings.reject("TIS312", MESSAGE, place, hint=one_of(low.text, high.text, place))
