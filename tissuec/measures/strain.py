"""How far springs are stretched or compressed."""

from collections.abc import Sequence

import numpy as np

from tissuec import mechanics
from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.scalar import Scalar, one_column
from tissuec.network import Floats


@MEASURES.member("strain")
class Strain(Scalar):
    """The largest |L - L0| / L0 among the intact springs of A, 0 without any.

    A spring whose rest length L0 is 0 has no strain and is passed over.
    """

    form = "strain(A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "any"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        springs = moment.intact(subjects[0])
        rest = moment.situation.rest[..., springs]
        some = (rest > 0.0).reshape(-1, len(springs)).all(axis=0)
        springs, rest = springs[some], rest[..., some]
        ends = moment.situation.network.ends[springs]
        strain = np.abs(mechanics.elongation(ends, moment.position, rest)) / rest
        return one_column(strain.max(axis=-1, initial=0.0), moment)
