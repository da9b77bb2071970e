"""Reasons why a run cannot continue, and the spring or node that causes it."""

import numpy as np
from numpy.typing import NDArray

from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Interruption
from tissuec.forces.branches import flat, tightened
from tissuec.kernels.records import UNDERFLOW, UNSOLVED, Progress, Work
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices

MONSTROUS = 1e6  # lengths of a spring over the size of the drawing that no tissue reaches


def overloaded(state: State) -> Indices:
    """Return the intact springs that tension or pressure breaks now, ascending, shape (n,)."""
    breaks = np.isfinite(state.springs.strength) | np.isfinite(state.springs.crush)
    able = np.flatnonzero(state.alive & breaks)
    low, high = state.springs.ends[able].T
    r = state.position[high] - state.position[low]
    w = state.velocity[high] - state.velocity[low]
    length = np.sqrt(np.einsum("sk,sk->s", r, r))
    closing = np.einsum("sk,sk->s", r, w) / np.where(length > 0.0, length, 1.0)
    springs, velocity = state.springs.some(able), flat(state.velocity)
    stretch = length - springs.rest
    tension = tightened(springs.behaviour, springs.inelastic, stretch, closing, velocity)
    torn, crushed = tension > springs.strength, -tension > springs.crush
    return able[torn | crushed]


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
    return bool((_lengths(x, inputs.springs.ends) <= MONSTROUS * size).all())


def explain(reason: int, work: Work, progress: Progress, inputs: KernelInputs) -> Interruption:
    """Return the interruption of a run whose last step could not be taken.

    Args:
        reason: Why the step loop returned.
        work: The arrays of the run.
        progress: State of the step loop.
        inputs: The network as the engine keeps it.
    """
    x, v = work.x[1 - progress.current], work.v[1 - progress.current]
    spring = _culprit(x, v, inputs)
    finite = all(np.isfinite(part).all() for part in (x, v, work.a[progress.current]))
    if reason == UNDERFLOW and finite:
        jump = (work.a[1 - progress.current] - work.a[progress.current]).reshape(-1, 3)
        node = int(inputs.layout.order[np.argmax(np.einsum("nk,nk->n", jump, jump))])
        message = "the step size fell below the resolution of time in double precision"
        return Interruption("stuck", progress.time, spring=spring, node=node, message=message)
    if reason == UNSOLVED and finite:
        message = "Newton's method did not converge in an implicit step; use a smaller step"
        return Interruption("stuck", progress.time, spring=spring, message=message)
    message = "the motion grew without bounds"
    return Interruption("diverged", progress.time, spring=spring, message=message)


def _lengths(x: Floats, ends: NDArray[np.integer]) -> Floats:
    r = x.reshape(-1, 3)[ends[:, 1]] - x.reshape(-1, 3)[ends[:, 0]]
    return np.sqrt(np.einsum("sk,sk->s", r, r))


def _culprit(x: Floats, v: Floats, inputs: KernelInputs) -> int | None:
    """Return the first spring of undefined tension, or else that of the largest."""
    springs = inputs.springs
    if not len(springs.ids):
        return None
    length, (low, high) = _lengths(x, springs.ends), springs.ends.T
    r = x.reshape(-1, 3)[high] - x.reshape(-1, 3)[low]
    w = v.reshape(-1, 3)[high] - v.reshape(-1, 3)[low]
    closing = np.einsum("sk,sk->s", r, w) / np.where(length > 0.0, length, 1.0)
    stretch = length - springs.rest
    tension = np.abs(tightened(springs.behaviour, springs.inelastic, stretch, closing, v))
    undefined = np.flatnonzero(~np.isfinite(tension))
    if len(undefined):
        return int(springs.ids[undefined].min())
    return int(springs.ids[np.argmax(tension)])
