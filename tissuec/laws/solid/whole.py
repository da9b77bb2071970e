"""Solids whose energy depends on shape and volume together, by Lamé's constants λ and μ."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import Formula, apply, exp
from tissuec.laws.principal import power_sum
from tissuec.laws.solid import COFACTORS, LAME, SOLID_LAWS, TRACE, J
from tissuec.laws.solid.stretches import OgdenTerms

_LOG = apply("log", (J,))


@SOLID_LAWS.member("saint venant kirchhoff")
class SaintVenantKirchhoff(Struct, frozen=True):
    """The energy λ/2 tr² E + μ tr E² of Green's strain E = (C - 1)/2, linear between S and E.

    (G. A. Holzapfel, Nonlinear Solid Mechanics, 2000, section 6.5.)
    """

    def energy(self) -> Formula:
        """Return λ/2μ tr² E + tr E²."""
        trace = 0.5 * (TRACE - 3.0)
        square = 0.25 * (TRACE**2 - 2.0 * COFACTORS - 2.0 * TRACE + 3.0)
        return 0.5 * LAME * trace**2 + square


@SOLID_LAWS.member("holmes mow")
class HolmesMow(Struct, frozen=True):
    """The energy H/4β (exp Q - 1) with H = λ + 2 μ.

    Q = β/H ((2 μ - λ) (I1 - 3) + λ (I2 - 3)) - 2 β ln J, with the invariants of C. (M. H.
    Holmes, V. C. Mow, J. Biomech. 23:1145, 1990, of cartilage.)

    Attributes:
        exponent: The number β.
    """

    exponent: Annotated[float, Real(units.NUMBER, above=0.0)]

    def energy(self) -> Formula:
        """Return H/4βμ (exp Q - 1)."""
        modulus = LAME + 2.0
        both = (2.0 - LAME) * (TRACE - 3.0) + LAME * (COFACTORS - 3.0)
        grown = exp(self.exponent * (both / modulus - 2.0 * _LOG))
        return modulus * (0.25 / self.exponent) * (grown - 1.0)


@SOLID_LAWS.member("unconstrained ogden")
class UnconstrainedOgden(OgdenTerms, frozen=True):
    """The energy Σ 2 μ s/a² (λ1^a + λ2^a + λ3^a - 3 - a ln J) + λ/2 (J - 1)².

    λ1 to λ3 are the principal stretches. (R. W. Ogden, Proc. R. Soc. Lond. A 328:567, 1972.)
    """

    def energy(self) -> Formula:
        """Return Σ 2 s/a² (Σ (λ^a - 1) - a ln J) + λ/2μ (J - 1)²."""
        found = 0.5 * LAME * (J - 1.0) ** 2
        for share, exponent in self.terms:
            stretched = power_sum(exponent, is_whole=True) - exponent * _LOG
            found = found + (2.0 * share / exponent**2) * stretched
        return found
