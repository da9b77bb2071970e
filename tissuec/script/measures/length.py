"""How long a chain of springs is."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("length")
class Length(ScalarMeasure):
    """The sum of the present lengths of the intact springs of A."""

    form = "length(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "springs"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = snapshot.intact(subjects[0])
        ends = snapshot.state.springs.ends[springs]
        total = observables.lengths(ends, snapshot.position).sum(axis=-1)
        return one_column(total, snapshot)
