"""A bounded cache of results of pure functions."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import RLock
from typing import Any, TypeVar

T = TypeVar("T")


class Memory:
    """Results by their keys; the least recently used one is dropped first. Thread-safe."""

    def __init__(self, most: int):
        self.most = most
        self._found: OrderedDict[Hashable, Any] = OrderedDict()
        self._lock = RLock()

    def get(self, key: Hashable) -> Any:
        """Return the result of a key; None if there is none."""
        with self._lock:
            if key not in self._found:
                return None
            self._found.move_to_end(key)
            return self._found[key]

    def keep(self, key: Hashable, made: object) -> None:
        """Store a result, and drop the least recently used ones above the limit."""
        with self._lock:
            self._found[key] = made
            self._found.move_to_end(key)
            while len(self._found) > self.most:
                self._found.popitem(last=False)

    def recall(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return the result of a key, computed now if it is not stored."""
        with self._lock:
            if key in self._found:
                return self.get(key)
        made = make()
        self.keep(key, made)
        return made
