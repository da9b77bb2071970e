"""Pressure inside a preserved volume, or of solid elements."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.stresses import mean_stress


@MEASURES.member("pressure")
class Pressure(ScalarMeasure):
    """The pressure that preserves the volume of the body A.

    Of nodes of solid elements, it is the hydrostatic pressure, minus a third of the trace of
    their mean stress. It is 0 if there is neither.
    """

    form = "pressure(A)"
    dimension = units.PRESSURE
    subjects = 1
    takes = "body or solid"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        enclosure = snapshot.state.enclosure(subjects[0].name)
        if enclosure is None:
            trace = np.trace(mean_stress(subjects[0], snapshot), axis1=-2, axis2=-1)
            return one_column(0.0 - trace / 3.0, snapshot)
        each = enclosure.pressures(snapshot.time, snapshot.position) * enclosure.drawn
        return one_column(each.sum(axis=-1) / enclosure.drawn.sum(), snapshot)
