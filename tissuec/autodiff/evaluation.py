"""Graphs evaluated by NumPy: for many states at once, and to find what is not finite."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.graph import Graph, Iteration, Number

Floats = NDArray[np.float64]

_OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "sum": np.add, "difference": np.subtract, "product": np.multiply, "quotient": np.divide,
    "negative": np.negative, "power": np.power, "sqrt": np.sqrt, "exp": np.exp, "log": np.log,
    "sin": np.sin, "cos": np.cos,
    # As compiled: the second number, unless the first one is known to be beyond it.
    "maximum": lambda a, b: np.where(np.greater(a, b), a, b),
    "minimum": lambda a, b: np.where(np.less(a, b), a, b),
    "greater": np.greater, "where": np.where, "ruled": lambda value: value,
}  # fmt: skip


def evaluate(outputs: Sequence[Number], values: Mapping[str, Any]) -> list[Floats]:
    """Return the values of outputs, in any units, shape () or that of the values of inputs.

    Args:
        outputs: Numbers of one graph.
        values: Of all inputs, by name: numbers or arrays, also complex or long ones.
    """
    found = _evaluated(outputs, values)
    return [np.asarray(1.0 * found[each.place]) for each in outputs]


class FailedOperation(NamedTuple):
    """An operation whose result is not finite though its arguments are.

    Attributes:
        place: In the graph.
        text: With numbers, such as "sqrt(-1) = nan".
    """

    place: int
    text: str


def failing(outputs: Sequence[Number], values: Mapping[str, Any]) -> FailedOperation | None:
    """Return the first operation that fails, if any does.

    Args:
        outputs, values: As those of ``evaluate``.
    """
    found = _evaluated(outputs, values)
    for place, result in found.items():
        name, arguments, _ = outputs[0].graph.operations[place]
        if name == "input" or np.isfinite(result).all():
            continue
        taken = [found[each] for each in arguments if each in found]
        *given, result = np.broadcast_arrays(*taken, result)
        fails = ~np.isfinite(result)
        for each in given:
            fails &= np.isfinite(each)
        if fails.any():
            shown = ", ".join(f"{each[fails][0]:.6g}" for each in given)
            return FailedOperation(place, f"{name}({shown}) = {result[fails][0]:.6g}")
    return None


def _evaluated(
    outputs: Sequence[Number], values: Mapping[str, Any], known: Mapping[int, Any] | None = None
) -> dict[int, Any]:
    """Return the values of outputs and of all that they are made of, by their places.

    Args:
        known: Values by place, which are taken over.
    """
    found: dict[int, Any] = dict(known or {})
    places = tuple(each.place for each in outputs)
    with np.errstate(all="ignore"):
        for place, name, what, taken in _steps(outputs[0].graph, places, frozenset(found)):
            if name == "constant":
                found[place] = what
            elif name == "input":
                found[place] = values[what]
            elif name == "unknown":
                found[place] = _sought(what, {each: found[each] for each in taken})
            else:
                found[place] = what(*[found[each] for each in taken])
    return found


@lru_cache(maxsize=512)
def _steps(
    graph: Graph, outputs: tuple[int, ...], known: frozenset[int]
) -> list[tuple[int, str, Any, tuple[int, ...]]]:
    """Return the operations that lead to outputs: place, name, what is done, and with what."""
    found: list[tuple[int, str, Any, tuple[int, ...]]] = []
    for place in graph.reached([Number(graph, each) for each in outputs], known=known):
        name, _, detail = graph.operations[place]
        taken = graph.arguments_of(place, by_rules=False)
        found.append((place, name, _OPERATIONS.get(name, detail), taken))
    return found


def _sought(iteration: Iteration, known: Mapping[int, Any]) -> Any:
    """Return an unknown that is found by an iteration.

    Args:
        known: Values by place: of its start, and of all that stays the same.
    """
    names = [cast(str, each.operation.detail) for each in iteration.variables]
    following, shape = (
        (iteration.step, *iteration.following),
        np.broadcast_shapes(*(np.shape(value) for value in known.values())),
    )
    values = {
        name: np.broadcast_to(known[each.place], shape)
        for name, each in zip(names, iteration.start, strict=True)
    }
    is_open = np.ones(shape, dtype=bool)
    for _ in range(iteration.rounds):
        found = _evaluated(following, values, known)
        step, *after = (found[each.place] for each in following)
        for name, value in zip(names, after, strict=True):
            values[name] = np.where(is_open, value, values[name])
        is_open = is_open & (np.abs(step) >= iteration.close)
        if not is_open.any():
            break
    return values[names[0]]
