"""Contact: its area and its depth."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
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
    needs = ("faces",)
    of_contact = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(contact_extent(subjects[0], snapshot)[0], snapshot)


def contact_extent(subject: Subject, snapshot: Snapshot) -> tuple[ArrayLike, ArrayLike]:
    """Return the area [m²] and the depth [m] of contact of what a subject carries.

    Each is of shape (…), or 0 where nothing can touch.
    """
    contact = snapshot.state.touching
    if contact is None:
        return 0.0, 0.0
    return contact.extent_at(snapshot.nodes(subject), snapshot.position)


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
