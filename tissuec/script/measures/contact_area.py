"""Over how much of a surface something touches."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("contact area")
class ContactArea(ScalarMeasure):
    """The drawn area of faces that the tool A touches, or of those of the body A that anything
    touches; 0 where contact acts on nodes.
    """

    form = "contact area(A)"
    dimension = units.AREA
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        contact, nodes = snapshot.state.touching, snapshot.nodes(subjects[0])
        if contact is None:
            return one_column(0.0, snapshot)
        return one_column(contact.extent_at(nodes, snapshot.position)[0], snapshot)
