"""Old spellings of measures, read and written as those of conditions.

A measure is written ``force(A along (1, 0, 0))`` wherever it occurs. Outputs and studies also
read ``force of A``, and learning a direction after the parentheses; ``tissuec fmt`` writes
these as in conditions.
"""

from collections.abc import Iterator, Sequence
from typing import TypeVar

from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.script.measures import MEASURES

T = TypeVar("T", bound=s.Item)

#: What turns a measure over time into a number: ``max(force(right))``.
AGGREGATES = {
    "max": "the largest value",
    "min": "the smallest value",
    "mean": "the mean over time",
    "first": "the value at the start",
    "last": "the value at the end",
    "slope": "the slope of the line that fits the first best over the second",
}
SLOPE = "slope"


def form_over_time(aggregate: str) -> str:
    """Return how a number from values over time is written."""
    return "slope(MEASURE, MEASURE)" if aggregate == SLOPE else f"{aggregate}(MEASURE)"


#: Measures that are counted: ``count(nodes of A)``.
COUNT, COUNTED = "count", ("nodes", "springs", "elements", "pieces")


def respelled(source: Source) -> Source:
    """Return a text with measures as conditions have them.

    Raises:
        CompileError: The text has mistakes.
    """
    text = source.text
    calls = list(_calls(parse(source).items))
    for call in sorted(calls, key=lambda one: -one.span.start):
        text = text[: call.span.start] + _written(call) + text[call.span.end :]
    return Source(source.name, text, source.path) if calls else source


def in_parentheses(item: T) -> T | s.RecordedCall:
    """Return an output, or what a study or a learn block measures, in the present spelling.

    Args:
        item: The sentence; any other is returned as it is.
    """
    if isinstance(item, s.Sentence) and item.phrase is None:
        call = _call(item.name, item.clauses)
        if call is not None:
            return s.RecordedCall(call, _behind(call, item.clauses), item.span)
    if not isinstance(item, s.Assign):
        return item
    value, clauses = item.value, item.clauses
    match value:
        case s.Name():
            call = _call(value, clauses)
        case s.Call(function=function, arguments=(s.Argument(s.Name() as name) as only,)):
            call = None
            if function.key in AGGREGATES and (inner := _call(name, only.clauses)) is not None:
                argument = s.Argument(inner, _behind(inner, only.clauses), only.span)
                call = replace(value, arguments=(argument,))
            is_plain = function.key in MEASURES and not only.clauses
            if is_plain and clauses and (along := clauses[0]).word == "along":
                argument = replace(only, clauses=(along,))
                call = s.Call(function, (argument,), value.span.to(along.span))
        case _:
            call = None
    if call is None:
        return item
    return replace(item, value=call, clauses=_behind(call, clauses))


def _calls(items: Sequence[s.Item]) -> Iterator[s.Call]:
    """Yield the calls that are spelled otherwise in blocks."""
    for block in items:
        if isinstance(block, s.Block) and block.name.key.split(" ")[0] in _BLOCKS:
            for item in block.items:
                match in_parentheses(item):
                    case new if new is item:
                        pass
                    case s.RecordedCall(call=call) | s.Assign(value=s.Call() as call):
                        yield call
                    case _:
                        pass


_BLOCKS = ("output", "study", "learn")


def _call(name: s.Name, clauses: Sequence[s.Clause]) -> s.Call | None:
    """Return ``force of A along (1, 0, 0)`` as a call, if that is what is written."""
    if name.key not in MEASURES or not clauses or clauses[0].word != "of":
        return None
    count, words = MEASURES[name.key].subjects, [one.word for one in clauses]
    own = [one for one in clauses if one.word in ("of", "to", "along")]
    if [*clauses[: len(own)]] != own or len({one.word for one in own}) < len(own):
        return None
    arguments: list[s.Argument] = []
    for clause in own:
        if clause.word == "along":
            arguments[-1] = replace(arguments[-1], clauses=(clause,))
            continue
        value = clause.value
        is_split = isinstance(value, s.Listing) and count > 1 and "to" not in words
        parts = value.items if is_split and isinstance(value, s.Listing) else (value,)
        if s.as_name(value) is None:
            return None
        arguments += [s.Argument(part, (), part.span) for part in parts]
    if len(arguments) != count:
        return None
    function = name
    if name.key in COUNTED:
        function = s.Name(COUNT, None, name.span)
        arguments = [s.Argument(name, (own[0],), name.span.to(own[0].span))]
    return s.Call(function, tuple(arguments), name.span.to(own[-1].span))


def _behind(call: s.Call, clauses: Sequence[s.Clause]) -> tuple[s.Clause, ...]:
    """Return the clauses that are not part of a call."""
    return tuple(one for one in clauses if one.span.start >= call.span.end)


def _written(node: s.Expression) -> str:
    """Return a call in the present spelling."""
    if not isinstance(node, s.Call):
        return node.span.text
    arguments = (
        " ".join((_written(one.value), *(clause.span.text for clause in one.clauses)))
        for one in node.arguments
    )
    return f"{node.function.words}({', '.join(arguments)})"
