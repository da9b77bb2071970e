"""Workers: what applies one function to many items, somewhere.

What any worker returns depends on the item alone, so that results do not depend on who computed
them, nor on how many there are.
"""

from collections.abc import Callable, Generator, Sequence
from typing import Protocol, Self, TypeAlias, TypeVar

from tissuec.core.processors import permitted

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


def workers_of(
    count: int | None = None,
    scheduler: str | None = None,
    tell: Callable[[str], None] | None = None,
) -> Workers:
    """Return the workers that are asked for.

    Args:
        count: Number of processes; one is this process. By default one for each processor.
        scheduler: Address of a dask scheduler, instead.
        tell: Is told if a scheduler has lost all workers; a warning by default.

    Raises:
        TissueError: The scheduler cannot be used.
    """
    if scheduler is not None:
        from tissuec.workers.cluster import Cluster, warn

        return Cluster(scheduler, tell or warn)
    count = count or permitted()
    if count == 1:
        return OwnProcess()
    from tissuec.workers.processes import Processes

    return Processes(count)
