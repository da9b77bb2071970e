"""Laws of solids: a member is a ``Struct`` with the energy that it stores.

The energy per volume is a formula of the invariants of the strain without its change of volume,

    I1 = J^(-2/3) tr C,    I2 = J^(-4/3) (tr² C - tr C²) / 2,    C = Fᵀ F,    J = det F,

in units of the initial shear modulus: near I1 = I2 = 3 it is (I1 - 3)/2. Coupled laws use tr C.
What the change of volume costs is in ``laws.solid.volume``, but for whole laws, which depend on
Lamé's constant λ: theirs is the energy of any strain. (G. A. Holzapfel, Nonlinear Solid
Mechanics, 2000, chapter 6.)
"""

from typing import Protocol

from tissuec.core.registry import Family
from tissuec.laws.formula import Formula, Variable

I1, I2, TRACE = Variable("i1"), Variable("i2"), Variable("trace")
#: (tr² C - tr C²)/2, J, and λ over the shear modulus, all of whole laws.
COFACTORS, J, LAME = Variable("cofactors"), Variable("j"), Variable("lame")


class SolidLaw(Protocol):
    """Interface of members of ``SOLID_LAWS``; their fields are entries in the language."""

    def energy(self) -> Formula:
        """Return the energy over the initial shear modulus.

        It is a formula of i1, i2 and trace; of whole laws, also of cofactors, j and lame.
        """
        ...


SOLID_LAWS: Family[type[SolidLaw]] = Family("tissuec.laws.solid", "solid law")
