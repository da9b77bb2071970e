"""How well the energy balance of the run closes."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("energy drift")
class EnergyDrift(ScalarMeasure):
    """The error of the energy balance, relative to the largest energy so far.

    |E - (E0 + work - dissipated + switched)| / scale, where E is the sum of kinetic, elastic
    and gravitational energy. The scale is the largest energy so far, but at least the energy of
    the stiffest spring stretched by a millionth of the size of the drawing. The drift is 0 if
    there is neither energy nor a spring.
    """

    form = "energy drift"
    dimension = units.NUMBER
    subjects = 0
    takes = "any"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        """Return the drift of a snapshot, dimensionless, shape (…, 1).

        Raises:
            ValueError: The run keeps no energy ledger.
        """
        if snapshot.ledger is None:
            raise ValueError("the energies were not integrated")
        balance = np.abs(snapshot.ledger.balance(snapshot.energies))
        scale = np.asarray(snapshot.ledger.scale, dtype=float)
        return one_column(
            np.where(scale > 0.0, balance / np.where(scale > 0.0, scale, 1.0), 0.0), snapshot
        )
