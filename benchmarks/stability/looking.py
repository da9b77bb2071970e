"""A run of a stress scene, looked at from all sides: positions, energy, momentum."""

from collections.abc import Callable

import numpy as np
from msgspec import Struct

from benchmarks.rivals.walk import state_at_start
from tissuec.analysis.bench_solvers import BenchProblem, Deadline
from tissuec.core.structs import replace
from tissuec.model.network import Floats
from tissuec.script.plan import Plan
from tissuec.validate.engine_run import Observed, observe


class Look(Struct, frozen=True, eq=False):
    """What a run shows.

    Attributes:
        finite: Whether all positions and velocities are numbers.
        imbalance: Largest energy that is there and should not be, over the largest energy.
        made: The same, but only energy that came from nothing.
        drift: Largest change of momentum that no force explains, over the largest momentum
            of all parts; 0 where somebody holds nodes.
        method: That was used in the end.
        position: At the times of the problem [m], shape (row, node, 3).
    """

    finite: bool
    imbalance: float
    made: float
    drift: float
    method: str
    position: Floats


def look(problem: BenchProblem, plan: Plan, deadline: Deadline) -> tuple[Look | None, str]:
    """Return what a run shows, or None and why it could not go on.

    Raises:
        OutOfTime: The deadline has passed.
    """

    def progress(time: float) -> None:
        deadline.check()

    seen = observe(problem.network, plan, problem.times, progress)
    if seen.outcome.kind != "done":
        return None, seen.outcome.message
    finite = bool(np.isfinite(seen.position).all() and np.isfinite(seen.velocity).all())
    found = Look(
        finite=finite,
        imbalance=_part(np.abs, seen),
        made=_part(np.asarray, seen),
        drift=_drift(problem, seen),
        method=seen.outcome.statistics.method,
        position=seen.position,
    )
    return found, ""


def _part(of: Callable[[Floats], Floats], seen: Observed) -> float:
    """Return the largest imbalance over the largest energy until then."""
    wrong, scale = of(seen.imbalance), seen.scale
    safe = np.where(scale > 0.0, scale, 1.0)
    return float(np.max(wrong / safe, initial=0.0))


def _drift(problem: BenchProblem, seen: Observed) -> float:
    """Return the unexplained change of momentum of a net that nobody holds."""
    start = state_at_start(problem)
    if start.held.any() or start.braking.any() or start.loads or problem.plan.events:
        return 0.0
    mass, velocity = start.mass, seen.velocity
    due = (mass[:, None] * start.velocity).sum(axis=0) + np.outer(
        seen.times, mass.sum() * start.gravity
    )
    apart = np.linalg.norm(np.einsum("n,rnk->rk", mass, velocity) - due, axis=1)
    parts = np.einsum("n,rn->r", mass, np.linalg.norm(velocity, axis=2))
    largest = np.maximum.accumulate(parts)
    return float((apart / np.where(largest > 0.0, largest, 1.0)).max(initial=0.0))


def shaken(problem: BenchProblem, size: float) -> BenchProblem:
    """Return a problem whose nodes begin elsewhere by about a size [m]."""
    network = problem.network
    random = np.random.default_rng(0)
    position = network.position + size * random.standard_normal(network.position.shape)
    return replace(problem, network=replace(network, position=position))
