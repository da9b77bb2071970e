"""Definitions that need one another, and the order in which they are worked out.

Chains of them may be as long as the text, so nothing here recurs.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Generic, TypeVar

from tissuec.lang import syntax as s
from tissuec.scene.reading.findings import Findings

T = TypeVar("T")


class Circle(Exception):
    """Definitions need one another; ``keys`` is the circle and ``name`` closes it."""

    def __init__(self, keys: Sequence[str], name: s.Name):
        self.keys = tuple(keys)
        self.name = name
        super().__init__(" -> ".join((*keys, name.key)))


def needed_first(start: str, needs: Callable[[str], Iterable[s.Name]]) -> list[str]:
    """Return the definitions that one needs, in the order of their needs, itself last.

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


class Definitions(Generic[T]):
    """Definitions of one kind by key; each is evaluated once, on first use.

    Args:
        what: What they are called in messages, such as "numbers".
        needs: Gives the names in a definition that are definitions too.
        work_out: Returns the value of a definition, or rejects it.
    """

    def __init__(
        self,
        what: str,
        needs: Callable[[str], Iterable[s.Name]],
        work_out: Callable[[str], T],
        findings: Findings,
    ):
        self.what = what
        self.needs = needs
        self.work_out = work_out
        self.findings = findings
        self.values: dict[str, T | None] = {}  # None if it was rejected

    def find(self, key: str) -> T:
        """Return the value of a definition; rejects the item that uses a wrong one."""
        if key not in self.values:
            self._work_out_with_needs(key)
        value = self.values[key]
        if value is None:
            self.findings.stop()
        return value

    def _work_out_with_needs(self, wanted: str) -> None:
        try:
            order = needed_first(wanted, self._open_needs)
        except Circle as circle:
            self.values.update(dict.fromkeys(circle.keys))
            message = f"circular definition of {self.what}: {circle}"
            self.findings.reject("TIS506", message, circle.name.span)
        for key in order:
            self.values[key] = None
            with self.findings.item():
                self.values[key] = self.work_out(key)

    def _open_needs(self, key: str) -> Iterator[s.Name]:
        return (name for name in self.needs(key) if name.key not in self.values)
