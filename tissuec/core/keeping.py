"""Results that are computed once: of functions, and of owners that are not kept alive.

``functools.lru_cache`` would hold whole nets that nobody else needs any more.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock, RLock
from typing import Any, Concatenate, ParamSpec, TypeVar

Owner = TypeVar("Owner")
P = ParamSpec("P")
Result = TypeVar("Result")
_lock = Lock()


def kept_on_owner(
    most: int,
) -> Callable[
    [Callable[Concatenate[Owner, P], Result]], Callable[Concatenate[Owner, P], Result]
]:
    """Keep results of a function on its first argument, so that they go along with it.

    Args:
        most: How many results one owner keeps, the latest ones. It has a ``__dict__``, and the
            other arguments of the function can be hashed.
    """

    def decorate(
        function: Callable[Concatenate[Owner, P], Result],
    ) -> Callable[Concatenate[Owner, P], Result]:
        name = f"{function.__module__}.{function.__qualname__}"

        @wraps(function)
        def recall(owner: Owner, *rest: P.args, **named: P.kwargs) -> Result:
            results: dict[Any, Result] = vars(owner).setdefault(name, {})
            return _recalled(results, rest, lambda: function(owner, *rest, **named), most)

        return recall

    return decorate


def kept_by(
    key: Callable[[Owner], Hashable], most: int
) -> Callable[[Callable[[Owner], Result]], Callable[[Owner], Result]]:
    """Keep results of a function of one argument by a key of it, but not the argument.

    Args:
        key: Returns what is equal where results are.
        most: How many results are kept, the latest ones.
    """

    def decorate(function: Callable[[Owner], Result]) -> Callable[[Owner], Result]:
        results: dict[Any, Result] = {}

        @wraps(function)
        def recall(owner: Owner) -> Result:
            return _recalled(results, key(owner), lambda: function(owner), most)

        return recall

    return decorate


def _recalled(
    results: dict[Any, Result], key: Hashable, compute: Callable[[], Result], most: int
) -> Result:
    """Return a result that is there, or compute and add it; threads may do so at once."""
    with _lock:
        if key in results:
            return results[key]
    result = compute()
    with _lock:
        while len(results) >= most:
            del results[next(iter(results))]
        results[key] = result
    return result


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
