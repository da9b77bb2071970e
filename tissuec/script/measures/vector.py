"""Common code of measures of a vector."""

from collections.abc import Sequence

import numpy as np

from tissuec.model.network import Floats
from tissuec.script.measures import Subject
from tissuec.script.measures.directed import DirectedMeasure
from tissuec.script.measures.snapshot import Snapshot


class VectorMeasure(DirectedMeasure):
    """Base of the measures whose components are x, y and z and whose value is the length."""

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        return ("x", "y", "z")

    @staticmethod
    def value(sample: Floats) -> Floats:
        return np.asarray(np.linalg.norm(sample, axis=-1))

    @staticmethod
    def along(sample: Floats, direction: Floats) -> Floats:
        return np.asarray(sample @ direction)
