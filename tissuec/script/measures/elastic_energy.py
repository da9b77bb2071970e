"""Energy stored in springs."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.moment import Moment
from tissuec.script.measures.scalar import Scalar, one_column


@MEASURES.member("elastic energy")
class ElasticEnergy(Scalar):
    """Σ ½ c (L - L0)² over the intact springs of A, and what their branches store."""

    form = "elastic energy(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "any"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        springs = moment.intact(subjects[0])
        energy = observables.elastic_energy(
            moment.state, moment.position, moment.velocity, springs
        )
        return one_column(energy, moment)
