"""Sums over principal stretches as formulas of the isochoric invariants.

The squares x of the isochoric principal stretches are the zeros of x³ - I1 x² + I2 x - 1. What
a sum S = Σ x^p changes by with the invariants are second divided differences over them,

    ∂S/∂I1 = p D[x^(p+1)],    ∂S/∂I2 = -p D[x^p],

as follows from the derivatives of simple zeros; differences have a value where zeros coincide,
too. They are found without any zeros: D[1/(x + t)] = 1/P(t) with P(t) = t³ + I1 t² + I2 t + 1,
and, beginning with x^q = sin(π q)/π ∫ t^(q-1) x/(x + t) dt (0 to ∞, 0 < q < 1),

    D[x^q] = q (q - 1)/2 + sin(π q)/π ∫ t^(q+1) ((I1 - 3) t + I2 - 3) / (P(t) (1 + t)³) dt

for -2 < q < 3 by analytic continuation. With t = (1 + u)²/(1 - u)², this is the integral of a
rational function with a weight of Jacobi, which Gauss's quadrature finds to rounding for
stretches from 1/10 to 10, and to 1e-7 up to 30. Other powers follow from x³ = I1 x² - I2 x + 1
at the zeros. The derivative by q at 0 and 1 gives the sum of squared logarithms. (C. de Boor,
Divided differences, Surv. Approx. Theory 1:46, 2005; G. H. Golub, J. H. Welsch, Math. Comp.
23:221, 1969, on Gauss's quadrature.)

An exponent that is learnt is no number here, but a variable. At the zeros, every function of x
is a polynomial of second degree, of which D is the last coefficient, and products of such
polynomials are reduced by the equation of the zeros. So x^q = exp(q log x) is found from the
polynomial of log x, whose coefficients follow from D[x^q log x] at q = -1, 0 and 1, by Taylor's
series of a small part of the exponent, which is then squared often enough. (A. McCurdy, K. C.
Ng, B. N. Parlett, Math. Comp. 43:501, 1984.)
"""

from collections.abc import Mapping, Sequence
from functools import cache
from math import cos, floor, gamma, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.laws.formula import (
    ONE,
    ZERO,
    Constant,
    Formula,
    PartValues,
    Values,
    Variable,
    apply,
)
from tissuec.laws.solid import I1, I2, J

_POINTS = 32  # of Gauss's quadrature
_SQUARINGS, _TERMS = 8, 10  # leave rounding for exponents up to 60 and stretches up to 10
#: The isochoric principal stretches λ in code.
STRETCHES = ("l1", "l2", "l3")
_Z1, _Z2 = I1 - 3.0, I2 - 3.0
#: Coefficients of a polynomial by the powers of I1 - 3 and I2 - 3.
_Polynomial = Mapping[tuple[int, int], int]


class PrincipalSum(Formula, frozen=True):
    """Σ (λ^α - 1) over the isochoric principal stretches; Σ log² λ where α = 0.

    Only its derivatives are compiled. Its code is for people: it names the stretches.

    Attributes:
        exponent: α.
        is_whole: Whether the stretches include the change of volume; α is then not 0.
    """

    exponent: float | Variable
    is_whole: bool = False

    @property
    def parts(self) -> tuple[Variable, ...]:
        own = (self.exponent,) if isinstance(self.exponent, Variable) else ()
        return I1, I2, *((J,) if self.is_whole else ()), *own

    def from_parts(self, values: Values, of: PartValues) -> NDArray[np.float64]:
        squares = _zeros(np.asarray(values["i1"]), np.asarray(values["i2"]))
        if self.is_whole:
            squares = squares * np.asarray(values["j"]) ** (2.0 / 3.0)
        if self.exponent == 0.0:
            return np.real(0.25 * np.log(squares) ** 2).sum(axis=0)
        exponent = of(self.exponent) if isinstance(self.exponent, Variable) else self.exponent
        return np.real(squares ** (0.5 * exponent) - 1.0).sum(axis=0)

    def slope(self, name: str) -> Formula:
        if isinstance(self.exponent, Variable) and name == self.exponent.name:
            return SumByExponent(self.exponent, self.is_whole)
        swollen = J ** (self.exponent * (1.0 / 3.0)) if self.is_whole else ONE
        if name in (I1.name, I2.name):
            return swollen * _slopes(self.exponent)[name == I2.name]
        if self.is_whole and name == J.name:
            return self.exponent * (1.0 / 3.0) * swollen / J * _total(self.exponent)
        return ZERO

    def code(self) -> str:
        if self.exponent == 0.0:
            return f"({' + '.join(f'log({name}) ** 2' for name in STRETCHES)})"
        powers = [f"{name} ** {self.exponent!r}" for name in STRETCHES]
        return f"({' + '.join(powers)} - 3.0)"

    def along(self, stretch: Formula) -> Formula:
        """Return the sum for a stretch along one axis, and its root across."""
        if self.exponent == 0.0:
            return 1.5 * apply("log", (stretch,)) ** 2.0
        return stretch**self.exponent + 2.0 * stretch ** (-0.5 * self.exponent) - 3.0


