"""Formulas of laws, which are trees, with values and derivatives found in another way."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.validate.forces import principal

Floats = NDArray[np.float64]


def derived(tree: Any, values: dict[str, Floats], name: str) -> tuple[Any, Any]:
    """Return value and derivative by one variable of a tree of ``laws.formula``.

    Args:
        tree: The formula.
        values: Values of its variables in SI units, all of one shape.
        name: The variable.

    Raises:
        TypeError: The tree has a node of an unknown type.
    """

    def of(part: Any) -> tuple[Any, Any]:
        return derived(part, values, name)

    match type(tree).__name__:
        case "Constant":
            return tree.value, 0.0
        case "Variable":
            return values[tree.name], 1.0 if tree.name == name else 0.0
        case "Sum":
            (a, da), (b, db), sign = of(tree.left), of(tree.right), -1.0 if tree.minus else 1.0
            return a + sign * b, da + sign * db
        case "Product":
            (a, da), (b, db) = of(tree.left), of(tree.right)
            return a * b, da * b + a * db
        case "Quotient":
            (a, da), (b, db) = of(tree.above), of(tree.below)
            return a / b, (da * b - a * db) / (b * b)
        case "Power":
            (a, da), n = of(tree.base), tree.exponent
            return np.power(a, n), n * np.power(a, n - 1.0) * da
        case "Applied":
            a, da = of(tree.argument)
            return _FUNCTIONS[tree.function](a), _SLOPES[tree.function](a) * da
        case "Choice":
            test, above, below = of(tree.test)[0], of(tree.above), of(tree.below)
            chosen = test >= 0.0
            return either(chosen, above[0], below[0]), either(chosen, above[1], below[1])
        case "Spline":
            a, da = of(tree.argument)
            value, slope = _on_spline(tree, a)
            return value, slope * da
        case "PrincipalSum":
            return _of_stretches(tree.exponent, values["i1"], values["i2"], name)
        case other:
            raise TypeError(f"a formula has no {other}")


def _on_spline(tree: Any, x: Any) -> tuple[Any, Any]:
    """Return value and slope of a spline, also beside the real line, of the shape of x."""
    x, starts = np.asarray(x), np.array(tree.places)
    real = np.asarray(x.real, dtype=np.float64)
    last = np.searchsorted(starts, real, side="right") - 1
    z = x - starts[np.maximum(last, 0)]
    a, b, c, d = np.moveaxis(np.array(tree.pieces)[np.maximum(last, 0)], -1, 0)
    value, slope = a + b * z + c * z**2 + d * z**3, b + 2.0 * c * z + 3.0 * d * z**2
    before = last < 0
    return either(before, a + tree.before * z, value), either(before, tree.before, slope)


def _of_stretches(a: float, i1: Any, i2: Any, name: str) -> tuple[Any, Any]:
    """Return Σ (λ^a - 1), or Σ log² λ if a is 0, and its derivative by an invariant."""
    if a == 0.0:
        value, (first, second) = (
            principal.total(lambda w: 0.25 * w * w, np.real(i1), np.real(i2)),
            principal.slopes(lambda w: 0.5 * w, i1, i2),
        )
    else:
        value, (first, second) = (
            principal.total(lambda w: np.exp(0.5 * a * w) - 1.0, np.real(i1), np.real(i2)),
            principal.slopes(lambda w: 0.5 * a * np.exp(0.5 * a * w), i1, i2),
        )
    return value, {"i1": first, "i2": second}.get(name, 0.0)


_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos,
}  # fmt: skip
_SLOPES: dict[str, Callable[[Any], Any]] = {
    "exp": np.exp,
    "log": lambda x: 1.0 / x,
    "sqrt": lambda x: 0.5 / np.sqrt(x),
    "sin": np.cos,
    "cos": lambda x: -np.sin(x),
}


def either(test: NDArray[np.bool_], one: ArrayLike, other: ArrayLike) -> Floats:
    """Return one value where a test holds, and another elsewhere, in their unit.

    Args:
        test: Shape (n,).
        one, other: In any unit, of shapes that broadcast to (n,).
    """
    return np.where(test, one, other)


def shipped(law: object) -> str:
    """Return the name of the class of a shipped law; empty for one of another package."""
    kind = type(law)
    return kind.__name__ if kind.__module__.startswith("tissuec.laws.") else ""
