"""What whole runs in which elements break are checked for, be they of solids or of walls."""

import numpy as np

from tests.validate.scenes import silent
from tests.whole_runs import carried_out, same_when_resumed
from tissuec.validate.validation import validate


def ruptures(outcome):
    """Return times and events of ruptures."""
    return [(t, event) for t, event in outcome.logged_events if event.kind == "rupture"]


def first_ruptures(compiled):
    """Return when a scene first breaks by each of several methods [s].

    Args:
        compiled: Takes the entry ``method`` of ``simulate``.
    """
    found = []
    end = "when ruptured(strip): end the run"
    for method in ("dop853", "velocity verlet", "esdirk43", "rkc2"):
        outcome, _ = carried_out(compiled(method=f"integrator is {method}", script=end))
        found.append(ruptures(outcome)[0][0])
    return found


def the_ledger_closes(recording):
    """Check that what breaks is booked, and is at least a twentieth of the work."""
    _, rows = recording.energy_arrays()
    kinetic, elastic, gravity, work, dissipated, switched = rows.T
    total = kinetic + elastic + gravity
    np.testing.assert_allclose(total, work - dissipated + switched, atol=1e-5 * work.max())
    assert switched[0] == 0.0
    assert switched[-1] < -0.05 * work.max()


def breaks_alike_when_resumed(compiled):
    """Check that a strip whose run stops and goes on breaks at the same times, bit for bit."""
    whole, *parts = same_when_resumed(compiled, "ruptured of strip", 2, 4)
    for _, second in parts:
        assert [t for t, _ in second.logged_events] == [t for t, _ in whole.logged_events]


def the_reference_breaks_alike(compiled):
    """Return the compared ruptures, after checking that the reference has all of the run."""
    judged = validate(compiled, method="DOP853", rtol=None, progress=silent)
    assert judged.verdict == "kept", judged.reasons
    found = judged.comparison.ruptures
    assert found.run == found.reference > 0 and found.misses == ()
    return found
