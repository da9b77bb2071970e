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
    needs = ("sections",)


@MEASURES.member("face area")
class FaceArea(OfCutFaces):
    """The present area of both faces of all cuts and tears through the solid A.

    It does not include tissue that ties still hold. Without deformation, it is twice the area
    that the events of the cuts state.
    """

    form = "face area(cut faces of A)"
    title = "face area of cut faces"
    dimension = units.AREA

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return _of_faces(subjects[0], snapshot, lambda one: one.area(snapshot.position))


@MEASURES.member("largest opening")
class LargestOpening(OfCutFaces):
    """The largest distance between two points of opposite faces that coincide as drawn.

    Sliding counts as well. It is 0 before a cut.
    """

    form = "largest opening(cut faces of A)"
    title = "largest opening of cut faces"
    dimension = units.LENGTH

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return _of_faces(subjects[0], snapshot, lambda one: one.opening(snapshot.position))


@MEASURES.member("opening angle")
class OpeningAngle(OfCutFaces):
    """The angle between both faces of a cut at its end, such as 20 deg; radians in logs.

    It is averaged over the faces up to two elements behind the end, or over all faces if the
    cut goes through. It is 0 before a cut.
    """

    form = "opening angle(cut faces of A)"
    title = "opening angle of cut faces"
    dimension = units.NUMBER

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return _of_faces(subjects[0], snapshot, lambda one: one.angle(snapshot.position))


def _of_faces(
    subject: Subject, snapshot: Snapshot, value: "Callable[[CutFaces], Floats]"
) -> Floats:
    from tissuec.mechanics.cut_faces import CutFaces  # where it is asked

    faces = CutFaces.of(snapshot.state, subject.name)
    none = np.zeros(np.shape(snapshot.time))
    return one_column(none if faces is None else value(faces), snapshot)
