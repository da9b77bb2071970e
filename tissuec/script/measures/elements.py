"""How many finite elements are left."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("elements")
class IntactElements(ScalarMeasure):
    """The number of finite elements that have lost no edge to a cut and have not broken.

    All nodes of an element belong to A.
    """

    form = "count(elements of A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "nodes"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        state, count = snapshot.state, 0
        inside = np.zeros(state.network.node_count, dtype=bool)
        inside[snapshot.nodes(subjects[0])] = True
        for field in state.elements:
            own = np.array(inside[field.nodes].all(axis=1))
            own[field.lost_items(state.alive)] = False
            count += int(own.sum())
        return one_column(count, snapshot)
