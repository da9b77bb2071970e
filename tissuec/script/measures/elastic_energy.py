"""Energy stored in springs."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.scalar import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("elastic energy")
class ElasticEnergy(ScalarMeasure):
    """Σ ½ c (L - L0)² over the intact springs of A, and the energy of their branches."""

    form = "elastic energy(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "any"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = snapshot.intact(subjects[0])
        energy = observables.elastic_energy(
            snapshot.state, snapshot.position, snapshot.velocity, springs
        )
        return one_column(energy, snapshot)
