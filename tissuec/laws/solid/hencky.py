"""Solids that are linear in the logarithm of their stretches."""

from msgspec import Struct

from tissuec.laws.formula import Formula
from tissuec.laws.principal import squared_logarithms
from tissuec.laws.solid import SOLID_LAWS


@SOLID_LAWS.member("hencky")
class Hencky(Struct, frozen=True):
    """The energy μ Σ log² λ, λ being the stretches without the change of volume.

    (H. Hencky, Z. Techn. Phys. 9:215, 1928.)
    """

    def energy(self) -> Formula:
        """Return Σ log² λ."""
        return squared_logarithms()
