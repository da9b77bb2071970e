"""Solids whose energy depends on powers or logarithms of their principal stretches."""

from typing import Annotated, ClassVar

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import ZERO, Formula
from tissuec.laws.principal import power_sum, squared_logarithms
from tissuec.laws.solid import SOLID_LAWS
from tissuec.laws.solid.volume import LOGARITHMIC, VolumeName, WithVolume

LEAST = 0.01  # size of an exponent
_Exponent = Annotated[float, Real(units.NUMBER, at_least=-60.0, at_most=60.0)]
_Share = Annotated[float, Real(units.NUMBER, at_least=0.0, at_most=1.0)]


class OgdenTerms(Struct, frozen=True):
    """One to three terms of stretches.

    Attributes:
        exponent: The first a; the first share is what the others leave.
        second_exponent: Of the second term.
        second_share: Of the second term; of a published pair, it is μ2 α2/2μ.
        third_exponent: Of the third term.
        third_share: Of the third term.
    """

    _limit: ClassVar[str] = ""  # what to take instead of smaller exponents
    exponent: _Exponent
    second_exponent: _Exponent = 2.0
    second_share: _Share = 0.0
    third_exponent: _Exponent = 2.0
    third_share: _Share = 0.0

    def __post_init__(self) -> None:
        for name in ("exponent", "second_exponent", "third_exponent"):
            exponent: float | Formula = getattr(self, name)
            if not isinstance(exponent, Formula) and abs(exponent) < LEAST:
                written = name.replace("_", " ")
                raise ValueError(
                    f'"{written}" must be at least {LEAST} or at most -{LEAST}{self._limit}'
                )
        both: float | Formula = self.second_share + self.third_share
        if not isinstance(both, Formula) and both > 1.0:
            raise ValueError('"second share" and "third share" are more than 1 together')

    @property
    def terms(self) -> list[tuple[float, float]]:
        """Return shares and exponents of the terms; those that are learnt are variables."""
        every = (
            (1.0 - self.second_share - self.third_share, self.exponent),
            (self.second_share, self.second_exponent),
            (self.third_share, self.third_exponent),
        )
        return [(share, exponent) for share, exponent in every if share]


@SOLID_LAWS.member("ogden")
class Ogden(OgdenTerms, frozen=True):
    """The energy Σ 2 μ s/a² (λ1^a + λ2^a + λ3^a - 3), over one to three exponents a.

    λ1 to λ3 are the principal stretches without the change of volume. The shares s of the shear
    modulus sum up to 1. (R. W. Ogden, Proc. R. Soc. Lond. A 326:565, 1972.)

    Attributes:
        volume: One of ``VOLUMES``.
    """

    _limit: ClassVar[str] = "; the limit of 0 is the law hencky"
    volume: VolumeName = LOGARITHMIC

    def energy(self) -> Formula:
        """Return Σ 2 s/a² Σ (λ^a - 1)."""
        found: Formula = ZERO
        for share, exponent in self.terms:
            found = found + (2.0 * share / exponent**2) * power_sum(exponent)
        return found


@SOLID_LAWS.member("hencky")
class Hencky(WithVolume, frozen=True):
    """The energy μ Σ log² λ, λ being the stretches without the change of volume.

    (H. Hencky, Z. Techn. Phys. 9:215, 1928.)
    """

    def energy(self) -> Formula:
        """Return Σ log² λ."""
        return squared_logarithms()
