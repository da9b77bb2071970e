"""Reasons why a run cannot continue, and the spring or node that causes it."""

import numpy as np

from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Interruption
from tissuec.forces.springs.springs import measured, stretched
from tissuec.kernels.records import UNDERFLOW, UNSOLVED, Progress, Work
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices

MONSTROUS = 1e6  # lengths of a spring over the size of the drawing that no tissue reaches


def overloaded(state: State) -> Indices:
    """Return the intact springs and elements that break now, ascending, shape (n,)."""
    breaks = np.isfinite(state.springs.strength) | np.isfinite(state.springs.crush)
    able = np.flatnonzero(state.alive_springs & breaks)
    springs = state.springs.some(able)
    tension = stretched(springs, state.position, state.velocity).tension
    torn, crushed = tension > springs.strength, -tension > springs.crush
    found = [able[torn | crushed]]
    shapes = (field.breakable for field in state.fields)
    found += [each.broken(state.position) for each in shapes if each is not None]
    return np.sort(np.concatenate(found))


def is_flight(work: Work, progress: Progress, inputs: KernelInputs) -> bool:
    """Return whether nodes are far from their start although no spring is excessively long.

    Args:
        work: The arrays of the run.
        progress: State of the step loop.
        inputs: The network as the engine keeps it.
    """
    x, v = work.x[1 - progress.current], work.v[1 - progress.current]
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        return False
    size = max(inputs.state.network.extent, float(inputs.springs.rest.max(initial=0.0)))
    length, _ = measured(inputs.springs.ends, x.reshape(-1, 3))
    return bool((length <= MONSTROUS * size).all())


def explain(reason: int, work: Work, progress: Progress, inputs: KernelInputs) -> Interruption:
    """Return the interruption of a run whose last step could not be taken.

    Args:
        reason: Why the step loop returned.
        work: The arrays of the run.
        progress: State of the step loop.
        inputs: The network as the engine keeps it.
    """
    x, v = work.x[1 - progress.current], work.v[1 - progress.current]
    spring, node = _culprit(x, v, inputs), _jumping(work, progress, inputs)
    finite = all(np.isfinite(part).all() for part in (x, v, work.a[progress.current]))
    if reason == UNDERFLOW and finite:
        message = "the step size fell below the resolution of time in double precision"
        return Interruption("stuck", progress.time, spring=spring, node=node, message=message)
    if reason == UNSOLVED and finite:
        message = "Newton's method did not converge in an implicit step; use a smaller step"
        return Interruption("stuck", progress.time, spring=spring, node=node, message=message)
    message = "the motion grew without bounds"
    return Interruption("diverged", progress.time, spring=spring, node=node, message=message)


def _jumping(work: Work, progress: Progress, inputs: KernelInputs) -> int:
    """Return the node whose acceleration is undefined or jumps most in the last step."""
    jump = (work.a[1 - progress.current] - work.a[progress.current]).reshape(-1, 3)
    size = np.einsum("nk,nk->n", jump, jump)
    return int(inputs.layout.order[np.argmax(np.where(np.isfinite(size), size, np.inf))])


def _culprit(x: Floats, v: Floats, inputs: KernelInputs) -> int | None:
    """Return the first spring of undefined tension, else the one of the largest, if any."""
    springs = inputs.springs
    if not len(springs.ids):
        return None
    tension = np.abs(stretched(springs, x.reshape(-1, 3), v.reshape(-1, 3)).tension)
    undefined = np.flatnonzero(~np.isfinite(tension))
    if len(undefined):
        return int(springs.ids[undefined].min())
    largest = int(np.argmax(tension))
    return int(springs.ids[largest]) if tension[largest] else None
