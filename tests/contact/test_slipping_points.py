"""Friction of points on faces that slipped when the last step ended."""

import numpy as np
import pytest

from tests.contact.test_faces import slab
from tissuec.compiled.calls import kernel_on
from tissuec.forces.bristle_kernel import SLIDES, SLIPS


@pytest.mark.parametrize(("speed", "slips"), [(0.01, True), (-0.01, False)])
def test_what_slips_bears_the_whole_friction_until_it_turns_back(speed, slips):
    network = slab(
        "kind is plane; point = (8, 8, 3.9) mm; normal = (0, 0, -1)", entries="friction = 0.4"
    )
    contact, position = network.contact, network.position
    body = slice(0, network.body_nodes)
    velocity = np.zeros_like(position)
    velocity[body, 0] = speed
    # As pressures have risen since, bristles have half of the length at which they slip.
    length = 0.2 * (0.1e-3 - 0.5 * contact.layer)
    velocity[contact.memory, 0] = contact.rate * length
    table = contact.table(np.arange(len(position)), None, position)
    table.touches.bent[:, SLIDES] = 1.0
    forces, power = np.zeros_like(position), np.zeros(2)
    call = kernel_on(contact.kernel, table)
    call(0.0, position.ravel(), velocity.ravel(), forces.reshape(-1), power)
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
