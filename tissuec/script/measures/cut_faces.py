"""Faces of cuts through solids: their area, and how far they are open."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot

if TYPE_CHECKING:
    from tissuec.mechanics.cut_faces import CutFaces

CUT_FACES = "cut faces"


class OfCutFaces(ScalarMeasure):
    """Base of the measures of faces of cuts."""

    takes = CUT_FACES
    needs = ("sections", "division")


@MEASURES.member("face area")
class FaceArea(OfCutFaces):
    """The present area of both faces of all cuts through the solid A, also of those of tears.

    What ties hold ahead of the end of a cut is no face. So without deformation, it is twice the
    area that the events of the cuts state.
    """

    form = "face area(cut faces of A)"
    dimension = units.AREA

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return _of_faces(subjects[0], snapshot, lambda one: one.area(snapshot.position))


@MEASURES.member("largest opening")
class LargestOpening(OfCutFaces):
    """The largest distance between points of both faces of a cut that are one as drawn.

    Faces that slide along each other are apart, too. It is 0 before a cut.
    """

    form = "largest opening(cut faces of A)"
    dimension = units.LENGTH

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return _of_faces(subjects[0], snapshot, lambda one: one.opening(snapshot.position))


@MEASURES.member("opening angle")
class OpeningAngle(OfCutFaces):
    """The angle between both faces of a cut at its end, such as 20 deg; radians in logs.

    It is the mean over the faces of those elements behind the end that begin within two
    elements of it; over all faces if the cut goes through. It is 0 before a cut.
    """

    form = "opening angle(cut faces of A)"
    dimension = units.NUMBER

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return _of_faces(subjects[0], snapshot, lambda one: one.angle(snapshot.position))


def _of_faces(
    subject: Subject, snapshot: Snapshot, value: "Callable[[CutFaces], Floats]"
) -> Floats:
    from tissuec.mechanics.cut_faces import CutFaces  # where it is asked

    faces = CutFaces.of(snapshot.state, body_of(subject))
    none = np.zeros(np.shape(snapshot.time))
    return one_column(none if faces is None else value(faces), snapshot)


def body_of(subject: Subject) -> str:
    """Return the name of the body of a subject that is named as its cut faces."""
    return subject.name.removeprefix(f"{CUT_FACES} of ")
