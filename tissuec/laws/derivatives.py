"""Derivatives of the energies of solids by their invariants, each made once for a law.

They are those at a constant volume, where tr C is I1.
"""

from functools import cache

from tissuec.laws.formula import Formula, replaced
from tissuec.laws.solid import I1, TRACE, SolidLaw


@cache
def energy(law: SolidLaw) -> Formula:
    """Return the energy of a law."""
    return law.energy()


@cache
def by_first(law: SolidLaw) -> Formula:
    """Return the derivative of the energy by i1."""
    return replaced(energy(law), {TRACE.name: I1}).slope("i1")


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
