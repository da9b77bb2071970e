"""How hard jaws press."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.moment import Moment
from tissuec.script.measures.scalar import Scalar, one_column


@MEASURES.member("grip")
class Grip(Scalar):
    """The force with which the jaws of the forceps A press on what lies between them."""

    form = "grip(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        network, contact = moment.state.network, moment.state.contact
        jaws = next((t.jaws for t in network.tools if t.name == subjects[0].name), None)
        if contact is None or jaws is None:
            return one_column(np.zeros(np.shape(moment.time)), moment)
        upper, lower = jaws
        pressed = np.zeros(moment.position.shape)
        contact.add_forces(moment.time, moment.position, moment.velocity, pressed)
        place = moment.position
        apart = place[..., upper, :].mean(axis=-2) - place[..., lower, :].mean(axis=-2)
        apart = apart / np.linalg.norm(apart, axis=-1)[..., None]
        force = pressed[..., upper, :].sum(axis=-2) - pressed[..., lower, :].sum(axis=-2)
        return one_column(0.5 * (force * apart).sum(axis=-1), moment)
