"""How fast something moves."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.scalar import Scalar, one_column
from tissuec.network import Floats


@MEASURES.member("speed")
class Speed(Scalar):
    """The speed of the fastest node of A, 0 without any."""

    form = "speed(A)"
    dimension = units.VELOCITY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        velocity = moment.velocity[..., moment.nodes(subjects[0]), :]
        speed = np.linalg.norm(velocity, axis=-1)
        return one_column(speed.max(axis=-1, initial=0.0), moment)
