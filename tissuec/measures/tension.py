"""How strongly springs pull."""

from collections.abc import Sequence

from tissuec import mechanics
from tissuec.core import units
from tissuec.measures import MEASURES, Subject
from tissuec.measures.moment import Moment
from tissuec.network import Floats


@MEASURES.member("tension")
class Tension:
    """The tension c (L - L0) + d w of every spring of A, 0 once it is cut; the largest counts.

    A spring under pressure has a negative tension. Relaxing branches are part of it.
    """

    form = "tension(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "springs"

    @staticmethod
    def columns(subjects: Sequence[Subject], moment: Moment) -> tuple[str, ...]:
        ids = moment.situation.network.spring_ids[subjects[0].springs]
        return tuple(f"spring {number}" for number in ids)

    @staticmethod
    def sample(subjects: Sequence[Subject], moment: Moment) -> Floats:
        springs = subjects[0].springs
        return mechanics.tension(moment.situation, moment.position, moment.velocity, springs)

    @staticmethod
    def value(sample: Floats) -> float:
        return float(sample.max()) if len(sample) else 0.0
