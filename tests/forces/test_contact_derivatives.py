"""Forces of contact have the derivatives that differences of them have, in both directions."""

import numpy as np
import pytest
from msgspec.structs import replace

from tests.contact.scenes import contact_with
from tests.forces.test_fields import called
from tissuec.forces.fields import acts_of
from tissuec.geometry.nearest import CAPSULE, PLANE, TRIANGLE

NODES = 60
#: Shapes by the places of their points: a plane; a bent line of two pieces; four triangles of a
#: flat pyramid, which share edges and a corner.
SHAPES = {
    "plane": (PLANE, [[0.5, 0.5, 0.9], [0.6, 0.45, 1.2]], [[0, 1, 1]]),
    "line": (
        CAPSULE,
        [[0.1, 0.5, 0.5], [0.5, 0.6, 0.5], [0.9, 0.3, 0.6]],
        [[0, 1, 1], [1, 2, 2]],
    ),
    "surface": (
        TRIANGLE,
        [[0.1, 0.1, 0.5], [0.9, 0.1, 0.5], [0.9, 0.9, 0.5], [0.1, 0.9, 0.5], [0.5, 0.4, 0.6]],
        [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    ),
}
STEP = 1e-6


def touching(shape, damping):
    """Return a contact, positions and velocities of its nodes and of what carries shapes."""
    kind, points, faces = SHAPES[shape]
    random = np.random.default_rng(4)
    own = random.uniform(size=(NODES, 3)) * [1.0, 1.0, 0.5] + [0.0, 0.0, 0.3]
    position = np.concatenate([own, points])
    stiffness = random.uniform(20.0, 60.0, NODES)
    contact = contact_with(
        kind, np.array(faces) + NODES, NODES, radius=0.3, damping=damping, stiffness=stiffness
    )
    return contact, position, random.standard_normal(position.shape)


def forces(contact, position, velocity):
    """Return the forces on all nodes, flat."""
    found = np.zeros_like(position)
    contact.add_forces(0.0, position, velocity, found)
    return found.ravel()


def derived(contact, position, velocity, weight):
    """Return the derivatives of Σ weight · f by positions, velocities and stiffness."""
    table, by = _table(contact, position), np.zeros(NODES)
    by_x, by_v = np.zeros((2, position.size))
    states = position.ravel(), velocity.ravel()
    called(contact.derivatives.pull_back, table, 0.0, *states, weight, by_x, by_v, by)
    return by_x, by_v, by


def changed(contact, position, velocity, dx, dv, dn):
    """Return the changes of the forces by many changes, shape (3 node, change)."""
    many = dx.shape[1]
    found, room = np.zeros(dx.size), np.zeros(many)
    flat = (np.ascontiguousarray(part).ravel() for part in (dx, dv, dn))
    states = position.ravel(), velocity.ravel()
    forward, table = contact.derivatives.push_forward, _table(contact, position)
    called(forward, table, 0.0, *states, *flat, found, room)
    return found.reshape(-1, many)


def _table(contact, position):
    place = np.arange(len(position))
    return contact.table(place, acts_of(contact.changes, 0.0, 0.0), position)


@pytest.mark.parametrize("damping", [0.0, 0.3])
@pytest.mark.parametrize("shape", SHAPES)
def test_both_directions_are_those_of_differences(shape, damping):
    contact, position, velocity = touching(shape, damping)
    random = np.random.default_rng(1)
    dx, dv = random.standard_normal((2, position.size, 3))
    dn = random.standard_normal((NODES, 3))
    found = changed(contact, position, velocity, dx, dv, dn)
    assert (np.abs(found).reshape(-1, 9).max(axis=1) > 0.0).sum() > 20
    for m in range(3):
        sides = []
        for step in (STEP, -STEP):
            other = replace(contact, stiffness=contact.stiffness + step * dn[:, m])
            x, v = (
                part + step * way[:, m].reshape(-1, 3)
                for part, way in ((position, dx), (velocity, dv))
            )
            sides.append(forces(other, x, v))
        slope = (sides[0] - sides[1]) / (2.0 * STEP)
        # Over the difference, some depth may pass into or out of the layer.
        assert found[:, m] == pytest.approx(slope, abs=1e-6 * np.abs(slope).max())
    weight = random.standard_normal(position.size)
    by_x, by_v, by = derived(contact, position, velocity, weight)
    parts = by_x @ dx, by_v @ dv, by @ dn
    assert sum(parts) == pytest.approx(weight @ found, rel=1e-12)
    assert (np.abs(by_v).max() > 0.0) == (damping > 0.0)


@pytest.mark.parametrize("shape", ["plane", "line"])
def test_the_matrix_of_nodes_on_shapes_that_are_held_is_exact(shape):
    contact, position, velocity = touching(shape, 0.0)
    one = np.eye(position.size)[:, : 3 * NODES]
    found = changed(
        contact, position, 0.0 * velocity, one, 0.0 * one, np.zeros((NODES, 3 * NODES))
    )
    number = np.where(np.arange(len(position)) < NODES, np.arange(len(position)), -1)
    matrix = contact.matrix(0.0, position, number, NODES).toarray()
    scale = np.abs(matrix).max()
    assert -found[: 3 * NODES] == pytest.approx(matrix, abs=1e-12 * scale)


def test_friction_has_none():
    contact = contact_with(CAPSULE, np.array([[4, 5, 5]]), 4, friction=0.2)
    assert contact.derivatives == "has friction"
