"""Where something is."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.vector import Vector
from tissuec.network import Floats


@MEASURES.member("position")
class Position(Vector):
    """The mean position of the nodes of A; no number for an empty grip."""

    form = "position(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        nodes = moment.nodes(subjects[0])
        if not len(nodes):
            return np.full((*np.shape(moment.time), 3), np.nan)
        return moment.position[..., nodes, :].mean(axis=-2)
