"""Pressure inside a preserved volume."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("pressure")
class Pressure(ScalarMeasure):
    """The pressure that preserves the volume of the body A; 0 if it has no such pressure."""

    form = "pressure(A)"
    dimension = units.PRESSURE
    subjects = 1
    takes = "body"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        enclosure = snapshot.state.enclosure(subjects[0].name)
        if enclosure is None:
            return one_column(0.0, snapshot)
        each = enclosure.pressures(snapshot.time, snapshot.position) * enclosure.drawn
        return one_column(each.sum(axis=-1) / enclosure.drawn.sum(), snapshot)
