"""Energy of motion and energy stored in springs together."""

from collections.abc import Sequence

from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.elastic_energy import ElasticEnergy
from tissuec.measures.kinetic_energy import KineticEnergy
from tissuec.measures.moment import Moment
from tissuec.measures.scalar import Scalar
from tissuec.network import Floats


@MEASURES.member("energy")
class Energy(Scalar):
    """The kinetic and the elastic energy of A."""

    form = "energy(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        return KineticEnergy.sample(subjects, moment) + ElasticEnergy.sample(subjects, moment)
