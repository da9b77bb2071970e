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
    """The number of springs of A that broke by themselves until then; true where it is not 0.

    Torn by tension or crushed by pressure; the event log distinguishes both.
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
