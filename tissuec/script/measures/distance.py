"""How far apart two things are."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.moment import Moment
from tissuec.script.measures.position import Position
from tissuec.script.measures.scalar import Scalar, one_column


@MEASURES.member("distance")
class Distance(Scalar):
    """The distance between the mean positions of A and of B; NaN if a tool holds nothing."""

    form = "distance(A, B)"
    dimension = units.LENGTH
    subjects = 2
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        first, second = (Position.sample((subject,), moment) for subject in subjects)
        return one_column(np.linalg.norm(second - first, axis=-1), moment)
