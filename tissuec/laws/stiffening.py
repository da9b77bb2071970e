"""The law of Fung for matter that stiffens, with the stiffness of the tissue at rest.

In uniaxial tension and compression, the nominal stress is E/k (exp(k ε) - 1), so that the
stiffness grows linearly with the stress (Y. C. Fung, Am. J. Physiol. 213:1532, 1967).
"""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import MODULUS, STRAIN, of_stress
from tissuec.laws.formula import Formula, exp

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
