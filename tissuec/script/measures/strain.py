"""How far springs are stretched or compressed."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("strain")
class Strain(ScalarMeasure):
    """The largest |L - L0| / L0 of the intact springs of A; 0 without any.

    Springs with a rest length L0 of 0 have no strain and are skipped. If rest lengths flow, L0
    is the present one.
    """

    form = "strain(A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "any"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = snapshot.intact(subjects[0])
        rest = observables.rest_lengths(snapshot.state, snapshot.velocity, springs)
        ends = snapshot.state.springs.ends[springs]
        stretched = np.abs(observables.elongation(ends, snapshot.position, rest))
        has_length = rest > 0.0
        strain = np.where(has_length, stretched / np.where(has_length, rest, 1.0), 0.0)
        return one_column(strain.max(axis=-1, initial=0.0), snapshot)
