"""What an instrument feels."""

from collections.abc import Sequence

from tissuec import mechanics
from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.measures.vector import Vector
from tissuec.network import Floats


@MEASURES.member("force")
class Force(Vector):
    """The support force: minus the sum of all inner forces on the nodes of A.

    Of a tool it is taken over what the tool holds then. It is what the instrument feels, the
    haptic force; weight and inertia of the nodes themselves are not in it.
    """

    form = "force(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "nodes"

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        nodes = moment.nodes(subjects[0])
        # Subtracted, so that no force is 0 and not -0.
        return 0.0 - mechanics.force_on(
            moment.situation, moment.time, moment.position, moment.velocity, nodes
        )
