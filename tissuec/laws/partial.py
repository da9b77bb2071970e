"""Laws and all their partial derivatives as functions of plain numbers, for learning.

Constants of laws that may change are variables called ``k[0]``, ``k[1]``, … of the formulas;
they reach the functions as an array k.
"""

import hashlib
from collections.abc import Callable, Sequence
from functools import cache
from types import FunctionType

from tissuec.laws import Law
from tissuec.laws.code import spline
from tissuec.laws.formula import ZERO, Formula

_HEAD = "from math import cos, exp, log, sin, sqrt\n"


def constant_name(number: int) -> str:
    """Return the variable of a constant that may change."""
    return f"k[{number}]"


@cache
def functions(laws: tuple[Law, ...], constants: int) -> dict[str, Callable[..., float]]:
    """Return the functions by name; all take (law, e or w, c or d, rest, k).

    ``by_constant`` takes (law, number of the constant, e, w, c, d, rest, k).

    Args:
        laws: The first is ``LINEAR``.
        constants: How many constants may change.
    """
    elastic, viscous = [law.elastic for law in laws], [law.viscous for law in laws]

    def derived(formulas: Sequence[Formula], name: str) -> list[Formula]:
        return [formula.slope(name) for formula in formulas]

    written = {
        "pull": ("e, c", elastic),
        "slope": ("e, c", derived(elastic, "e")),
        "pull_by_c": ("e, c", derived(elastic, "c")),
        "pull_by_rest": ("e, c", derived(elastic, "rest")),
        "brake": ("w, d", viscous),
        "brake_slope": ("w, d", derived(viscous, "w")),
        "brake_by_d": ("w, d", derived(viscous, "d")),
        "brake_by_rest": ("w, d", derived(viscous, "rest")),
    }
    found = {name: _function(name, at, formulas) for name, (at, formulas) in written.items()}
    found["by_constant"] = _by_constant(elastic, viscous, constants)
    return found


def _function(name: str, at: str, formulas: Sequence[Formula]) -> Callable[..., float]:
    lines = [f"def law_function(law, {at}, rest, k):"]
    for number, formula in enumerate(formulas[1:], start=1):
        if formula != formulas[0]:
            lines += [f"    if law == {number}:", f"        return {formula.code()}"]
    return _made(name, [*lines, f"    return {formulas[0].code()}"])


def _by_constant(
    elastic: Sequence[Formula], viscous: Sequence[Formula], constants: int
) -> Callable[..., float]:
    lines = ["def law_function(law, number, e, w, c, d, rest, k):"]
    for law, both in enumerate(zip(elastic, viscous, strict=True)):
        for number in range(constants):
            one, two = (formula.slope(constant_name(number)) for formula in both)
            if (total := one + two) != ZERO:
                lines += [f"    if law == {law} and number == {number}:"]
                lines += [f"        return {total.code()}"]
    return _made("by_constant", [*lines, "    return 0.0"])


def _made(name: str, lines: Sequence[str]) -> Callable[..., float]:
    """Return a function of some lines, whose name ends in a digest of what it does."""
    text = "\n".join(lines) + "\n"
    names: dict[str, object] = {"spline": spline}
    exec(compile(_HEAD + text, f"<{name} of laws>", "exec"), names)
    made = names["law_function"]
    assert isinstance(made, FunctionType)
    made.__module__ = __name__
    digest = hashlib.sha256(text.encode()).hexdigest()[:12]
    made.__name__ = made.__qualname__ = f"{name}_{digest}"
    return made
