"""How hard jaws press."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("grip")
class Grip(ScalarMeasure):
    """The force with which the jaws of the forceps A press on the tissue between them."""

    form = "grip(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "jaws"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        network, contact = snapshot.state.network, snapshot.state.contact
        jaws = next((t.jaws for t in network.tools if t.name == subjects[0].name), None)
        if contact is None or jaws is None:
            return one_column(np.zeros(np.shape(snapshot.time)), snapshot)
        upper, lower = jaws
        pressed = np.zeros(snapshot.position.shape)
        contact.add_forces(snapshot.time, snapshot.position, snapshot.velocity, pressed)
        place = snapshot.position
        apart = place[..., upper, :].mean(axis=-2) - place[..., lower, :].mean(axis=-2)
        apart = apart / np.linalg.norm(apart, axis=-1)[..., None]
        force = pressed[..., upper, :].sum(axis=-2) - pressed[..., lower, :].sum(axis=-2)
        return one_column(0.5 * (force * apart).sum(axis=-1), snapshot)