class SumByExponent(Formula, frozen=True):
    """Σ λ^α log λ, of which nothing is compiled; attributes are those of ``PrincipalSum``."""

    exponent: Variable
    is_whole: bool = False

    @property
    def parts(self) -> tuple[Variable, ...]:
        return I1, I2, *((J,) if self.is_whole else ()), self.exponent

    def from_parts(self, values: Values, of: PartValues) -> NDArray[np.float64]:
        squares = _zeros(np.asarray(values["i1"]), np.asarray(values["i2"]))
        if self.is_whole:
            squares = squares * np.asarray(values["j"]) ** (2.0 / 3.0)
        power = squares ** (0.5 * of(self.exponent))
        return np.real(power * 0.5 * np.log(squares)).sum(axis=0)


def power_sum(exponent: float | Variable, *, is_whole: bool = False) -> Formula:
    """Return Σ (λ^α - 1) over the isochoric principal stretches λ.

    Args:
        exponent: α, not 0.
        is_whole: Whether the stretches include the change of volume.
    """
    return PrincipalSum(exponent, is_whole)


def squared_logarithms() -> Formula:
    """Return Σ log² λ over the isochoric principal stretches λ."""
    return PrincipalSum(0.0)


@cache
def _slopes(exponent: float | Variable) -> tuple[Formula, Formula]:
    """Return the derivatives of a sum by I1 and I2."""
    if isinstance(exponent, Variable):
        half = 0.5 * exponent
        return half * VariableDifference(half, 1), -half * VariableDifference(half, 0)
    p = 0.5 * exponent
    if exponent == 0.0:
        return 0.5 * _logarithmic(1), -0.5 * _logarithmic(0)
    return p * _difference(p + 1.0), -p * _difference(p)


@cache
def _total(exponent: float | Variable) -> Formula:
    """Return Σ x^(α/2) over the zeros x of P, which is D[P' x^(α/2)]."""
    if isinstance(exponent, Variable):
        return VariableTotal(0.5 * exponent)
    q = 0.5 * exponent
    found = 3.0 * _difference(q + 2.0) - 2.0 * I1 * _difference(q + 1.0)
    return found + I2 * _difference(q)


def _difference(q: float) -> Formula:
    """Return D[x^q]."""
    more = floor(q) + 1
    first = q - more  # from -1 to below 0; the two powers behind it are known, too
    ways = _remainder(more)
    found: Formula = Constant(0.0)
    for k, way in enumerate(ways):
        found = found + 0.5 * (first + k) * (first + k - 1.0) * _polynomial(way)
    if first == -1.0:  # a whole power, whose integral has no part in it
        return found
    sines = [sin(pi * (first + k)) / pi for k in range(3)]
    integrals = _integrals(first)
    for sine, way, integral in zip(sines, ways, integrals, strict=True):
        if way:
            found = found + _polynomial(way) * (sine * integral)
    return found


