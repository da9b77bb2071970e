"""Why a run cannot go on, and which spring or node is to blame."""

import numpy as np

from tissuec.engine.kernel_inputs import Layout, Springs
from tissuec.engine.method import Interruption
from tissuec.forces.branches import flat, tightened
from tissuec.kernels.records import UNDERFLOW, UNSOLVED, Progress, Work
from tissuec.mechanics.situation import Situation
from tissuec.model.network import Floats, Indices

MONSTROUS = 1e6  # lengths of a spring over the size of the drawing that no tissue reaches


def overloaded(situation: Situation) -> Indices:
    """Return the living springs that tension or pressure breaks now, ascending."""
    breaks = np.isfinite(situation.strength) | np.isfinite(situation.crush)
    able = np.flatnonzero(situation.alive & breaks)
    low, high = situation.network.ends[able].T
    r = situation.position[high] - situation.position[low]
    w = situation.velocity[high] - situation.velocity[low]
    length = np.sqrt(np.einsum("sk,sk->s", r, r))
    closing = np.einsum("sk,sk->s", r, w) / np.where(length > 0.0, length, 1.0)
    behaviour = situation.behaviour(able)
    memory, velocity = situation.memory(able), flat(situation.velocity)
    tension = tightened(behaviour, memory, length - behaviour.rest, closing, velocity)
    torn, crushed = tension > situation.strength[able], -tension > situation.crush[able]
    return able[torn | crushed]


def is_flight(work: Work, progress: Progress, layout: Layout) -> bool:
    """Tell whether nodes are far from where they began although no spring is overlong."""
    x, v = work.x[1 - progress.current], work.v[1 - progress.current]
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        return False
    size = max(layout.situation.network.extent, float(layout.springs.rest.max(initial=0.0)))
    return bool((_lengths(x, layout.springs) <= MONSTROUS * size).all())


def explain(reason: int, work: Work, progress: Progress, layout: Layout) -> Interruption:
    """Return the interruption of a run whose last step could not be taken."""
    x, v = work.x[1 - progress.current], work.v[1 - progress.current]
    spring = _culprit(x, v, layout)
    finite = all(np.isfinite(part).all() for part in (x, v, work.a[progress.current]))
    if reason == UNDERFLOW and finite:
        jump = (work.a[1 - progress.current] - work.a[progress.current]).reshape(-1, 3)
        node = int(layout.order[np.argmax(np.einsum("nk,nk->n", jump, jump))])
        message = "the step size fell below the resolution of time in double precision"
        return Interruption("stuck", progress.time, spring=spring, node=node, message=message)
    if reason == UNSOLVED and finite:
        message = "Newton's method did not converge in an implicit step; use a smaller step"
        return Interruption("stuck", progress.time, spring=spring, message=message)
    message = "the motion grew without bounds"
    return Interruption("diverged", progress.time, spring=spring, message=message)


def _lengths(x: Floats, springs: Springs) -> Floats:
    r = x.reshape(-1, 3)[springs.high] - x.reshape(-1, 3)[springs.low]
    return np.sqrt(np.einsum("sk,sk->s", r, r))


def _culprit(x: Floats, v: Floats, layout: Layout) -> int | None:
    """Return the first spring of undefined tension, or else that of the largest."""
    springs = layout.springs
    if not len(springs.ids):
        return None
    length = _lengths(x, springs)
    r = x.reshape(-1, 3)[springs.high] - x.reshape(-1, 3)[springs.low]
    w = v.reshape(-1, 3)[springs.high] - v.reshape(-1, 3)[springs.low]
    closing = np.einsum("sk,sk->s", r, w) / np.where(length > 0.0, length, 1.0)
    tension = np.abs(springs.tension(length - springs.rest, closing, v))
    undefined = np.flatnonzero(~np.isfinite(tension))
    if len(undefined):
        return int(springs.ids[undefined].min())
    return int(springs.ids[np.argmax(tension)])
