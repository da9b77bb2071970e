"""The order in which definitions are worked out that need one another.

Chains of them may be as long as the text, so nothing here recurs.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from tissuec.core.source import Span
from tissuec.lang import syntax as s


class Circle(Exception):
    """Definitions need one another; ``keys`` is the circle and ``name`` closes it."""

    def __init__(self, keys: Sequence[str], name: s.Name):
        self.keys = tuple(keys)
        self.name = name
        super().__init__(" -> ".join((*keys, name.key)))


def needed_first(start: str, needs: Callable[[str], Iterable[s.Name]]) -> list[str]:
    """Return what a definition needs, each before what needs it, and itself last.

    Args:
        start: Key of the definition.
        needs: Gives the names in a definition that are definitions too.

    Raises:
        Circle: The definition needs itself, or something that does.
    """
    order: dict[str, None] = {}
    path = {start: iter(needs(start))}
    while path:
        key, waiting = next(reversed(path.items()))
        name = next(waiting, None)
        if name is None:
            path.pop(key)
            order[key] = None
        elif name.key in path:
            keys = list(path)
            raise Circle(keys[keys.index(name.key) :], name)
        elif name.key not in order:
            path[name.key] = iter(needs(name.key))
    return list(order)


def names_in(node: Any) -> Iterator[s.Name]:
    """Yield every name in an expression, but those of functions."""
    waiting = [node]
    while waiting:
        match waiting.pop():
            case s.Name() as name:
                yield name
            case tuple() as parts:
                waiting.extend(parts)
            case s.Call(arguments=arguments):
                waiting.extend(arguments)
            case Span():
                pass
            case part if is_dataclass(part):
                waiting.extend(getattr(part, field.name) for field in fields(part))
