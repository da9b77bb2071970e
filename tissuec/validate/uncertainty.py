"""How well a reference knows itself: by a second one with another error per step."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tissuec.network import Floats, Network
from tissuec.plan import Plan
from tissuec.validate.equations import largest
from tissuec.validate.reference import FINEST, default_rtol, reference
from tissuec.validate.solution import Reference

APART = 10.0  # ratio of the errors per step of the first two references
FINER = 100.0  # the same for each further one
BETTER = 10.0  # a reference must be known this much better than what it judges
WORTHWHILE = 3.0  # a finer reference that gains less than this has met sensitivity, not error

Progress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A reference and how well it is known.

    Attributes:
        reference: The finest one.
        coarser: The one before.
        uncertainty: Largest difference of a position between the two up to each row, relative
            to the largest displacement so far, shape (row,).
        is_sensitive: Whether finer steps did not bring references together: the motion itself
            amplifies differences of the size of rounding errors.
    """

    reference: Reference
    coarser: Reference
    uncertainty: Floats
    is_sensitive: bool

    def horizon(self, bound: float) -> float:
        """Return until when the reference is ``BETTER`` than a bound [s]; -inf if never."""
        fit = self.uncertainty <= bound / BETTER
        if fit.all():
            return float(self.reference.times[-1])
        first = int(np.argmin(fit))
        return float(self.reference.times[first - 1]) if first else -np.inf


def known_reference(
    network: Network,
    plan: Plan,
    times: Floats,
    *,
    method: str,
    rtol: float | None,
    progress: Progress,
) -> Known:
    """Return a reference that is as well known as the promise of a plan asks for, if one can be.

    Args:
        rtol: Error per step; None: a thousandth of the tolerance, and finer where it must be.
        progress: Told a stage and the simulated time [s].
    """
    size = floor_of(network)

    def solve(error: float) -> Reference:
        stage = f"reference, {method} with rtol {error:.0e}"
        return reference(
            network,
            plan,
            times,
            method=method,
            rtol=error,
            progress=lambda t: progress(stage, t),
        )

    finest = rtol or default_rtol(plan)
    pair = solve(APART * finest), solve(finest)
    known = Known(pair[1], pair[0], difference(*pair, size), False)
    promise = plan.simulation.tolerance
    if rtol is not None or promise is None:
        return known
    while known.uncertainty[-1] > promise / BETTER and known.reference.rtol > FINEST:
        finer = solve(max(known.reference.rtol / FINER, FINEST))
        better = Known(finer, known.reference, difference(known.reference, finer, size), False)
        if not _gained(known, better, promise, plan.simulation.duration):
            return Known(finer, known.reference, better.uncertainty, True)
        known = better
    return known


def _gained(known: Known, better: Known, promise: float, duration: float) -> bool:
    if better.uncertainty[-1] * WORTHWHILE < known.uncertainty[-1]:
        return True
    return better.horizon(promise) - known.horizon(promise) > 0.1 * duration


def floor_of(network: Network) -> float:
    """Return the displacement below which a promise asks for nothing [m]."""
    return 1e-6 * network.extent


def difference(first: Reference, second: Reference, floor: float) -> Floats:
    """Return how far two solutions are apart until each row, shape (row,)."""
    apart = [largest(a - b) for a, b in zip(first.position, second.position, strict=True)]
    return np.maximum.accumulate(relative(np.array(apart), second.displacement, floor))


def relative(error: Floats, scale: Floats, floor: float) -> Floats:
    """Return errors over scales that are never less than a floor; 0 where there is no error."""
    scale = np.maximum(scale, floor)
    return np.divide(error, scale, out=np.where(error > 0.0, np.inf, 0.0), where=scale > 0.0)
