"""Compiled derivatives of accelerations, and the matrices of implicit steps and equilibria."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import sparse

from tissuec.compiled.calls import Shipped
from tissuec.engine.integrators import derivatives_kernel as steps
from tissuec.forces import accelerations_derivatives_kernel as accelerations
from tissuec.kernels.derivative_records import NodeState
from tissuec.learn.derivatives.stepping import LegForces
from tissuec.mechanics.guiding import free_projection
from tissuec.mechanics.stiffness import LowRankFactor, SparseFactor
from tissuec.model.network import Floats


class AccelerationMatrices(NamedTuple):
    """Derivatives of accelerations; those by positions are ``by_x`` - M⁻¹ W Wᵀ.

    Attributes:
        by_x: By positions [1/s²], shape (3 node, 3 node).
        by_v: By velocities [1/s], shape (3 node, 3 node).
        wide: W, a column for each large enclosed volume [(N/m)^½], shape (3 node, column).
    """

    by_x: sparse.csr_matrix
    by_v: sparse.csr_matrix
    wide: Floats


def stage_matrix(act: LegForces, time: float, at: NodeState, own: float) -> LowRankFactor:
    """Return S = 1 - own² ∂a/∂x - own ∂a/∂v of an implicit stage, factorised.

    Args:
        act: Everything that acts.
        time: [s].
        own: Step size times the diagonal coefficient of the method [s].

    Raises:
        RuntimeError: It is singular.
    """
    by_x, by_v, wide = derivatives(act, time, at)
    one = sparse.identity(len(at.x), format="csc")
    matrix = sparse.csc_matrix(one - own * own * by_x - own * by_v)
    inverse = np.repeat(act.forces.links.inverse, 3)
    return LowRankFactor(SparseFactor(matrix), own * own * inverse[:, None] * wide, wide)


def derivatives(act: LegForces, time: float, at: NodeState) -> AccelerationMatrices:
    """Return the derivatives of accelerations by positions and velocities.

    Args:
        act: Everything that acts.
        time: [s].
    """
    links, size = act.forces.links, len(act.forces.links.inverse)
    by_x = sparse.csr_matrix((3 * size, 3 * size))
    by_v = -sparse.diags(np.repeat(links.drag * links.inverse, 3))
    wide = [np.zeros((len(at.x), 0))]
    number, inverse = np.arange(size), sparse.diags(np.repeat(links.inverse, 3))
    position, velocity = at.x.reshape(-1, 3), at.v.reshape(-1, 3)
    position = position[: act.leg.network.node_count]
    for each in act.fields:
        field = each.recalling(velocity)
        stiff, beside = field.split(time, position, number, size)
        by_x = by_x - inverse @ stiff
        wide.append(beside)
        slow = field.damping_derivatives(position, velocity, number, size)
        if slow is not None:
            by_x, by_v = by_x - inverse @ slow[0], by_v - inverse @ slow[1]
        tangents = field.memory_tangents(position, velocity)
        if tangents is not None:
            kept, giving = tangents.matrices(size)
            by_x, by_v = by_x + kept, by_v + inverse @ giving
    beside = np.hstack(wide)
    if (guides := act.leg.guides) is not None:
        # Guided nodes keep to their directions, as if a stiffness held them.
        within = free_projection(guides, number, size)
        top = float(np.abs(by_x.data).max(initial=0.0)) or 1.0
        across = sparse.identity(3 * size) - within
        by_x, by_v = within @ by_x @ within - top * across, within @ by_v @ within
        beside = within @ beside
    return AccelerationMatrices(sparse.csr_matrix(by_x), sparse.csr_matrix(by_v), beside)


def _shipped(function: Callable[..., None]) -> Shipped:
    return Shipped(function, "derivatives")


acceleration = _shipped(accelerations.acceleration)
pull_back = _shipped(accelerations.pull_back)
push_forward = _shipped(accelerations.push_forward)
begin_dues = _shipped(steps.begin_dues)
combine_stage = _shipped(steps.combine_stage)
enter_stage = _shipped(steps.enter_stage)
leave_step = _shipped(steps.leave_step)
step_back = _shipped(steps.step_back)
step_change = _shipped(steps.step_change)
step_forward = _shipped(steps.step_forward)
weigh_stage = _shipped(steps.weigh_stage)
