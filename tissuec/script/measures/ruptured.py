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

    They are torn by tension or crushed by compression; the event log distinguishes both. In
    bodies that are made of elements, it is the number of elements all of whose nodes belong to
    A.
    """

    form = "ruptured(A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "any"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        subject, network = subjects[0], snapshot.state.network
        springs = snapshot.springs(subject)
        if not subject.is_springs and network.marks:
            edges = network.edges[springs]
            springs = np.append(springs[~edges], snapshot.marks(subject))
        return one_column(np.count_nonzero(snapshot.ruptured[springs]), snapshot)
