"""Contact: its area and its depth."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot

if TYPE_CHECKING:
    from tissuec.forces.contact.readings import Extent


@MEASURES.member("contact area")
class ContactArea(ScalarMeasure):
    """The present area of faces that the tool A touches, or of those of the body A that
    anything touches; 0 where contact acts on nodes.
    """

    form = "contact area(A)"
    dimension = units.AREA
    needs = ("faces",)
    of_contact = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(contact_extent(subjects[0], snapshot).area, snapshot)


@MEASURES.member("contact pressure")
class ContactPressure(ScalarMeasure):
    """The mean pressure over `contact area(A)`: the sum of the normal forces on these faces,
    divided by their present area; 0 without contact.

    Damping of contact is no part of it, nor are points on thin tools and threads. The field
    `contact pressure` shows where it is high.
    """

    form = "contact pressure(A)"
    dimension = units.PRESSURE
    needs = ("faces",)
    of_contact = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        found = contact_extent(subjects[0], snapshot)
        area = np.where(found.area > 0.0, found.area, np.inf)
        return one_column(found.force / area, snapshot)


def contact_extent(subject: Subject, snapshot: Snapshot) -> "Extent":
    """Return the extent of contact of what a subject carries; 0 where nothing can touch."""
    from tissuec.forces.contact.readings import Extent, extent_at

    contact = snapshot.state.touching
    if contact is None:
        none = np.zeros(np.shape(snapshot.time))
        return Extent(none, none, none)
    return extent_at(contact, snapshot.nodes(subject), snapshot.position)


@MEASURES.member("penetration")
class Penetration(ScalarMeasure):
    """The largest depth to which the tool A has sunk into what it touches, or anything into the
    body A, because contact is compliant.
    """

    form = "penetration(A)"
    dimension = units.LENGTH
    of_contact = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(contact_extent(subjects[0], snapshot).depth, snapshot)
