"""Springs with memory: branches that relax, and rest lengths that flow.

A spring of elongation e = L - L0 - p, whose rest length has flowed by p, pulls with

    T = S + g(w),    S = f(e) + Σ c1 (e - q),    w = L',
    q' = (e - q) / τ,    p' = max(0, |S| - F) sign(S) / η.

A branch is a spring c1 and a dashpot c1 τ in a row, beside the spring; q is what its dashpot
gave way by. One of them makes the standard linear solid, several a Prony series. Above the
yield force F the rest length flows with the viscosity η (E. C. Bingham, Fluidity and
Plasticity, 1922), under spring and branches together, and beside the dashpot g. A branch
stores ½ c1 (e - q)²; c1 (e - q) q' and S p' are lost, neither of them ever negative.
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.kernels.records import InternalVariables
from tissuec.laws.evaluation import Behaviour
from tissuec.model.inelastic import Inelastic

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def flat(velocity: Floats) -> Floats:
    """Return velocities of shape (…, node, 3) [m/s] as flat components, shape (…, 3 node)."""
    return velocity.reshape(*velocity.shape[:-2], -1)


def pulled(
    behaviour: Behaviour, inelastic: Inelastic | None, stretch: Floats, velocity: Floats
) -> Floats:
    """Return the force S of springs with or without memory [N], shape (…, spring).

    Args:
        behaviour: Laws and numbers of the springs.
        inelastic: Their branches and flow, None if there are none.
        stretch: L - L0 [m], shape (…, spring).
        velocity: Of all nodes [m/s], flat, shape (…, 3 node).
    """
    if inelastic is None:
        return behaviour.pull(stretch)
    variables = inelastic.variables(velocity)
    e = stretch - variables[..., -1, :]
    return behaviour.pull(e) + inelastic.pull(e, variables)


def elongated(inelastic: Inelastic | None, stretch: Floats, velocity: Floats) -> Floats:
    """Return the elongation e = L - L0 - p, p being the flow [m], shape (…, spring).

    Args:
        inelastic: Branches and flow of the springs, None if there are none.
        stretch: L - L0 [m], shape (…, spring).
        velocity: Of all nodes [m/s], flat, shape (…, 3 node).
    """
    return stretch if inelastic is None else stretch - inelastic.flowed(velocity)


def tightened(
    behaviour: Behaviour,
    inelastic: Inelastic | None,
    stretch: Floats,
    closing: Floats,
    velocity: Floats,
) -> Floats:
    """Return the tension S + g(e, w) of springs with or without memory [N], shape (…, spring).

    Args:
        behaviour: Laws and numbers of the springs.
        inelastic: Their branches and flow, None if there are none.
        stretch: L - L0 [m], shape (…, spring).
        closing: w, the rate of lengthening [m/s], shape (…, spring).
        velocity: Of all nodes [m/s], flat, shape (…, 3 node).
    """
    braking = behaviour.brake(elongated(inelastic, stretch, velocity), closing)
    return pulled(behaviour, inelastic, stretch, velocity) + braking


def table_of(inelastic: Inelastic, nodes: Indices, home: Floats) -> InternalVariables:
    """Return the record that kernels read.

    Args:
        inelastic: Of the springs that act, with places of nodes.
        nodes: Places of the nodes that variables are kept in, shape (m,).
        home: Where these stay [m], shape (m, 3).
    """
    has = inelastic.slot >= 0
    spring, branch = np.nonzero(has[:-1].T)
    flowing = np.flatnonzero(has[-1])
    flow = np.full(has.shape[1], -1)
    flow[flowing] = len(spring) + np.arange(len(flowing))
    chosen = np.append(branch, np.full(len(flowing), -1)), np.append(spring, flowing)
    return InternalVariables(
        first=np.concatenate([[0], np.cumsum(has[:-1].sum(axis=0))]).astype(np.int64),
        constant=inelastic.constant[branch, spring],
        pace=1.0 / inelastic.time[branch, spring],
        flow=flow,
        limit=inelastic.limit,
        viscosity=inelastic.viscosity,
        slot=inelastic.slot[chosen],
        rate=inelastic.rate[chosen],
        scale=1.0 / inelastic.rate[chosen],
        change=np.zeros(len(chosen[0])),
        nodes=nodes,
        home=home,
    )
