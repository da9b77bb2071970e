"""What tools feel: forces and torques, and how hard jaws press."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, VectorMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("force")
class SupportForce(VectorMeasure):
    """The support force: minus the sum of all inner forces on the nodes of A.

    For a tool, the nodes are those that it holds at that time. It is the force that the
    instrument feels (the haptic force); it does not include the weight and inertia of the nodes
    themselves. Of nodes on a plane of symmetry, it includes what their mirror image, or the
    wall that the plane stands for, exerts on the part that is drawn. Of nodes that are
    all glued, it is the force of the glue on them. For scissors, it is the force that moves
    their blades on while they close along a line, from the cutting resistance of the tissue.
    For a scalpel, it includes the force of its edge on the tissue.
    """

    form = "force(A)"
    dimension = units.FORCE
    needs = ("support", "hold")
    feels_blades = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        # Subtracted, so that no force is 0 and not -0.
        felt = 0.0 - observables.force_on(
            snapshot.state, snapshot.time, snapshot.position, snapshot.velocity, nodes
        )
        tool = subjects[0].name if subjects[0].nodes is None else None
        for blades in snapshot.state.closing:
            if blades.tool == tool:
                felt = felt + blades.at(snapshot.time)
        return felt


@MEASURES.member("torque")
class Torque(VectorMeasure):
    """The support torque about the mean position of the nodes of A.

    It belongs to `force(A)` and has the same sign. About another point P, such as the place
    where a hand holds the handle, the torque is larger by (position(A) - P) × force(A). Its
    unit N m equals J. It is 0 if a tool holds nothing.
    """

    form = "torque(A)"
    dimension = units.ENERGY
    needs = ("support", "hold")

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


@MEASURES.member("grip")
class Grip(ScalarMeasure):
    """The force with which the jaws of the forceps A press on the tissue between them."""

    form = "grip(A)"
    dimension = units.FORCE
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
