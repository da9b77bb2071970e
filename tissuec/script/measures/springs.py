"""How many springs are left."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("springs")
class IntactSprings(ScalarMeasure):
    """The number of springs of A that are neither cut nor ruptured."""

    form = "count(springs of A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "any"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(len(snapshot.intact(subjects[0])), snapshot)
