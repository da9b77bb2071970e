"""What a tool feels."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.vector import VectorMeasure


@MEASURES.member("force")
class SupportForce(VectorMeasure):
    """The support force: minus the sum of all inner forces on the nodes of A.

    For a tool, the nodes are those that it holds at that time. It is the force that the
    instrument feels (the haptic force); it does not include weight and inertia of the nodes
    themselves. For scissors, it is the force that moves their blades on while they close along
    a line, from the cutting resistance of the tissue.
    """

    form = "force(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "nodes"
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
