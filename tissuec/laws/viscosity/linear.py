"""The linear dashpot, which every spring has unless its tissue says otherwise.

(W. Voigt, Ann. Phys. 283:671, 1892.)
"""

from msgspec import Struct

from tissuec.laws import LINEAR, VISCOSITY_LAWS
from tissuec.laws.formula import Formula


@VISCOSITY_LAWS.member("linear")
class LinearDashpot(Struct, frozen=True):
    """The force d w: in proportion to the speed."""

    def force(self) -> Formula:
        """Return d w."""
        return LINEAR.viscous
