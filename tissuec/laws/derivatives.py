"""Derivatives of the energies of solids by their invariants, each made once for a law."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tissuec.laws.formula import Formula, values_at
from tissuec.laws.solid import SolidLaw

_POINTS = 2048  # at a time: the values of all parts of formulas are in memory
Derivative = Callable[[SolidLaw], Formula]


@cache
def energy(law: SolidLaw) -> Formula:
    """Return the energy of a law."""
    return law.energy()


@cache
def by_first(law: SolidLaw) -> Formula:
    """Return the derivative of the energy by i1."""
    return energy(law).slope("i1")


@cache
def by_second(law: SolidLaw) -> Formula:
    """Return the derivative of the energy by i2."""
    return energy(law).slope("i2")


@cache
def by_first_twice(law: SolidLaw) -> Formula:
    """Return the second derivative of the energy by i1."""
    return by_first(law).slope("i1")


@cache
def by_both(law: SolidLaw) -> Formula:
    """Return the derivative of the energy by i1 and i2."""
    return by_first(law).slope("i2")


@cache
def by_second_twice(law: SolidLaw) -> Formula:
    """Return the second derivative of the energy by i2."""
    return by_second(law).slope("i2")


#: First and second derivatives, in the order of ``EnergySlopes``.
DERIVATIVES: tuple[Derivative, ...] = (
    by_first, by_second, by_first_twice, by_both, by_second_twice,
)  # fmt: skip


def at_invariants(
    laws: Sequence[SolidLaw],
    number: NDArray[np.integer],
    each: Sequence[Derivative],
    first: NDArray[np.float64],
    second: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return derivatives of energies, or energies, shape (derivative, …, element, point).

    Args:
        number: That of the law of each element, shape (element,).
        each: Derivatives of a law.
        first, second: Isochoric invariants, dimensionless, shape (…, element, point).
    """
    found = np.empty((len(each), *first.shape))
    for law in np.unique(number):
        own = number == law
        found[..., own, :] = _of_law(
            laws[int(law)], each, first[..., own, :], second[..., own, :]
        )
    return found


def _of_law(
    law: SolidLaw,
    each: Sequence[Derivative],
    first: NDArray[np.float64],
    second: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return derivatives of the energy of one law, shape (derivative, …)."""
    formulas = [what(law) for what in each]
    i1, i2 = first.ravel(), second.ravel()
    found = np.empty((len(formulas), first.size))
    for start in range(0, first.size, _POINTS):
        part = slice(start, start + _POINTS)
        values = values_at(formulas, {"i1": i1[part], "i2": i2[part]})
        for row, value in zip(found, values, strict=True):
            row[part] = value
    return found.reshape(len(formulas), *first.shape)