def _logarithmic(q: int) -> Formula:
    """Return D[x^q log x] for q = -1, 0 or 1, the derivative of D[x^q] by q."""
    return (q - 0.5) + cos(pi * q) * _integrals(-1.0)[q + 1]


class VariableDifference(Formula, frozen=True):
    """D[x^(q + n)], where q is a formula; it is differentiated where it is compiled.

    Attributes:
        power: q.
        more: n, 0 or 1.
    """

    power: Formula
    more: int

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.power, *_of_logarithm()

    def from_parts(self, values: Values, of: PartValues) -> Any:
        _, once, twice = _power(self.power, of)
        return twice + once + twice * of(_Z1) if self.more else twice


class VariableTotal(Formula, frozen=True):
    """Σ x^q, where q is a formula; it is differentiated where it is compiled.

    Attributes:
        power: q.
    """

    power: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.power, *_of_logarithm()

    def from_parts(self, values: Values, of: PartValues) -> Any:
        (free, once, twice), z1, z2 = _power(self.power, of), of(_Z1), of(_Z2)
        # The sums of z = x - 1 and of z² are z1 and z1² + 4 z1 - 2 z2.
        return 3.0 * free + once * z1 + twice * (z1 * (z1 + 4.0) - 2.0 * z2)


def _power(power: Formula, of: PartValues) -> Sequence[Any]:
    """Return x^q at the zeros, as the coefficients of a polynomial of x - 1.

    Args:
        power: q.
    """
    z1, z2, (below, last, above) = of(_Z1), of(_Z2), map(of, _of_logarithm())
    # log x by powers of x - 1, of which D gives the coefficients by those of x.
    log = below + above - last * (z1 + 2.0), above - last * (z1 + 1.0), last
    part = [of(power) * 2.0**-_SQUARINGS * each for each in log]
    found: Sequence[Any] = (1.0, 0.0, 0.0)
    for k in range(_TERMS, 0, -1):
        free, once, twice = _times([each / k for each in part], found, z1, z2)
        found = 1.0 + free, once, twice
    for _ in range(_SQUARINGS):
        found = _times(found, found, z1, z2)
    return found


def _times(one: Sequence[Any], other: Sequence[Any], z1: Any, z2: Any) -> tuple[Any, Any, Any]:
    """Return the product of polynomials at the zeros, by powers of z = x - 1.

    There, z³ = (I1 - 3) z² + (2 (I1 - 3) - (I2 - 3)) z + (I1 - 3) - (I2 - 3).

    Args:
        one, other: Three coefficients each.
        z1, z2: I1 - 3 and I2 - 3.
    """
    (a, b, c), (d, e, f) = one, other
    free, once = z1 - z2, 2.0 * z1 - z2
    fourth = c * f
    third = b * f + c * e + z1 * fourth
    return (
        a * d + third * free,
        a * e + b * d + third * once + fourth * free,
        a * f + b * e + c * d + third * z1 + fourth * once,
    )


@cache
def _of_logarithm() -> tuple[Formula, Formula, Formula]:
    """Return D[x^q log x] for q = -1, 0 and 1."""
    return _logarithmic(-1), _logarithmic(0), _logarithmic(1)


@cache
def _integrals(first: float) -> tuple[Formula, Formula, Formula]:
    """Return the integrals of D[x^q] for q = ``first``, and one and two more.

    Args:
        first: From -1 to 0.
    """
    places, weights = _gauss_jacobi(1.0 - 2.0 * first, 3.0 + 2.0 * first)
    found: list[Formula] = [ZERO, ZERO, ZERO]
    for u, weight in zip(places.tolist(), weights.tolist(), strict=True):
        up, down, at_rest = (1.0 + u) ** 2, (1.0 - u) ** 2, (2.0 + 2.0 * u * u) ** 3
        # Numerator and P, times powers of 1 - u.
        above = up * _Z1 + down * _Z2
        below = (up * up * down) * _Z1 + (up * down * down) * _Z2 + at_rest
        ratio = above / below
        for k, part in enumerate((down * down, up * down, up * up)):
            found[k] = found[k] + (4.0 * weight * part / at_rest) * ratio
    return found[0], found[1], found[2]


