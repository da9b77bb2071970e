"""How long a chain of springs is."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.moment import Moment
from tissuec.script.measures.scalar import Scalar, one_column


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
        ends = moment.state.network.ends[springs]
        total = observables.lengths(ends, moment.position).sum(axis=-1)
        return one_column(total, moment)
