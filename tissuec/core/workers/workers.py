"""Workers: what applies one function to many items, somewhere; how many processors there are.

What any worker returns depends on the item alone, so that results do not depend on who computed
them, nor on how many there are.
"""

import os
from collections.abc import Callable, Generator, Sequence
from threading import local
from typing import Generic, Protocol, Self, TypeAlias, TypeVar

Common = TypeVar("Common")
Item = TypeVar("Item")
Result = TypeVar("Result")
#: A function of a module, of what all calls share and an item.
Work: TypeAlias = Callable[[Common, Item], Result]


class Lost:
    """In the place of a result: the worker died, and so did one with this item alone."""


LOST = Lost()


class Workers(Protocol):
    """What applies a function to many items; use it in a ``with`` statement."""

    def map(
        self, work: Work[Common, Item, Result], common: Common, items: Sequence[Item]
    ) -> Generator[tuple[int, Result | Lost], None, None]:
        """Yield the number of each item with its result, as they come.

        Args:
            work: Takes ``common`` and an item; a function of a module.
            common: What all calls share; pickled once.
            items: They are pickled.

        Raises:
            TissueError: No worker can be reached.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *failure: object) -> None: ...


class OwnProcess:
    """Does one item after the other in this process."""

    def map(
        self, work: Work[Common, Item, Result], common: Common, items: Sequence[Item]
    ) -> Generator[tuple[int, Result | Lost], None, None]:
        """Yield the number of each item with its result; see `Workers`."""
        for number, item in enumerate(items):
            yield number, work(common, item)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None: ...


class CommonCache(local, Generic[Common, Result]):
    """What a thread of a worker has made of the last common argument of its calls.

    Args:
        make: Makes it.
    """

    def __init__(self, make: Callable[[Common], Result]):
        self._make = make
        self._made: tuple[Common, Result] | None = None

    def of(self, common: Common) -> Result:
        """Return the result for an argument; recomputed if it is another object."""
        if self._made is None or self._made[0] is not common:
            self._made = common, self._make(common)
        return self._made[1]


def permitted() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
