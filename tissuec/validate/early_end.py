"""References of runs that were ended before their duration.

What ends a run may happen a little later in a reference, by the errors of both. A reference
therefore goes a little further, and what happens there counts only if it happened in the run.
"""

import numpy as np
from msgspec.structs import replace

from tissuec.script.plan import Plan
from tissuec.validate.engine_run import Observed
from tissuec.validate.reference import WITHOUT_PROMISE
from tissuec.validate.solution import Reference


def end_of_reference(plan: Plan, run: Observed) -> float:
    """Return until when a reference of a run must go [s]."""
    simulation, time = plan.simulation, run.outcome.state.time
    late = (simulation.tolerance or WITHOUT_PROMISE) * simulation.duration
    return time if run.outcome.ended is None else min(time + late, simulation.duration)


def without_later(reference: Reference, run: Observed) -> Reference:
    """Return a reference without what happened in it alone, after the end of the run."""
    end = run.outcome.state.time
    broken = np.concatenate([np.zeros(0, dtype=np.int64), *(one.springs for one in run.breaks)])
    fired = {one.trigger for one in run.firings}
    breaks = (
        one if one.time <= end else replace(one, springs=np.intersect1d(one.springs, broken))
        for one in reference.breaks
    )
    return replace(
        reference,
        breaks=tuple(one for one in breaks if len(one.springs)),
        firings=tuple(
            one for one in reference.firings if one.time <= end or one.trigger in fired
        ),
    )
