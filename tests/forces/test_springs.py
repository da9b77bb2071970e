"""Tensions and forces of springs in many states, against a formula for one spring."""

import numpy as np
import pytest

from tests.hand_net import make_net
from tissuec.mechanics import observables
from tissuec.mechanics.state import State

STATES = (2, 3)


def state_of(ends):
    place = np.random.default_rng(4).normal(size=(5, 3))
    net = make_net(place, ends, stiffness=3.0, damping=0.4, rest=0.7)
    return State.start(net, gravity=(0.0, 0.0, 0.0), drag=0.0)


def by_hand(ends, position, velocity, alive):
    """Return forces on nodes and tensions of one state: T = c e + d w along each spring."""
    force, tension = np.zeros_like(position), np.zeros(len(ends))
    for s, (i, j) in enumerate(ends):
        gap = position[j] - position[i]
        length = np.linalg.norm(gap)
        if alive[s] and length > 0.0:
            closing = (velocity[j] - velocity[i]) @ gap / length
            tension[s] = 3.0 * (length - 0.7) + 0.4 * closing
            force[i] += tension[s] * gap / length
            force[j] -= tension[s] * gap / length
    return force, tension


@pytest.mark.parametrize("ends", [[[0, 1], [3, 1], [1, 2], [4, 0]], [[2, 0]]])
def test_a_batch_of_states_is_as_each_by_itself(ends):
    random = np.random.default_rng(7)
    state = state_of(ends)
    state.alive[len(ends) // 2 :] = len(ends) < 2  # of several, some are dead
    motion = random.normal(size=(2, *STATES, 3, 5))
    position, velocity = np.swapaxes(motion, -1, -2)  # not contiguous
    position[0, 1, ends[0][1]] = position[0, 1, ends[0][0]]  # a spring without length
    found = observables.inner_forces(state, np.zeros(STATES), position, velocity)
    for k in np.ndindex(STATES):
        force, tension = by_hand(ends, position[k], velocity[k], state.alive)
        # Some ten roundings of numbers near 10.
        assert np.allclose(found.node[k], force, rtol=0.0, atol=1e-14)
        assert np.allclose(found.tension[k], tension, rtol=0.0, atol=1e-14)
        one = observables.inner_forces(state, 0.0, position[k], velocity[k])
        assert np.array_equal(one.node, found.node[k])
    inside = np.array([1, 2])
    resultant = found.node[..., inside, :].sum(axis=-2)
    pull = observables.pull_on(state, position, velocity, inside)
    assert np.allclose(pull, resultant, rtol=0.0, atol=1e-13)


def test_a_net_without_springs_has_no_forces():
    state = state_of(np.zeros((0, 2), dtype=int))
    position = np.ones((4, 5, 3))
    found = observables.inner_forces(state, np.zeros(4), position, position)
    assert found.tension.shape == (4, 0)
    assert not found.node.any()
