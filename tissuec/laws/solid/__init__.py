"""Laws of solids: a member is a ``Struct`` with the energy that it stores.

The energy per volume is a formula of the invariants of the strain without its change of volume,

    I1 = J^(-2/3) tr C,    I2 = J^(-4/3) (tr² C - tr C²) / 2,    C = Fᵀ F,    J = det F,

in units of the initial shear modulus: near I1 = I2 = 3 it is (I1 - 3)/2. The change of volume
costs K (J - 1)²/2 beside it, K being the bulk modulus (``solids.elements``). (G. A. Holzapfel,
Nonlinear Solid Mechanics, 2000, chapter 6.)
"""

from typing import Protocol

from tissuec.core.registry import Family
from tissuec.laws.formula import Formula, Variable

I1, I2 = Variable("i1"), Variable("i2")


class SolidLaw(Protocol):
    """Interface of members of ``SOLID_LAWS``; their fields are entries in the language."""

    def energy(self) -> Formula:
        """Return the energy per volume and initial shear modulus, a formula of i1 and i2."""
        ...


SOLID_LAWS: Family[type[SolidLaw]] = Family("tissuec.laws.solid", "solid law")
