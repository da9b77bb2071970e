"""Energy of motion."""

from collections.abc import Sequence

from tissuec import mechanics
from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.scalar import Scalar, one_column
from tissuec.network import Floats


@MEASURES.member("kinetic energy")
class KineticEnergy(Scalar):
    """Σ ½ m v² over the nodes of A that nobody holds."""

    form = "kinetic energy(A)"
    dimension = units.ENERGY
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        nodes = moment.nodes(subjects[0])
        return one_column(
            mechanics.kinetic_energy(moment.situation, moment.velocity, nodes), moment
        )
