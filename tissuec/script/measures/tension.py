"""How strongly springs pull."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.mechanics import observables
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("tension")
class Tension:
    """The tension c (L - L0) + d w of every spring of A, 0 once it is cut; the largest counts.

    It is negative in compression and includes relaxing branches. For a thread, it is that of
    its pieces, and of the knot of an open thread once that is tied.
    """

    form = "tension(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "springs"

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        network, springs = snapshot.state.network, subjects[0].springs
        knots = [thread.hold for thread in network.threads.values() if not thread.closed]
        names = zip(springs, network.springs.ids[springs], strict=True)
        return tuple("knot" if one in knots else f"spring {number}" for one, number in names)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs, state = subjects[0].springs, (snapshot.position, snapshot.velocity)
        tension = observables.tension(snapshot.state, *state, springs)
        for name, thread in snapshot.state.network.threads.items():
            (knot,) = np.nonzero(springs == thread.hold)
            if not len(knot):
                continue
            # While a knot slips, the spring beside it bears what it bears.
            tension[..., knot] += observables.tension(
                snapshot.state, *state, np.array([thread.slip])
            )
            if not thread.closed and name not in snapshot.state.knots:
                tension[..., knot] = np.nan
        return tension

    @staticmethod
    def value(sample: Floats) -> Floats:
        if not sample.shape[-1]:
            return np.zeros(sample.shape[:-1])
        return np.asarray(np.fmax.reduce(sample, axis=-1))
