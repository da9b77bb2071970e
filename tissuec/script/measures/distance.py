"""How far apart two things are."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.position import Position
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("distance")
class Distance(ScalarMeasure):
    """The distance between the mean positions of A and of B; NaN if a tool holds nothing."""

    form = "distance(A, B)"
    dimension = units.LENGTH
    subjects = 2
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        first, second = (Position.sample((subject,), snapshot) for subject in subjects)
        return one_column(np.linalg.norm(second - first, axis=-1), snapshot)
