"""Whether springs have broken by themselves."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("ruptured")
class Ruptured(ScalarMeasure):
    """The number of springs of A that have broken by themselves; true if it is not 0.

    They are torn by tension or crushed by compression; the event log distinguishes both.
    """

    form = "ruptured(A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "any"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(
            np.count_nonzero(snapshot.ruptured[snapshot.springs(subjects[0])]), snapshot
        )
