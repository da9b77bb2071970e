"""Contact that follows from energies: as loops by hand, with derivatives of differences."""

from functools import partial

import numpy as np
import pytest

from tests.contact.scenes import contact_of, contact_with
from tests.forces.test_fields import called
from tests.validate.scenes import compiled_scene
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops.pools import force_kernel
from tissuec.core.structs import replace
from tissuec.forces.contact.contact import Contact
from tissuec.forces.contact.contact_kernel import touch
from tissuec.forces.contact.pressing import traced_pairs
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
    table, by = _table(contact, position), np.zeros(len(contact.stiffness))
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


@pytest.mark.parametrize("shape", SHAPES)
def test_the_matrix_is_minus_the_change_of_the_forces(shape):
    contact, position, velocity = touching(shape, 0.0)
    one = np.eye(position.size)
    still = np.zeros((NODES, position.size))
    found = changed(contact, position, 0.0 * velocity, one, 0.0 * one, still)
    count = len(position)
    matrix = contact.matrix(0.0, position, np.arange(count), count).toarray()
    scale = np.abs(matrix).max()
    assert -found == pytest.approx(matrix, abs=1e-12 * scale)


FLAT = """language 1
tissue felt { spring constant = 40 N/m; viscosity = 1 mN*s/m; mass = 1 mg }
body mat { mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 20, 0) mm; columns = 4; rows = 4; diagonals is both }; tissue is felt }
tool probe { kind is probe; radius = 3 mm; centre = (10, 11, 2.5) mm }
tool floor { kind is plane; point = (0, 0, 0.2) mm; normal = (0.02, 0, 1) }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only
  contact places is faces; contact damping = 3 s/m; contact surface stiffness = 1 MPa/m }
simulate { duration = 10 ms }
"""


def both_ways(contact, position, velocity, lanes=8):
    """Return forces, powers and bends of the loops by hand in Python, and of generated ones."""
    pool, near = traced_pairs(contact._form), replace(contact, stride=0.1)
    loop = partial(force_kernel, item=pool.item, pool=pool, lanes=lanes)
    state = position.ravel(), velocity.ravel()
    for kernel in (touch, GeneratedKernel(f"forces_{lanes}", loop)):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Contact, "_follows", kernel is not touch)
            table = near.table(np.arange(len(position)), None, position)
        forces, power = np.zeros(position.size), np.zeros(2)
        kernel(0.0, *state, forces, power, table)
        yield forces, power[1], table.touches.bends[0]


@pytest.mark.parametrize("damping", [0.0, 0.3, 30.0])
@pytest.mark.parametrize("shape", [*SHAPES, "points"])
def test_forces_are_those_of_the_loops_by_hand_in_any_number_of_lanes(shape, damping):
    if shape == "points":
        contact = replace(contact_of(compiled_scene(FLAT)), damping=damping)
        position = compiled_scene(FLAT).network.position
        velocity = np.random.default_rng(0).standard_normal(position.shape)
    else:
        contact, position, velocity = touching(shape, damping)
    expected, found = both_ways(contact, position, velocity)
    assert np.abs(expected[0]).max() > 0.0 and (expected[1] > 0.0) == (damping > 0.0)
    # The nearest points of pairs that cancel differ by rounding.
    assert found[0] == pytest.approx(expected[0], abs=1e-13 * np.abs(expected[0]).max())
    assert found[1:] == pytest.approx(expected[1:], rel=1e-13)
    _, one = both_ways(contact, position, velocity, lanes=1)
    assert np.array_equal(one[0], found[0]) and one[1:] == found[1:]


def test_points_on_faces_have_the_derivatives_of_differences():
    contact = contact_of(compiled_scene(FLAT))
    count = int(contact.points.max()) + 1
    position = compiled_scene(FLAT).network.position[:count]
    random = np.random.default_rng(2)
    velocity = random.standard_normal(position.shape)
    dx, dv = random.standard_normal((2, position.size, 1))
    still = np.zeros((len(contact.stiffness), 1))
    found = changed(contact, position, velocity, dx, dv, still)[:, 0]
    x, v = (each.reshape(-1, 3) for each in (dx, dv))
    step = 1e-9  # the layer is very thin
    ahead = forces(contact, position + step * x, velocity + step * v)
    behind = forces(contact, position - step * x, velocity - step * v)
    slope = (ahead - behind) / (2.0 * step)
    assert np.abs(slope).max() > 0.0
    assert found == pytest.approx(slope, abs=1e-6 * np.abs(slope).max())
    weight = random.standard_normal(position.size)
    by_x, by_v, by = derived(contact, position, velocity, weight)
    assert by_x @ dx + by_v @ dv == pytest.approx(weight @ found, rel=1e-12)
    stiffer = replace(contact, stiffness=2.0 * contact.stiffness)
    work = [weight @ forces(each, position, velocity) for each in (contact, stiffer)]
    assert by @ contact.stiffness == pytest.approx(work[1] - work[0], rel=1e-12)


def test_friction_has_none():
    contact = contact_with(CAPSULE, np.array([[4, 5, 5]]), 4, friction=0.2)
    assert contact.derivatives == "has friction"
