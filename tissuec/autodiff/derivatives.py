"""Exact derivatives of numbers of a graph, which are numbers of the same graph.

They follow operation by operation: backwards from one number to all that it depends on, which
is cheap for a gradient, or forwards along given changes (A. Griewank, A. Walther, *Evaluating
derivatives*, 2008).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias, cast

from tissuec.autodiff.functions import cos, log, sin, where
from tissuec.autodiff.graph import Graph, Inequality, Number, Operand, Rule

_Partials: TypeAlias = Callable[..., Sequence[Operand]]


def _of_maximum(_: Number, a: Number, b: Number) -> Sequence[Operand]:
    return where(a > b, 1.0, 0.0), where(a > b, 0.0, 1.0)


def _of_minimum(_: Number, a: Number, b: Number) -> Sequence[Operand]:
    return where(a > b, 0.0, 1.0), where(a > b, 1.0, 0.0)


def _of_where(_: Number, condition: Number, one: Number, other: Number) -> Sequence[Operand]:
    test = Inequality(condition.graph, condition.place)
    return 0.0, where(test, 1.0, 0.0), where(test, 0.0, 1.0)


def _of_quotient(value: Number, a: Number, b: Number) -> Sequence[Operand]:
    inverse = 1.0 / b
    return inverse, -(value * inverse)


def _of_power(value: Number, a: Number, b: Number) -> Sequence[Operand]:
    by_base = b * a ** (b - 1.0)
    return by_base, 0.0 if b.value is not None else value * log(a)


#: By operation: derivatives of the result, which comes first, by the arguments.
_PARTIALS: Mapping[str, _Partials] = {
    "sum": lambda value, a, b: (1.0, 1.0),
    "difference": lambda value, a, b: (1.0, -1.0),
    "negative": lambda value, a: (-1.0,),
    "product": lambda value, a, b: (b, a),
    "quotient": _of_quotient,
    "power": _of_power,
    "sqrt": lambda value, a: (0.5 / value,),
    "exp": lambda value, a: (value,),
    "log": lambda value, a: (1.0 / a,),
    "sin": lambda value, a: (cos(a),),
    "cos": lambda value, a: (-sin(a),),
    "maximum": _of_maximum,
    "minimum": _of_minimum,
    "where": _of_where,
    "greater": lambda value, a, b: (0.0, 0.0),
}


def partials(graph: Graph, place: int) -> Iterator[tuple[int, Number]]:
    """Yield the arguments of an operation, and the derivatives of its result by them."""
    name, _, detail = graph.operations[place]
    if name in ("constant", "input", "unknown"):
        return
    places = graph.arguments_of(place, by_rules=True)
    rule = cast(Rule, detail) if name == "ruled" else _PARTIALS[name]
    slopes = rule(Number(graph, place), *(Number(graph, each) for each in places))
    for each, slope in zip(places, slopes, strict=True):
        yield each, graph.number(slope)


def gradient(
    output: Number, inputs: Sequence[Number], fixed: Iterable[Number] = ()
) -> list[Number]:
    """Return the derivatives of a number by all inputs.

    Args:
        inputs: By what; inputs of the graph, or results in it.
        fixed: What counts as constant; inputs among it count as independent of each other.
    """
    graph, fixed = output.graph, tuple(fixed)
    order = graph.reached([output], by_rules=True)
    depends = _dependent(graph, order, inputs, fixed)
    due, ends = {output.place: graph.number(1.0)}, {each.place for each in fixed}
    for place in reversed(order):
        if place not in due or place not in depends or place in ends:
            continue
        here, slopes = due[place], list(partials(graph, place))
        if len(slopes) == 2 and slopes[0] == slopes[1]:  # of a square; often many have one due
            here, slopes = 2.0 * here, slopes[:1]
        for argument, slope in slopes:
            if argument in depends and slope.value != 0.0:
                part = here * slope
                due[argument] = due[argument] + part if argument in due else part
    return [due.get(each.place, graph.number(0.0)) for each in inputs]


def along(outputs: Sequence[Number], changes: Mapping[Number, Operand]) -> list[Number]:
    """Return how outputs change where numbers change at given rates.

    Args:
        outputs: Of one graph.
        changes: By number, its rate of change.
    """
    graph = outputs[0].graph
    found = {number.place: graph.number(rate) for number, rate in changes.items()}
    order = graph.reached(outputs, by_rules=True)
    depends = _dependent(graph, order, changes)
    for place in order:
        if place not in depends or place in found:
            continue
        total = graph.number(0.0)
        for argument, slope in partials(graph, place):
            if argument in found and slope.value != 0.0:
                total = total + slope * found[argument]
        found[place] = total
    return [found.get(each.place, graph.number(0.0)) for each in outputs]


def changed(
    outputs: Sequence[Number], by: Sequence[Number]
) -> tuple[list[Number], dict[str, Number]]:
    """Return the changes of outputs, and the inputs that are those of what these depend on.

    Args:
        by: Inputs, whose changes have their names after a "d", in the same order.
    """
    rates = {
        name: outputs[0].graph.input(name)
        for name in (f"d{each.operation.detail}" for each in by)
    }
    return along(outputs, dict(zip(by, rates.values(), strict=True))), rates


def jacobian(outputs: Sequence[Number], inputs: Sequence[Number]) -> list[Number]:
    """Return the derivatives of all outputs by all inputs, output by output."""
    columns = [along(outputs, {each: 1.0}) for each in inputs]
    return [entry for row in zip(*columns, strict=True) for entry in row]


def hessian(output: Number, inputs: Sequence[Number]) -> dict[tuple[int, int], Number]:
    """Return the second derivatives of a number by their places (i, j), i >= j, row by row."""
    return lower_half(gradient(output, inputs), inputs)


def lower_half(
    slopes: Sequence[Number], inputs: Sequence[Number]
) -> dict[tuple[int, int], Number]:
    """Return the derivatives of slopes that have a potential, as ``hessian`` does."""
    found = dict[tuple[int, int], Number]()
    for j, each in enumerate(inputs):
        column = along(slopes[j:], {each: 1.0})
        found |= {(i, j): entry for i, entry in enumerate(column, start=j)}
    return {place: found[place] for place in sorted(found)}


def _dependent(
    graph: Graph, order: Iterable[int], inputs: Iterable[Number], fixed: Iterable[Number] = ()
) -> set[int]:
    """Return the places of inputs and of what depends on them."""
    found, stays = {each.place for each in inputs}, {each.place for each in fixed}
    for place in order:
        if place not in stays and any(
            each in found for each in graph.arguments_of(place, by_rules=True)
        ):
            found.add(place)
    return found
