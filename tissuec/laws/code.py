"""Laws for kernels: as formulas, and as Python functions of numbers.

Compiled code gets its functions from ``compiled.laws``; those here are for kernels
that run as Python.
"""

import ast
import hashlib
import operator
from collections.abc import Callable, Sequence
from functools import cache
from types import FunctionType

from tissuec.laws import Law
from tissuec.laws.formula import (
    ZERO,
    Applied,
    Choice,
    Constant,
    Formula,
    Spline,
    Variable,
    kinks,
)

_HEAD = "from math import cos, exp, log, sin, sqrt\n"


_SPRING, _DASHPOT = ("e", "c", "rest"), ("e", "w", "d", "rest")
#: What the functions of laws are of, besides the number of the law and the net, by their names.
ARGUMENTS = {
    "pull": _SPRING, "slope": _SPRING, "side": _SPRING,
    "brake": _DASHPOT, "brake_slope": _DASHPOT, "brake_by_e": _DASHPOT, "brake_side": _DASHPOT,
}  # fmt: skip


def formulas(laws: Sequence[Law]) -> dict[str, list[Formula]]:
    """Return the formulas of every law of a net that kernels need.

    They are the forces with their derivatives, and the sides of the laws' corners: numbers that
    change wherever a corner is passed.
    """
    return {
        "pull": [law.elastic for law in laws],
        "slope": [law.elastic.slope("e") for law in laws],
        "side": [sides(law.elastic, "e") for law in laws],
        "brake": [law.viscous for law in laws],
        "brake_slope": [law.viscous.slope("w") for law in laws],
        "brake_by_e": [law.viscous.slope("e") for law in laws],
        "brake_side": [sides(law.viscous, "e", "w") for law in laws],
    }


@cache
def functions(laws: tuple[Law, ...]) -> dict[str, Callable[..., float]]:
    """Return ``formulas`` as functions of the number of the law and plain numbers.

    Nothing of the net is asked. Their names end in a digest of what they do.

    Args:
        laws: The first is ``LINEAR``.
    """
    return {
        name: _choosing(name, ", ".join((*ARGUMENTS[name], "net=None")), members)
        for name, members in formulas(laws).items()
    }


def sides(formula: Formula, *names: str) -> Formula:
    """Return a formula whose value changes wherever a corner of another one is passed."""
    total: Formula = ZERO
    for number, test in enumerate(kinks(formula, *names)):
        total = total + Choice(test, Constant(2.0 ** (number % 50)), ZERO)
    return total


def _choosing(name: str, arguments: str, formulas: Sequence[Formula]) -> Callable[..., float]:
    """Return a function of a law's number and arguments that evaluates the formula of it."""
    lines = [f"def law_function(law, {arguments}):"]
    for number, formula in enumerate(formulas[1:], start=1):
        if formula != formulas[0]:
            lines.append(f"    if law == {number}:")
            lines.append(f"        return {formula.code()}")
    lines.append(f"    return {formulas[0].code()}")
    text = "\n".join(lines) + "\n"
    names: dict[str, object] = {"spline": spline}
    exec(compile(_HEAD + text, f"<{name} of laws>", "exec"), names)
    made = names["law_function"]
    assert isinstance(made, FunctionType)
    made.__module__ = __name__
    made.__name__ = made.__qualname__ = (
        f"{name}_{hashlib.sha256(text.encode()).hexdigest()[:12]}"
    )
    return made


def spline(x: float, places: tuple[float, ...], pieces: tuple[tuple[float, ...], ...]) -> float:
    """Return the value of a ``Spline``; the first piece is the one before all places.

    Args:
        x: Argument.
        places: Where pieces begin, ascending.
        pieces: Cubic coefficients of each piece.
    """
    piece = 0
    while piece < len(places) and x >= places[piece]:
        piece += 1
    value, slope, bend, twist = pieces[piece]
    z = x - places[max(piece - 1, 0)]
    return value + z * (slope + z * (bend + z * twist))


def _power(base: Formula, exponent: Formula) -> Formula:
    assert isinstance(exponent, Constant)
    return base**exponent.value


def _quotient(above: Formula, below: Formula) -> Formula:
    return above / below


_OPERATORS: dict[type[ast.operator], Callable[[Formula, Formula], Formula]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: _quotient, ast.Pow: _power,
}  # fmt: skip


def parse(text: str) -> Formula:
    """Return the formula whose ``code`` a text is; the opposite of ``Formula.code``.

    Raises:
        ValueError: The text is no such code.
    """
    return _tree(ast.parse(text, mode="eval").body)


def _tree(node: ast.expr) -> Formula:
    match node:
        case ast.Constant(value=float() | int() as value):
            return Constant(float(value))
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=float() | int() as value)):
            return Constant(-float(value))
        case ast.Name(id=name):
            return Variable(name)
        case ast.BinOp(left=left, op=sign, right=right):
            return _OPERATORS[type(sign)](_tree(left), _tree(right))
        case ast.IfExp(test=ast.Compare(left=test), body=above, orelse=below):
            return Choice(_tree(test), _tree(above), _tree(below))
        case ast.Call(func=ast.Name(id="spline"), args=[argument, places, pieces]):
            (_, slope, _, _), *rest = ast.literal_eval(pieces)
            return Spline(_tree(argument), ast.literal_eval(places), tuple(rest), slope)
        case ast.Call(func=ast.Name(id=function), args=[argument]):
            return Applied(function, _tree(argument))
        case _:
            raise ValueError(f"{ast.unparse(node)} is not a formula of a law")
