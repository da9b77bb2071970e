"""Traversal of expressions.

An expression may be as long as the text, so nothing here recurs.
"""

from collections.abc import Callable, Iterator
from typing import Any

from tissuec.core.source import Span
from tissuec.lang.syntax import Applied, Call, Name, Node


def walk(node: Any, *, enters: Callable[[Call], bool] = lambda call: True) -> Iterator[Any]:
    """Yield every node inside a node or a tuple of nodes, outer ones and left ones first.

    The names of functions are left out.

    Args:
        enters: Whether to visit the arguments of a call.
    """
    waiting: list[Node | Span | tuple[Any, ...] | str | float | None] = [node]
    while waiting:
        match waiting.pop():
            case tuple() as parts:
                waiting.extend(reversed(parts))
            case Span():
                pass
            case Call() as call:
                yield call
                if enters(call):
                    waiting.append(call.arguments)
            case Applied() as applied:
                yield applied
                waiting += applied.value, applied.arguments
            case Node() as part:
                yield part
                waiting.extend(getattr(part, name) for name in reversed(part.__struct_fields__))
            case _:
                pass


def names_in(node: Any) -> Iterator[Name]:
    """Yield every name inside a node or a tuple of nodes, but those of functions."""
    return (part for part in walk(node) if isinstance(part, Name))


def is_number(node: Any) -> bool:
    """Return whether an expression is written in numbers alone, without names and functions."""
    return not any(isinstance(part, Name | Call | Applied) for part in walk(node))
