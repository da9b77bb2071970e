"""What a worker makes once of what all its calls share."""

from collections.abc import Callable
from threading import local
from typing import Generic

from tissuec.workers.workers import Common, Result


class Kept(local, Generic[Common, Result]):
    """What a thread of a worker has made of the last common argument of its calls.

    Args:
        make: Makes it.
    """

    def __init__(self, make: Callable[[Common], Result]):
        self._make = make
        self._made: tuple[Common, Result] | None = None

    def of(self, common: Common) -> Result:
        """Return what is made of an argument; made anew if it is another object."""
        if self._made is None or self._made[0] is not common:
            self._made = common, self._make(common)
        return self._made[1]
