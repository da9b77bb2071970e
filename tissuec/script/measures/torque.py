"""How a tool is twisted."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.vector import VectorMeasure


@MEASURES.member("torque")
class Torque(VectorMeasure):
    """The support torque about the mean position of the nodes of A.

    It belongs to `force(A)`, with the same sign. About another point P, such as where the
    handle is held, it is larger by (position(A) - P) × force(A). In N m, which are the same as
    J; 0 for an empty grip.
    """

    form = "torque(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        if not len(nodes):
            return np.zeros((*np.shape(snapshot.time), 3))
        about = snapshot.position[..., nodes, :].mean(axis=-2)
        # Subtracted, so that no torque is 0 and not -0.
        return 0.0 - observables.torque_on(
            snapshot.state, snapshot.time, snapshot.position, snapshot.velocity, nodes, about
        )
