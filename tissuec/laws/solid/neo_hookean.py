"""Solids as they are without any stiffening: the law of rubber at moderate strain."""

from msgspec import Struct

from tissuec.laws.formula import Formula
from tissuec.laws.solid import I1, SOLID_LAWS


@SOLID_LAWS.member("neo hookean")
class NeoHookean(Struct, frozen=True):
    """The energy μ (I1 - 3)/2, which does not stiffen.

    (R. S. Rivlin, Phil. Trans. Roy. Soc. A 240:459, 1948.)
    """

    def energy(self) -> Formula:
        """Return (I1 - 3)/2."""
        return 0.5 * (I1 - 3.0)
