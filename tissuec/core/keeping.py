"""Results that are computed once, without keeping alive what they were computed of.

``functools.lru_cache`` would hold whole nets that nobody else needs any more.
"""

from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
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
