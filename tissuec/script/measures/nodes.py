"""How many nodes a set, a body or a grip has."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("nodes")
class Nodes(ScalarMeasure):
    """The number of nodes of a set or body, or of those that a tool holds."""

    form = "count(nodes of A)"
    dimension = units.NUMBER
    subjects = 1
    takes = "nodes"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(len(snapshot.nodes(subjects[0])), snapshot)
