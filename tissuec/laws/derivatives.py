"""Derivatives of the energies of solids by their invariants, each made once for a law.

They are those at a constant volume, where the invariants of C are I1 and I2.
"""

from functools import cache

from tissuec.laws.formula import Constant, Formula, replaced
from tissuec.laws.solid import COFACTORS, I1, I2, TRACE, J, SolidLaw


@cache
def energy(law: SolidLaw) -> Formula:
    """Return the energy of a law."""
    return law.energy()


@cache
def _at_constant_volume(law: SolidLaw) -> Formula:
    known = {TRACE.name: I1, COFACTORS.name: I2, J.name: Constant(1.0)}
    return replaced(energy(law), known)


@cache
def by_first(law: SolidLaw) -> Formula:
    """Return the derivative of the energy by i1."""
    return _at_constant_volume(law).slope("i1")


@cache
def by_second(law: SolidLaw) -> Formula:
    """Return the derivative of the energy by i2."""
    return _at_constant_volume(law).slope("i2")


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
