"""Friction of points on faces that slipped when the last step ended."""

import numpy as np
import pytest

from tests.contact.scenes import evaluated
from tests.contact.test_faces import slab
from tissuec.forces.contact.bristle_kernel import SLIDES, SLIPS


@pytest.mark.parametrize(("speed", "slips"), [(0.01, True), (-0.01, False)])
def test_what_slips_bears_the_whole_friction_until_it_turns_back(speed, slips):
    network = slab(
        "kind is plane; point = (8, 8, 3.9) mm; normal = (0, 0, -1)", entries="friction = 0.4"
    )
    contact, position = network.contact, network.position
    body = slice(0, network.body_nodes)
    velocity = np.zeros((network.row_count, 3))
    velocity[body, 0] = speed
    # As pressures have risen since, bristles have half of the length at which they slip.
    length = 0.2 * (0.1e-3 - 0.5 * contact.layer)
    velocity[contact.memory, 0] = contact.rate * length
    table = contact.table(np.arange(len(velocity)), None, position)
    table.touches.bent[:, SLIDES] = 1.0
    forces, power = evaluated(contact, [table], position, velocity)
    along, _, normal = forces[body].sum(axis=0)
    share = 1.0 if slips else 0.5
    assert normal < 0.0
    assert along == pytest.approx(0.4 * share * normal, rel=1e-9)
    assert power[1] == pytest.approx(-along * speed, rel=1e-9)
    touching = table.touches.bent[:, SLIPS] > 0.0
    grows = 0.0 if slips else speed
    assert table.touches.bent[touching, 0] == pytest.approx(
        np.full(touching.sum(), contact.rate * grows), abs=1e-12 * contact.rate
    )
    # Of each point: two depths, pressure that damping leaves, and a bristle at its limit.
    assert touching.any()
    assert table.touches.bends[0] == touching.sum() * (4 if slips else 3)


@pytest.mark.parametrize(
    ("point", "normal"),
    [("(15.9, 8, 2)", (-1, 0, 0)), ("(8, 0.1, 2)", (0, 1, 0)), ("(8, 8, 3.9)", (0, 0, -1))],
)
def test_in_an_implicit_stage_bristles_bend_by_its_velocity_in_any_direction(point, normal):
    network = slab(
        f"kind is plane; point = {point} mm; normal = {normal}", entries="friction = 1"
    )
    contact, position = network.contact, network.position
    along = np.ones(3) - np.abs(normal)
    velocity, lag = np.zeros((network.row_count, 3)), 1e-3
    speed = np.array([3e-3, -5e-3, 7e-3]) * along
    velocity[: network.body_nodes] = speed
    begun = np.array([4e-6, 1e-6, -6e-6]) * along
    velocity[contact.memory] = contact.rate * begun
    table = contact.table(np.arange(len(velocity)), None, position)
    table.touches.lag[0] = lag
    forces, _ = evaluated(contact, [table], position, velocity)
    total = forces[: network.body_nodes].sum(axis=0)
    pressure = total @ np.array(normal)
    depth = 0.1e-3 - 0.5 * contact.layer
    assert pressure > 0.0
    expected = -(begun + lag * speed) / depth * pressure
    assert total * along == pytest.approx(expected, rel=1e-9, abs=1e-12 * pressure)
