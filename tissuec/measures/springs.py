"""How many springs are left."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.scalar import Scalar, one_column
from tissuec.network import Floats


@MEASURES.member("springs")
class Springs(Scalar):
    """The number of springs that were neither cut nor ruptured until then."""

    form = "count(springs of A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "any"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        return one_column(len(moment.intact(subjects[0])), moment)
