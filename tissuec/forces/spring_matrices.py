"""The part of springs in the matrix of an implicit step, S = M + q D + q² K.

Of a spring of direction n, length L and tension T, K takes f' n nᵀ + T/L (1 - n nᵀ), and D the
slope ∂g/∂w of its dashpot along n. Branches and flow have equations of their own (``memory``).
"""

from typing import NamedTuple

import numpy as np

from tissuec.core.vectors import dot, norm
from tissuec.forces.branches import flat, pulled
from tissuec.forces.memory import MemoryTangents
from tissuec.forces.springs import SpringForce, reach
from tissuec.model.network import Floats


class _Motion(NamedTuple):
    """Of springs: directions, lengths, elongations without flow, and rates of lengthening."""

    direction: Floats
    length: Floats
    stretch: Floats
    elongation: Floats
    closing: Floats


def _motion(force: SpringForce, position: Floats, velocity: Floats) -> _Motion:
    springs = force.springs
    gap = reach(springs.ends, position)
    length = norm(gap)
    direction = gap / np.where(length > 0.0, length, 1.0)[:, None]
    closing = dot(direction, reach(springs.ends, velocity))
    stretch = length - springs.rest
    memory = springs.inelastic
    elongation = stretch if memory is None else stretch - memory.flowed(flat(velocity))
    return _Motion(direction, length, stretch, elongation, closing)


def stage_blocks(
    force: SpringForce, q: float, position: Floats, velocity: Floats, *, exact: bool
) -> Floats:
    """Return q D + q² K of each spring between its ends [kg], shape (spring, 2, 3, 2, 3).

    Internal variables are taken as fixed.

    Args:
        force: Of springs that act.
        q: Step size times the coefficient of the method [s].
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        exact: Whether to include the negative stiffness of springs that are compressed or
            soften.
    """
    behaviour, memory = force.springs.behaviour, force.springs.inelastic
    now = _motion(force, position, velocity)
    tension = pulled(behaviour, memory, now.stretch, flat(velocity))
    if behaviour.is_viscous:
        tension = tension + behaviour.brake(now.elongation, now.closing)
    steep = behaviour.slope(now.elongation) + behaviour.brake_by_e(now.elongation, now.closing)
    if memory is not None:
        steep = steep + memory.sudden
    along = q * behaviour.brake_slope(now.elongation, now.closing) + q * q * steep
    has_direction = now.length > 0.0
    across = q * q * tension / np.where(has_direction, now.length, np.inf)
    if not exact:
        along, across = np.maximum(along, 0.0), np.maximum(across, 0.0)
    # What has no direction has no force either.
    along, across = (
        np.where(has_direction & np.isfinite(each), each, 0.0) for each in (along, across)
    )
    block = (along - across)[:, None, None] * (
        now.direction[:, :, None] * now.direction[:, None, :]
    )
    block += across[:, None, None] * np.eye(3)
    signs = np.array([[1.0, -1.0], [-1.0, 1.0]])
    return np.einsum("ab,sxy->saxby", signs, block)


def memory_of_springs(
    force: SpringForce, position: Floats, velocity: Floats
) -> MemoryTangents | None:
    """Return the derivatives of branches and flow, with springs as items; None without any.

    Args:
        force: Of springs that act.
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
    """
    memory, behaviour = force.springs.inelastic, force.springs.behaviour
    if memory is None or not memory.remembers.any():
        return None
    remembers = np.flatnonzero(memory.remembers)
    own = SpringForce(force.springs.some(remembers), force.alive[remembers])
    memory, behaviour = own.springs.inelastic, own.springs.behaviour
    assert memory is not None
    now = _motion(own, position, velocity)
    pull = pulled(behaviour, memory, now.stretch, flat(velocity))
    branches, count = len(memory.constant), len(remembers)
    has = memory.slot >= 0
    steep = behaviour.slope(now.elongation) + memory.sudden
    yields = has[-1] & (np.abs(pull) > memory.limit)
    pace = np.where(has[:-1], 1.0 / memory.time, 0.0)
    flow = np.where(yields, 1.0 / memory.viscosity, 0.0)
    giving = np.zeros((count, branches + 1, branches + 1))
    each = np.arange(branches)
    giving[:, each, each] = pace.T
    giving[:, :-1, -1] = np.where(has[-1], pace, 0.0).T
    giving[:, -1, :-1] = (memory.constant * flow).T
    giving[:, -1, -1] = steep * flow
    by_length = np.concatenate([pace, (steep * flow)[None]]).T
    braked = behaviour.brake_by_e(now.elongation, now.closing)
    of_flow = np.where(has[-1], steep + braked, 0.0)
    # Of the tension by the variables; all of them are then as hidden nodes keep them.
    by_variable = -np.concatenate([memory.constant, of_flow[None]]).T
    rate = np.where(has, memory.rate, 1.0).T
    ways = np.stack([-now.direction, now.direction], axis=1)
    return MemoryTangents(
        slots=np.ascontiguousarray(memory.slot.T),
        nodes=own.springs.ends.astype(np.int64),
        giving=giving * rate[:, :, None] / rate[:, None, :],
        by_position=(rate * by_length)[:, :, None, None] * ways[:, None],
        pull=-ways[..., None] * (by_variable / rate)[:, None, None, :],
    )
