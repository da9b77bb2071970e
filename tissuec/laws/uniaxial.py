"""Laws of matter by its stress in tension along one axis: from a curve, or that of Fung.

Of all incompressible solids with a curve, the one that is taken has an energy that depends on
I1 alone. Stretched by λ, its nominal stress is σ = 2 (λ - λ⁻²) dW/dI1 at I1 = λ² + 2/λ, so that
W = ∫ σ dλ. (R. S. Rivlin, D. W. Saunders, Phil. Trans. A 243:251, 1951.) Compression, shear and
equibiaxial tension follow from it.

Matter that stiffens after Fung has the nominal stress E/k (exp(k ε) - 1) in uniaxial tension
and compression, so that the stiffness grows linearly with the stress (Y. C. Fung, Am. J.
Physiol. 213:1532, 1967).
"""

from typing import Annotated

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import MODULUS, STRAIN, of_stress
from tissuec.laws.formula import Formula, Spline, exp
from tissuec.laws.solid import I1

LARGEST = 4.0  # stretch up to which the curve is followed; beyond, dW/dI1 stays
PIECES = 160  # of the curve: errors of the stress are below 1e-6 for exponential ones
_POINTS = 6  # of Gauss's quadrature on each


class OfTension(Struct, frozen=True):
    """A solid that follows a curve of nominal stress in uniaxial tension.

    Attributes:
        stress: [Pa], of ``strain``.
        modulus: Young's modulus [Pa] to which the energy refers.
    """

    stress: Formula
    modulus: float

    def energy(self) -> Formula:
        """Return 3/E ∫ σ dλ as a curve of i1."""
        strain = (LARGEST - 1.0) * (np.arange(PIECES + 1) / PIECES) ** 1.5
        places, weights = np.polynomial.legendre.leggauss(_POINTS)
        width = np.diff(strain)
        inner = strain[:-1, None] + width[:, None] * (0.5 + 0.5 * places)
        work = (self._at(inner) * 0.5 * weights).sum(axis=1) * width
        stretch = 1.0 + strain
        z = stretch**2 + 2.0 / stretch - 3.0
        z[0] = 0.0
        value = 3.0 / self.modulus * np.append(0.0, np.cumsum(work))
        slope = np.empty_like(z)
        slope[1:] = self._at(strain[1:]) / (stretch - stretch**-2)[1:]
        tiny = 1e-6 * strain[1]
        slope[0] = self._at(np.array([tiny]))[0] / (3.0 * tiny)
        slope *= 1.5 / self.modulus
        long = np.diff(z)
        secant = np.diff(value) / long
        bend = (3.0 * secant - 2.0 * slope[:-1] - slope[1:]) / long
        twist = (slope[:-1] + slope[1:] - 2.0 * secant) / long**2
        pieces = np.column_stack([value[:-1], slope[:-1], bend, twist])
        rows = [*pieces.tolist(), [value[-1], slope[-1], 0.0, 0.0]]
        return Spline(
            I1 - 3.0,
            tuple(z.tolist()),
            tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in rows),
            float(slope[0]),
        )

    def _at(self, strain: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> np.ndarray:
        found = self.stress.at({"strain": strain})
        return np.broadcast_to(np.asarray(found, dtype=float), strain.shape)


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
        return of_stress(MODULUS / self.stiffening * (exp(self.stiffening * STRAIN) - 1.0))
