"""Laws of matter by its stress in tension along one axis: from a curve, or that of Fung.

Of all incompressible solids with a curve, the one that is taken has an energy that depends on
I1 alone. Stretched by λ, its nominal stress is σ = 2 (λ - λ⁻²) dW/dI1 at I1 = λ² + 2/λ, so that
W = ∫ σ dλ. (R. S. Rivlin, D. W. Saunders, Phil. Trans. A 243:251, 1951.) Compression, shear and
equibiaxial tension follow from it.

Matter that stiffens after Fung has the nominal stress E/k (exp(k ε) - 1) in uniaxial tension
and compression, so that the stiffness grows linearly with the stress (Y. C. Fung, Am. J.
Physiol. 213:1532, 1967).
"""

from typing import Annotated, Any

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import MODULUS, STRAIN, of_stress
from tissuec.laws.formula import (
    ZERO,
    Choice,
    Constant,
    Formula,
    PartValues,
    Values,
    Variable,
    apply,
    exp,
    given,
    replaced,
    variables,
)
from tissuec.laws.solid import I1

LARGEST = 4.0  # stretch up to which the curve is followed; beyond, dW/dI1 stays
_REACH = LARGEST**2 + 2.0 / LARGEST - 3.0
_NEAR = 3e-14  # of I1 - 3: at rest, σ/ε is that of a strain of 1e-7
_ROUNDS = 4  # of Newton's iteration, which leave rounding
PIECES = 160  # of the curve, each of which is integrated by Gauss's quadrature
_POINTS = 6
_Z = apply("min", (apply("max", (I1 - 3.0, ZERO)), Constant(_REACH))) + _NEAR


class OfTension(Struct, frozen=True):
    """A solid that follows a curve of nominal stress in uniaxial tension.

    Attributes:
        stress: [Pa], of ``strain``.
        modulus: Young's modulus [Pa] to which the energy refers.
    """

    stress: Formula
    modulus: float | Variable

    def energy(self) -> Formula:
        """Return 3/E ∫ σ dλ as a formula of i1."""
        return 3.0 / self.modulus * TensionEnergy(self.stress)


class TensionStrain(Formula, frozen=True):
    """λ - 1 > 0 with λ² + 2/λ = I1, up to a limit.

    With z = I1 - 3 and λ - 1 = s √z, this is s³ √z + 3 s² - s √z - 1 = 0, where s lies between
    √(1/3) and 1.
    """

    @property
    def parts(self) -> tuple[Formula, ...]:
        return (_Z,)

    def from_parts(self, values: Values, of: PartValues) -> Any:
        root = of(_Z) ** 0.5
        s = ((1.0 + 0.7 * root) / (3.0 + 0.7 * root)) ** 0.5
        for _ in range(_ROUNDS):
            strain = s * root
            s = s - (s * s * (3.0 + strain) - strain - 1.0) / (s * (6.0 + 3.0 * strain) - root)
        return s * root

    def slope(self, name: str) -> Formula:
        inside = Choice(_REACH + 3.0 - I1, _BY_FIRST, ZERO)
        return Choice(I1 - 3.0, inside, ZERO) if name == I1.name else ZERO

    def code(self) -> str:
        return "tension"


_STRAIN = TensionStrain()
_BY_FIRST = (1.0 + _STRAIN) ** 2.0 / (2.0 * _STRAIN * (3.0 + _STRAIN * (3.0 + _STRAIN)))


class TensionEnergy(Formula, frozen=True):
    """∫ σ dλ as a function of I1; only its derivatives are compiled.

    Attributes:
        stress: Of ``strain``, in any unit.
    """

    stress: Formula

    @property
    def parts(self) -> tuple[Variable, ...]:
        names = sorted(variables(self.stress) - {STRAIN.name})
        return I1, *map(Variable, names)

    def from_parts(self, values: Values, of: PartValues) -> Any:
        z = np.asarray(values[I1.name], dtype=float) - 3.0
        knots = (LARGEST - 1.0) * (np.arange(PIECES + 1) / PIECES) ** 1.5
        places, weights = np.polynomial.legendre.leggauss(_POINTS)
        places, weights = 0.5 + 0.5 * places, 0.5 * weights
        width = np.diff(knots)

        def at(strain: Any) -> Any:
            return self.stress.at({**values, STRAIN.name: strain}) + 0.0 * strain

        inner = at((knots[:-1, None] + width[:, None] * places).ravel())
        work = (inner.reshape(*inner.shape[:-1], PIECES, _POINTS) * weights).sum(axis=-1)
        whole = np.zeros((*work.shape[:-1], PIECES + 1))
        np.cumsum(work * width, axis=-1, out=whole[..., 1:])
        strain = np.atleast_1d(of(_STRAIN))
        piece = np.clip(np.searchsorted(knots, strain, side="right") - 1, 0, PIECES - 1)
        whole = np.broadcast_to(whole, (*strain.shape[:-1], PIECES + 1))
        found, left = np.take_along_axis(whole, piece, axis=-1), strain - knots[piece]
        for place, weight in zip(places.tolist(), weights.tolist(), strict=True):
            found = found + weight * left * at(knots[piece] + place * left)
        beyond = z - np.clip(z, 0.0, _REACH)
        return found.reshape(z.shape) + beyond * self.slope(I1.name).at(values)

    def slope(self, name: str) -> Formula:
        if name == I1.name:
            return replaced(self.stress, {STRAIN.name: _STRAIN}) * _BY_FIRST
        by = self.stress.slope(name)
        return ZERO if by == ZERO else TensionEnergy(by)

    def code(self) -> str:
        return f"work({self.stress.code()})"


#: Up to this, the stress at four times the length is still finite.
LARGEST_STIFFENING = 200.0


class Stiffening(Struct, frozen=True):
    """The law that follows from the ``stiffening`` of a tissue.

    Attributes:
        stiffening: The number k; at the strain 1/k, the stiffness is 2.718 times that at rest.
    """

    stiffening: Annotated[float, Real(units.NUMBER, above=0.0, at_most=LARGEST_STIFFENING)]

    def force(self) -> Formula:
        """Return the force of a bar under the stress E/k (exp(k ε) - 1)."""
        k = given(self.stiffening)
        return of_stress(MODULUS / k * (exp(k * STRAIN) - 1.0))
