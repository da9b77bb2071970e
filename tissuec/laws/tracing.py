"""Formulas of laws in a graph of numbers, for kernels that are made of them."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

from tissuec import autodiff
from tissuec.autodiff import Number
from tissuec.laws.formula import (
    Applied,
    Choice,
    Constant,
    Formula,
    Given,
    Power,
    Product,
    Quotient,
    Spline,
    Sum,
    Variable,
    VariablePower,
)
from tissuec.laws.formula import variables as names_in
from tissuec.laws.principal import (
    PrincipalSum,
    SumByExponent,
    VariableDifference,
    VariableTotal,
)
from tissuec.laws.uniaxial import TensionEnergy, TensionStrain

_FUNCTIONS: Mapping[str, Callable[[Number], Number]] = {
    "exp": autodiff.exp, "log": autodiff.log, "sqrt": autodiff.sqrt, "sin": autodiff.sin,
    "cos": autodiff.cos,
}  # fmt: skip


def traced(formula: Formula, variables: Mapping[str, Number]) -> Number:
    """Return the value of a formula; parts that are shared are written down once.

    Args:
        variables: Their values, by name.
    """
    found: dict[int, Number] = {}  # by identity, as formulas keep their parts
    graph = next(iter(variables.values())).graph

    def of(part: Formula) -> Number:
        if id(part) not in found:
            found[id(part)] = graph.number(_value(part, of, variables))
        return found[id(part)]

    return of(formula)


def with_slopes(formula: Formula, variables: Mapping[str, Number]) -> Number:
    """Return the value of a formula, with derivatives by its own slopes.

    These choose between cases last, so that cases that are not chosen may have no value.

    Args:
        variables: Their values, by name.
    """
    names = tuple(sorted(names_in(formula)))
    arguments = [variables[name] for name in names]
    if not names:
        return traced(formula, variables)
    return autodiff.ruled(traced(formula, variables), arguments, _rule(formula, names))


@cache
def _rule(formula: Formula, names: tuple[str, ...]) -> Callable[..., Sequence[Number]]:
    def rule(_: Number, *arguments: Number) -> Sequence[Number]:
        given = dict(zip(names, arguments, strict=True))
        return [with_slopes(formula.slope(name), given) for name in names]

    return rule


def _value(
    formula: Formula, of: Callable[[Formula], Number], variables: Mapping[str, Number]
) -> Number | float:
    match formula:
        case Constant(value) | Given(value):
            return value
        case Variable(name):
            return variables[name]
        case Sum(left, right, minus):
            return of(left) - of(right) if minus else of(left) + of(right)
        case Product(left, right):
            return of(left) * of(right)
        case Quotient(above, below):
            return of(above) / of(below)
        case Power(base, exponent):
            return of(base) ** exponent
        case VariablePower(base, exponent):
            return of(base) ** of(exponent)
        case Applied(function, argument):
            return _FUNCTIONS[function](of(argument))
        case Choice(test, above, below):
            return autodiff.where(of(test) < 0.0, of(below), of(above))
        case Spline():
            return formula.value(of, _chosen)
        case PrincipalSum() | TensionEnergy():
            value, rule = _by_slopes(formula)
            arguments = [of(part) for part in formula.parts]
            return autodiff.ruled(autodiff.in_arrays(value, arguments), arguments, rule)
        case SumByExponent():
            value, _ = _by_slopes(formula)
            return autodiff.in_arrays(value, [of(part) for part in formula.parts])
        case VariableDifference() | VariableTotal() | TensionStrain():
            return formula.from_parts(variables, of)
        case _:
            raise TypeError(f"{type(formula).__name__} cannot be traced")


def _chosen(x: Number, place: Number | float, below: Number, above: Number) -> Number:
    return autodiff.where(x < place, below, above)


@cache
def _by_slopes(
    formula: PrincipalSum | SumByExponent | TensionEnergy,
) -> tuple[Callable[..., Any], Callable[..., Sequence[Number]]]:
    """Return the value of an energy of which only slopes are compiled, and their rule."""
    names = [part.name for part in formula.parts]

    def value(*arguments: Any) -> Any:
        return formula.at(dict(zip(names, arguments, strict=True)))

    def rule(_: Number, *arguments: Number) -> Sequence[Number]:
        given = dict(zip(names, arguments, strict=True))
        return [traced(formula.slope(name), given) for name in names]

    return value, rule
