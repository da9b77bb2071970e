"""How an instrument is twisted."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.moment import Moment
from tissuec.script.measures.vector import Vector


@MEASURES.member("torque")
class Torque(Vector):
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
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        nodes = moment.nodes(subjects[0])
        if not len(nodes):
            return np.zeros((*np.shape(moment.time), 3))
        about = moment.position[..., nodes, :].mean(axis=-2)
        # Subtracted, so that no torque is 0 and not -0.
        return 0.0 - observables.torque_on(
            moment.state, moment.time, moment.position, moment.velocity, nodes, about
        )
