"""The depth of penetration in contact."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.contact_area import contact_extent
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("penetration")
class Penetration(ScalarMeasure):
    """The largest depth to which the tool A has sunk into what it touches, or anything into the
    body A, because contact is compliant.
    """

    form = "penetration(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "nodes"
    of_contact = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(contact_extent(subjects[0], snapshot)[1], snapshot)
