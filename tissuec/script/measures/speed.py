"""How fast something moves."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("speed")
class Speed(ScalarMeasure):
    """The speed of the fastest node of A; 0 if A has no nodes."""

    form = "speed(A)"
    dimension = units.VELOCITY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        velocity = snapshot.velocity[..., snapshot.nodes(subjects[0]), :]
        speed = np.linalg.norm(velocity, axis=-1)
        return one_column(speed.max(axis=-1, initial=0.0), snapshot)
