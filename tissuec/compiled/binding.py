"""Binding: the same stepping code over other operations.

A function of ours is copied with some of its global names replaced; so are the functions it
calls.
"""

from collections.abc import Callable, Mapping
from dis import get_instructions
from types import FunctionType
from typing import Any

Function = Callable[..., Any]


class Binder:
    """Copies functions together with the functions that they call.

    Args:
        replaced: Global names and what they shall mean: functions (bound in turn) or constants.
        made: What becomes of a copy that others call; it stays what it is unless given.
    """

    def __init__(
        self,
        replaced: Mapping[str, Any],
        made: Callable[[FunctionType], Function] = lambda function: function,
    ):
        self._replaced, self._made = replaced, made
        self._copies: dict[Function, tuple[FunctionType, frozenset[str]]] = {}
        self._parts: dict[Function, Function] = {}

    def bind(self, function: Function) -> FunctionType:
        """Return a copy of a function under the replaced names."""
        return self._copy(function)[0]

    def names(self, function: Function) -> frozenset[str]:
        """Return which of the replaced names a function uses, directly or not."""
        return self._copy(function)[1]

    @property
    def copied(self) -> frozenset[Function]:
        """Return the functions that were bound, with those that they call."""
        return frozenset(self._copies)

    def _copy(self, function: Function) -> tuple[FunctionType, frozenset[str]]:
        """Return the copy and which replacements it depends on, directly or not."""
        if function in self._copies:
            return self._copies[function]
        assert isinstance(function, FunctionType)
        names = dict(function.__globals__)
        depends: set[str] = set()
        for name in _globals_of(function):
            if name in self._replaced:
                names[name] = self._replaced[name]
                depends.add(name)
            value = names.get(name)
            if isinstance(value, FunctionType) and value.__module__.startswith("tissuec."):
                copy, further = self._copy(value)
                if value not in self._parts:
                    self._parts[value] = self._made(copy)
                names[name] = self._parts[value]
                depends |= further
        copy = FunctionType(function.__code__, names, function.__name__)
        copy.__module__ = function.__module__
        self._copies[function] = copy, frozenset(depends)
        return self._copies[function]


def _globals_of(function: FunctionType) -> list[str]:
    """Return the names that a function loads from its module, in order of appearance."""
    found = (i.argval for i in get_instructions(function) if i.opname == "LOAD_GLOBAL")
    return list(dict.fromkeys(found))
