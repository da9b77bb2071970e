"""The reference solution of a plan, by SciPy's solvers."""

import time as clock
from collections.abc import Callable

import numpy as np

from tissuec.model.network import Floats, Network
from tissuec.script.plan import Plan
from tissuec.validate.reference_run import PhasedRun, ReferenceRun, StaticRun
from tissuec.validate.solution import Reference, Track

FINEST = 1e-13  # the smallest error per step that rounding leaves room for
WITHOUT_PROMISE = 1e-4  # replaces the tolerance where a scene has a fixed step


def default_rtol(plan: Plan) -> float:
    """Return the error per step that should make a reference far better than the promise."""
    return max((plan.simulation.tolerance or WITHOUT_PROMISE) / 1000.0, FINEST)


def reference(
    network: Network,
    plan: Plan,
    times: Floats,
    *,
    method: str = "DOP853",
    rtol: float | None = None,
    until: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Reference:
    """Return the solution of a plan.

    Args:
        network: The network.
        plan: The plan.
        times: Times of interest [s], ascending, shape (row,).
        method: One of SciPy's: DOP853, RK45, RK23, Radau, BDF or LSODA.
        rtol: Error per step relative to the largest displacement, speed and energy so far; a
            thousandth of the tolerance by default.
        until: Time at which the run ended early [s]; its whole duration by default.
        progress: Called with the simulated time [s] after each step.

    Raises:
        ReferenceFailure: SciPy's solver cannot continue.
    """
    started = clock.monotonic()
    track = Track(np.asarray(times, dtype=float), network.node_count)
    kind = ReferenceRun if not plan.static_intervals else PhasedRun
    kind = StaticRun if plan.simulation.is_static else kind
    run = kind(network, plan, track, method, rtol or default_rtol(plan))
    run.go(plan.simulation.duration if until is None else until, progress)
    run.effort.wall_time = clock.monotonic() - started
    return Reference(
        method=method,
        rtol=run.rtol,
        times=track.times,
        position=track.position,
        velocity=track.velocity,
        force=track.force,
        holders=tuple(track.holders),
        displacement=track.sizes[:, 0],
        speed=track.sizes[:, 1],
        energies=track.energies,
        initial=run.initial,
        breaks=tuple(run.breaks),
        firings=tuple(run.firings),
        strain=run.strain,
        effort=run.effort,
    )
