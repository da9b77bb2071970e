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

    It belongs to `force(A)` and has the same sign. About another point P, such as the place
    where a hand holds the handle, the torque is larger by (position(A) - P) × force(A). Its
    unit N m equals J. It is 0 if a tool holds nothing.
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
