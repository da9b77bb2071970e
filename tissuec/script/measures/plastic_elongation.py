"""How far the rest lengths of springs have flowed."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.forces.branches import flat
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.tension import Tension


@MEASURES.member("plastic elongation")
class PlasticElongation:
    """The largest plastic change of the rest length of the springs of A.

    It is negative if compression shortened a spring. Cut springs keep their value.
    """

    form = "plastic elongation(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "springs"
    columns = Tension.columns

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = subjects[0].springs
        memory = snapshot.state.springs.some(springs).inelastic
        if memory is None:
            return np.zeros((*snapshot.velocity.shape[:-2], len(springs)))
        return memory.flowed(flat(snapshot.velocity))

    @staticmethod
    def value(sample: Floats) -> Floats:
        return sample.max(axis=-1) if sample.shape[-1] else np.zeros(sample.shape[:-1])
