"""Solids whose energy depends on the invariants of their stretches."""

from typing import Annotated

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import ZERO, Formula, as_formula, exp
from tissuec.laws.solid import I1, I2, SOLID_LAWS, TRACE
from tissuec.laws.solid.volume import WithVolume


@SOLID_LAWS.member("mooney rivlin")
class MooneyRivlin(WithVolume, frozen=True):
    """The energy μ ((1 - s) (I1 - 3) + s (I2 - 3))/2. (M. Mooney, J. Appl. Phys. 11:582, 1940.)

    Attributes:
        share: The part s of the shear modulus that belongs to the second invariant.
    """

    share: Annotated[float, Real(units.NUMBER, at_least=0.0, at_most=1.0)]

    def energy(self) -> Formula:
        """Return ((1 - s) (I1 - 3) + s (I2 - 3))/2."""
        return 0.5 * ((1.0 - self.share) * (I1 - 3.0) + self.share * (I2 - 3.0))


@SOLID_LAWS.member("neo hookean")
class NeoHookean(WithVolume, frozen=True):
    """The energy μ (I1 - 3)/2, which does not stiffen.

    (R. S. Rivlin, Phil. Trans. Roy. Soc. A 240:459, 1948.)
    """

    def energy(self) -> Formula:
        """Return (I1 - 3)/2."""
        return 0.5 * (I1 - 3.0)


@SOLID_LAWS.member("coupled neo hookean")
class CoupledNeoHookean(WithVolume, frozen=True):
    """The energy μ (tr C - 3)/2 - μ ln J + λ U(J) of Lamé's constants λ and μ.

    U is ln² J/2 by default, or that of another ``volume``. (J. C. Simo, K. S. Pister, Comput.
    Meth. Appl. Mech. Eng. 46:201, 1984.)
    """

    def energy(self) -> Formula:
        """Return (tr C - 3)/2, without what depends on the volume alone."""
        return 0.5 * (TRACE - 3.0)


@SOLID_LAWS.member("yeoh")
class Yeoh(WithVolume, frozen=True):
    """The energy μ (z + c2 z² + c3 z³)/2 with z = I1 - 3.

    (O. H. Yeoh, Rubber Chem. Technol. 66:754, 1993.)

    Attributes:
        second: The number c2; a published C20 is μ c2/2.
        third: The number c3; a published C30 is μ c3/2.
    """

    second: Annotated[float, Real(units.NUMBER)]
    third: Annotated[float, Real(units.NUMBER, at_least=0.0)] = 0.0

    def energy(self) -> Formula:
        """Return (z + c2 z² + c3 z³)/2."""
        z = I1 - 3.0
        return 0.5 * (z + self.second * z**2 + self.third * z**3)


@SOLID_LAWS.member("exponential")
class SolidExponential(WithVolume, frozen=True):
    """The energy μ/2k (exp(k (I1 - 3)) - 1). (H. Demiray, J. Biomech. 5:309, 1972.)

    Attributes:
        stiffening: The number k.
    """

    stiffening: Annotated[float, Real(units.NUMBER, above=0.0)]

    def energy(self) -> Formula:
        """Return (exp(k (I1 - 3)) - 1)/2k."""
        return (exp(self.stiffening * (I1 - 3.0)) - 1.0) * (0.5 / self.stiffening)


@SOLID_LAWS.member("veronda westmann")
class VerondaWestmann(WithVolume, frozen=True):
    """The energy μ ((exp(k (I1 - 3)) - 1)/k - (I2 - 3)/2).

    (D. R. Veronda, R. A. Westmann, J. Biomech. 3:111, 1970, of the skin of cats.)

    Attributes:
        stiffening: The number k.
    """

    stiffening: Annotated[float, Real(units.NUMBER, above=0.0)]

    def energy(self) -> Formula:
        """Return (exp(k (I1 - 3)) - 1)/k - (I2 - 3)/2."""
        k = self.stiffening
        return (exp(k * (I1 - 3.0)) - 1.0) * (1.0 / k) - 0.5 * (I2 - 3.0)


#: Of the expansion of the inverse Langevin function by powers of I1 over the segments.
_OF_CHAINS = (1.0 / 2.0, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673750.0)


@SOLID_LAWS.member("arruda boyce")
class ArrudaBoyce(WithVolume, frozen=True):
    """The energy μ Σ c_i/N^(i-1) (I1^i - 3^i) over what makes μ the shear modulus at rest.

    These are the first five terms of chains of N segments. (E. M. Arruda, M. C. Boyce, J. Mech.
    Phys. Solids 41:389, 1993.)

    Attributes:
        segments: The number N; chains are straight where I1 is 3 N.
    """

    segments: Annotated[float, Real(units.NUMBER, above=0.0)]

    def energy(self) -> Formula:
        """Return Σ c_i/N^(i-1) (I1^i - 3^i) / 2 Σ i c_i (3/N)^(i-1)."""
        over, found, modulus, share = 1.0 / self.segments, ZERO, ZERO, as_formula(1.0)
        for k, each in enumerate(_OF_CHAINS, start=1):
            found = found + each * share * (I1**k - 3.0**k)
            modulus = modulus + 2.0 * k * each * share * 3.0 ** (k - 1)
            share = share * over
        return found / modulus
