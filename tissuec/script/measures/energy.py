"""Energy of motion and energy stored in springs together."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.elastic_energy import ElasticEnergy
from tissuec.script.measures.kinetic_energy import KineticEnergy
from tissuec.script.measures.scalar import ScalarMeasure
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("energy")
class Energy(ScalarMeasure):
    """The sum of the kinetic and the elastic energy of A."""

    form = "energy(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return KineticEnergy.sample(subjects, snapshot) + ElasticEnergy.sample(
            subjects, snapshot
        )
