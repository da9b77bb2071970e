"""Solids under tension along one axis, as laws of the springs of bars.

A bar of an incompressible solid that is stretched by λ has the invariants I1 = λ² + 2/λ and
I2 = 2 λ + λ⁻², and sums over its principal stretches are λ^a + 2 λ^(-a/2). Its nominal stress
is the derivative by λ of the energy, μ ψ with μ = E/3:

    σ = E/3 dψ/dλ = 2 E/3 (λ - λ⁻²) (∂ψ/∂I1 + ∂ψ/∂I2 / λ).

(R. W. Ogden, Non-Linear Elastic Deformations, 1984, section 4.3.)
"""

from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.laws import MODULUS, STRAIN, of_stress
from tissuec.laws.derivatives import energy
from tissuec.laws.formula import Formula, Variable
from tissuec.laws.principal import PrincipalSum
from tissuec.laws.solid import I1, I2, TRACE, SolidLaw

_STRETCH = 1.0 + STRAIN


class BarOfSolid(Struct, frozen=True):
    """The law of the springs of a bar that is made of a solid.

    Attributes:
        solid: The law of the solid.
    """

    solid: SolidLaw

    def force(self) -> Formula:
        """Return the force [N] as a formula of e, c, rest and Young's modulus."""
        stored = _drawn(energy(self.solid))
        return of_stress(MODULUS / 3.0 * stored.slope(STRAIN.name))


def _drawn(formula: Formula) -> Formula:
    """Return a formula of invariants as one of the strain along an axis."""
    match formula:
        case PrincipalSum():
            return formula.along(_STRETCH)
        case Variable(name=I1.name | TRACE.name):
            return _STRETCH**2.0 + 2.0 / _STRETCH
        case Variable(name=I2.name):
            return 2.0 * _STRETCH + 1.0 / _STRETCH**2.0
        case _:
            pass
    names = formula.__struct_fields__
    parts = {
        name: _drawn(part)
        for name in names
        if isinstance(part := getattr(formula, name), Formula)
    }
    return replace(formula, **parts) if parts else formula
