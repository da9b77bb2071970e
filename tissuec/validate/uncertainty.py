"""The uncertainty of a reference, from a second one with other steps.

The second one also begins from masses and rest lengths that differ by rounding. Where a motion
amplifies that (a symmetric tube that collapses, a chain that buckles), no solution is better
known than the two agree, however fine its steps; two that share every rounding could agree by
chance.
"""

from collections.abc import Callable

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.model.network import Floats, Network
from tissuec.script.plan import Plan
from tissuec.validate.equations import largest
from tissuec.validate.reference import FINEST, default_rtol, reference
from tissuec.validate.solution import Reference

APART = 10.0  # ratio of the errors per step of a reference and of its second one
FINER = 100.0  # ratio of the errors per step of a reference and of the next that is tried
BETTER = 10.0  # a reference must be known this much better than what it judges
WORTHWHILE = 3.0  # a finer reference that gains less than this has met sensitivity, not error

Progress = Callable[[str, float], None]


class EstimatedReference(Struct, frozen=True, eq=False):
    """A reference and how well it is known.

    Attributes:
        reference: The reference.
        second: One of a net that differs by rounding, with a larger error per step, and steps
            that land on every other time only: where output times are close, they and not the
            errors rule the steps of both, and two equal solutions would show nothing.
        uncertainty: Largest difference of a position between the two up to each row, relative
            to the largest displacement so far, shape (row,).
        is_sensitive: Whether finer steps did not bring references together: the motion itself
            amplifies differences of the size of rounding errors.
    """

    reference: Reference
    second: Reference
    uncertainty: Floats
    is_sensitive: bool = False

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
    until: float | None = None,
) -> EstimatedReference:
    """Return a reference that is as accurate as the tolerance requires, if possible.

    Args:
        times: Times of interest [s], ascending, shape (row,).
        method: One of SciPy's methods.
        rtol: Error per step; None: a thousandth of the tolerance, and finer where necessary.
        progress: Called with a stage and the simulated time [s].
        until: See ``reference``.
    """

    def solve(network: Network, times: Floats, error: float) -> Reference:
        stage = f"reference, {method} with rtol {error:.0e}"
        return reference(
            network,
            plan,
            times,
            method=method,
            rtol=error,
            until=until,
            progress=lambda time: progress(stage, time),
        )

    def pair(error: float) -> EstimatedReference:
        second = solve(shaken(network), every_other(times), APART * error)
        first = solve(network, times, error)
        return EstimatedReference(first, second, uncertainty(first, second, network))

    known, promise = pair(rtol or default_rtol(plan)), plan.simulation.tolerance
    if rtol is not None or promise is None:
        return known
    while known.uncertainty[-1] > promise / BETTER and known.reference.rtol > FINEST:
        better = pair(max(known.reference.rtol / FINER, FINEST))
        if not _gained(known, better, promise, plan.simulation.duration):
            return replace(better, is_sensitive=True)
        known = better
    return known


def _gained(
    known: EstimatedReference, better: EstimatedReference, promise: float, duration: float
) -> bool:
    if better.uncertainty[-1] * WORTHWHILE < known.uncertainty[-1]:
        return True
    return better.horizon(promise) - known.horizon(promise) > 0.1 * duration


def floor_of(network: Network) -> float:
    """Return the displacement below which nothing is promised [m]."""
    return 1e-6 * network.extent


def resolution_of(network: Network) -> float:
    """Return the difference of positions that rounding alone makes [m].

    Coordinates are known to half a unit in the last place; what adds up to one is a few.
    """
    return 16.0 * np.finfo(float).eps * float(np.abs(network.position).max(initial=0.0))


def shaken(network: Network) -> Network:
    """Return a network whose masses and rest lengths differ in the last place only."""
    random = np.random.default_rng(0)

    def shake(values: Floats) -> Floats:
        signs = random.choice([-1.0, 1.0], len(values))
        return values * (1.0 + 2.0 * np.finfo(float).eps * signs)

    return network.with_arrays(
        {"mass": shake(network.mass), "rest": shake(network.springs.rest)}
    )


def every_other(times: Floats) -> Floats:
    """Return every other time and the last [s], shape (row,)."""
    return np.union1d(times[::2], times[-1:])


def uncertainty(first: Reference, second: Reference, network: Network) -> Floats:
    """Return the largest relative distance of two solutions until each row of the first.

    The result is dimensionless and has the shape (row,).

    Args:
        first: One solution.
        second: Another one at some of the times of the first, including the last; times in
            between count as the next one does.
    """
    shared = np.searchsorted(first.times, second.times)
    pairs = zip(first.position[shared], second.position, strict=True)
    apart = np.array([largest(a - b) for a, b in pairs])
    errors = relative_positions(apart, first.displacement[shared], network)
    known = np.maximum.accumulate(errors)
    return known[np.searchsorted(shared, np.arange(len(first.times)))]


def relative_positions(error: Floats, displacement: Floats, network: Network) -> Floats:
    """Return errors of positions as the tolerance of a scene defines them, dimensionless.

    They are relative to the largest displacement so far, and never to less than a millionth of
    the size of the scene; rounding errors of coordinates do not count.

    Args:
        error: Distances [m], shape (row,).
        displacement: Largest displacement so far [m], shape (row,).
    """
    beyond = np.maximum(error - resolution_of(network), 0.0)
    return relative(beyond, displacement, floor_of(network))


def relative(error: Floats, scale: Floats, floor: float) -> Floats:
    """Return errors divided by scales, dimensionless, shape (row,); 0 where there is no error.

    Args:
        error: In any unit, shape (row,).
        scale: In the same unit, shape (row,).
        floor: Smallest scale.
    """
    scale = np.maximum(scale, floor)
    return np.divide(error, scale, out=np.where(error > 0.0, np.inf, 0.0), where=scale > 0.0)
