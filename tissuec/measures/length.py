"""How long a chain of springs is."""

from collections.abc import Sequence

from tissuec import mechanics
from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.scalar import Scalar, one_column
from tissuec.network import Floats


@MEASURES.member("length")
class Length(Scalar):
    """The sum of the present lengths of the intact springs of A."""

    form = "length(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "springs"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        springs = moment.intact(subjects[0])
        ends = moment.situation.network.ends[springs]
        total = mechanics.lengths(ends, moment.position).sum(axis=-1)
        return one_column(total, moment)
