"""Functions of numbers of a graph, in place of those of ``math``."""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, Protocol, overload

from tissuec.autodiff.graph import Graph, Inequality, Number, Operand, Operation, Rule


def graph_of(*values: object) -> Graph:
    """Return the graph of the first number among values.

    Raises:
        TypeError: None is a number of a graph.
    """
    for value in values:
        if isinstance(value, Number):
            return value.graph
    raise TypeError("none of these is a number of a graph")


class _Function(Protocol):
    @overload
    def __call__(self, a: Number, /) -> Number: ...
    @overload
    def __call__(self, a: float, /) -> float: ...


def _function(name: str) -> _Function:
    of_float = getattr(math, name)

    def apply(a: Operand) -> Any:
        if not isinstance(a, Number):
            return of_float(a)
        if a.value is not None:
            with suppress(ValueError, OverflowError):  # not finite, and so left to the graph
                return a.graph.number(of_float(a.value))
        return a.graph.apply(name, a)

    apply.__name__ = name
    apply.__doc__ = f"Return {name} of a number."
    return apply


sqrt, exp, log, sin, cos = map(_function, ("sqrt", "exp", "log", "sin", "cos"))


def maximum(a: Operand, b: Operand) -> Number:
    """Return the greater one of two numbers."""
    return _extreme("maximum", max, a, b)


def minimum(a: Operand, b: Operand) -> Number:
    """Return the lesser one of two numbers."""
    return _extreme("minimum", min, a, b)


def _extreme(
    name: str, of_floats: Callable[[float, float], float], a: Operand, b: Operand
) -> Number:
    graph = graph_of(a, b)
    one, other = graph.number(a), graph.number(b)
    if one.value is not None and other.value is not None:
        return graph.number(of_floats(one.value, other.value))
    return one if one == other else graph.apply(name, one, other)


def where(condition: Inequality, one: Operand, other: Operand) -> Number:
    """Return one number where a condition holds, and another one where not.

    Both are computed everywhere. Where one of them or its derivative is not finite, clamp its
    arguments, such as by ``maximum``.
    """
    graph = condition.graph
    first, second = graph.number(one), graph.number(other)
    return first if first == second else graph.apply("where", condition, first, second)


def ruled(value: Number, arguments: Sequence[Number], rule: Rule) -> Number:
    """Return a value with derivatives of its own, in place of those of its formula.

    For a singularity that can be removed, a form that keeps more digits, or a result of an
    iteration.

    Args:
        arguments: What the value depends on.
        rule: Takes the value and the arguments, and returns the derivatives by these, which
            have derivatives themselves. It is one function for all calls, not made anew.
    """
    places = (value.place, *(each.place for each in arguments))
    return value.graph.record(Operation("ruled", places, rule))


def in_arrays(function: Callable[..., Any], arguments: Sequence[Number]) -> Number:
    """Return a value that only NumPy computes, such as an energy that no kernel needs.

    Args:
        function: Takes arrays, and returns one of their shape. It is one for all calls.
        arguments: What it is of.
    """
    places = tuple(each.place for each in arguments)
    return arguments[0].graph.record(Operation("array", places, function))
