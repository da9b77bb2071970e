"""An elastic foundation: tissue around a body that keeps it in place.

Each node is held to where it is drawn by a spring and a dashpot that have no direction of their
own, by the area A of skin that it represents:

    F = -A (c (x - x0) + d v),    E = A c |x - x0|²/2.

(E. Winkler, *Die Lehre von der Elasticitaet und Festigkeit*, 1867.)
"""

from collections.abc import Sequence
from typing import Annotated

import numpy as np

from tissuec.autodiff import Numbers, Potential, Vector, square
from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.forces.acting import FORCES, Acted, Force
from tissuec.forces.potential_fields import PotentialField
from tissuec.kernels.records import Floats


@FORCES.member("foundation")
class Foundation(Force, frozen=True, eq=False):
    """Holds a surface at its drawn place, as the tissue around a body does.

    Attributes:
        stiffness: pressure per displacement, in all directions
        damping: pressure per velocity
    """

    stiffness: Annotated[float, Real(units.AREAL_STIFFNESS, above=0.0, example="20 kPa/m")]
    damping: Annotated[
        float, Real(units.AREAL_VISCOSITY, at_least=0.0, example="20 Pa*s/m")
    ] = 0.0

    def on(self, acted: Acted) -> "Bed":
        """Return the bed of some nodes.

        Raises:
            ValueError: None of the nodes is on a surface.
        """
        if not acted.area.any():
            raise ValueError("it acts on surfaces, but none of these nodes is on one")
        kept, none = acted.area > 0.0, np.zeros(0, dtype=np.int64)
        area = acted.area[kept]
        nodes, home = acted.nodes[kept, None], acted.position[kept]
        return Bed(none, none, nodes, home, self.stiffness * area, self.damping * area)


def _held(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the potential of a node."""
    stored = 0.5 * p.stiffness * square(x[0] - p.home)
    return Potential(stored, 0.5 * p.damping * square(v[0]))


class Bed(PotentialField, frozen=True):
    """Springs and dashpots between nodes and where they are drawn.

    Attributes:
        home: Where they are drawn [m], shape (n, 3).
        stiffness: A c of each [N/m], shape (n,).
        damping: A d of each [N s/m], shape (n,).
    """

    item_potential = staticmethod(_held)
    learnt = columns = ("stiffness", "damping", "home")

    home: Floats
    stiffness: Floats
    damping: Floats

    @property
    def is_damped(self) -> bool:
        """Return whether there are dashpots."""
        return bool(self.damping.any())
