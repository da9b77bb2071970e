"""Energy of motion."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("kinetic energy")
class KineticEnergy(ScalarMeasure):
    """Σ ½ m v² over the nodes of A that are not held."""

    form = "kinetic energy(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        return one_column(
            observables.kinetic_energy(snapshot.state, snapshot.velocity, nodes), snapshot
        )
