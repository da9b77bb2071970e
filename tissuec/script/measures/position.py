"""Where something is."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.vector import VectorMeasure


@MEASURES.member("position")
class Position(VectorMeasure):
    """The mean position of the nodes of A; NaN if a tool holds nothing."""

    form = "position(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        if not len(nodes):
            return np.full((*np.shape(snapshot.time), 3), np.nan)
        return snapshot.position[..., nodes, :].mean(axis=-2)