def _gauss_jacobi(alpha: float, beta: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places and weights of Gauss's quadrature with the weight (1 - u)^α (1 + u)^β."""
    n, both = np.arange(_POINTS), alpha + beta
    twice = 2.0 * n + both
    middle = (beta**2 - alpha**2) / (twice * (twice + 2.0))
    n, twice = n[1:], twice[1:]
    aside = 4.0 * n * (n + alpha) * (n + beta) * (n + both)
    aside = np.sqrt(aside / (twice**2 * (twice**2 - 1.0)))
    places, ways = np.linalg.eigh(np.diag(middle) + np.diag(aside, 1) + np.diag(aside, -1))
    whole = 2.0 ** (both + 1.0) * gamma(alpha + 1.0) * gamma(beta + 1.0) / gamma(both + 2.0)
    return places, whole * ways[0] ** 2


@cache
def _remainder(power: int) -> tuple[_Polynomial, _Polynomial, _Polynomial]:
    """Return the coefficients of 1, x and x² in x^power where x³ = I1 x² - I2 x + 1."""
    rows: list[dict[tuple[int, int], int]] = [{(0, 0): 1}, {}, {}]
    for _ in range(abs(power)):
        a, b, c = rows
        if power > 0:  # x (a + b x + c x²)
            rows = [c, _joined(a, (c, -3, (0, 0)), (c, -1, (0, 1))),
                    _joined(b, (c, 3, (0, 0)), (c, 1, (1, 0)))]  # fmt: skip
        else:  # 1/x = x² - I1 x + I2
            rows = [_joined(b, (a, 3, (0, 0)), (a, 1, (0, 1))),
                    _joined(c, (a, -3, (0, 0)), (a, -1, (1, 0))), a]  # fmt: skip
    return rows[0], rows[1], rows[2]


def _joined(
    first: _Polynomial, *more: tuple[_Polynomial, int, tuple[int, int]]
) -> dict[tuple[int, int], int]:
    """Return a polynomial plus multiples of others, each by a power of both variables."""
    found = dict(first)
    for other, factor, (one, two) in more:
        for (i, j), number in other.items():
            place = i + one, j + two
            found[place] = found.get(place, 0) + factor * number
    return {place: number for place, number in found.items() if number}


def _polynomial(of: _Polynomial) -> Formula:
    """Return a polynomial as a formula, by Horner's scheme in both variables."""
    rows: dict[int, dict[int, int]] = {}
    for (i, j), number in of.items():
        rows.setdefault(i, {})[j] = number

    def horner(terms: Mapping[int, Formula], variable: Formula) -> Formula:
        found: Formula = ZERO
        for power in range(max(terms, default=0), -1, -1):
            found = found * variable + terms.get(power, ZERO)
        return found

    inner = {
        i: horner({j: Constant(float(number)) for j, number in row.items()}, _Z2)
        for i, row in rows.items()
    }
    return horner(inner, _Z1)


def squared_stretches(i1: NDArray[np.float64], i2: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the squares of the isochoric principal stretches, dimensionless, shape (3, …)."""
    return np.real(_zeros(i1, i2))


def _zeros(i1: NDArray[np.float64], i2: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the zeros of x³ - I1 x² + I2 x - 1, shape (3, …); by Cardano's formula.

    They are real for all strains; elements that are turned inside out are continued.
    """
    middle = i1 / 3.0
    q, r = (i1 * i1 - 3.0 * i2) / 9.0, (2.0 * i1**3 - 9.0 * i1 * i2 + 27.0) / 54.0
    root = np.sqrt(r * r - q**3 + 0.0j)
    one = (r + np.where(r < 0.0, -root, root)) ** (1.0 / 3.0)
    two = np.divide(q, one, where=one != 0.0, out=np.zeros_like(one))
    turns = [np.exp(2j * pi * k / 3.0) for k in range(3)]
    return np.array([middle + turn * one + two / turn for turn in turns])
