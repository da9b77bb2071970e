"""Threads that share contact change nothing but the time that it takes."""

import numpy as np
import pytest

from tests.contact.scenes import evaluated
from tests.validate.scenes import compiled_scene
from tests.whole_runs import same_on_threads
from tissuec.compiler.prediction import state_at_start
from tissuec.forces.contact import contact
from tissuec.kernels.thread_loops import UNDIVIDED

#: With enough nodes for threads. The upper block slides to a side and sinks into the lower one.
SCENE = """language 1
tissue flesh { spring constant = 500 N/m; viscosity = 10 mN*s/m; mass = 1 g }
body lower {
  mesh is lattice {
    kind is sodium chloride; cell = 1 cm; box from (0, 0, 0) cm to (12, 12, 12) cm
  }
  tissue is flesh
}
body upper {
  mesh is lattice {
    kind is sodium chloride; cell = 1 cm
    box from (0.3, 0.4, 12.31) cm to (12.3, 12.4, 24.31) cm
  }
  tissue is flesh
}
environment {
  gravity = (0, 0, -9.81) m/s^2; contact is bodies too; contact thickness = 3 mm
  contact damping = 1 s/m; friction = 0.3
}
set ground = nodes of lower where z < 1 mm
set top = nodes of upper where z > 24.3 cm
script { at 0 s: { fix ground; push top with (10, 2, -20) N } }
simulate { duration = 8 ms; step = 0.2 ms; integrator is velocity verlet }
output { trajectory every 2 ms; energy every 2 ms }
"""


@pytest.fixture(scope="module", params=["friction = 0.3", "friction = 0"])
def touching(request):
    """Return contact with its table, and a state with velocities, of about 2000 pairs."""
    compiled = compiled_scene(SCENE.replace("friction = 0.3", request.param))
    field, position = state_at_start(compiled).contact, compiled.network.position.copy()
    position[position[:, 2] > 0.121, 2] -= 1e-3
    velocity = np.random.default_rng(2).normal(0.0, 0.1, (compiled.network.row_count, 3))
    table = field.table(np.arange(len(velocity)), None, position)
    touches = table.touches
    assert len(touches.shape) > contact.WORTHWHILE
    assert (len(touches.memory) > 0) == (request.param != "friction = 0")
    return field, table, position, velocity


def outcome(field, groups, position, velocity):
    """Return the forces, the powers and the rates of bristles of some groups of tables."""
    every = [table for group in groups for table in group]
    forces, power = evaluated(field, every, position, velocity)
    touches = groups[0][0].touches
    return forces, power, touches.bent.copy(), touches.bends.copy()


@pytest.mark.parametrize("parts", [2, 8, 5000])
def test_parts_do_the_same_to_the_last_bit(touching, parts):
    field, table, position, velocity = touching
    groups = field.in_parts(table, parts)
    assert [len(group) for group in groups] == [parts, 1]
    whole = outcome(field, [[table]], position, velocity)
    table.touches.bent[:] = table.touches.bends[:] = 0.0
    found = outcome(field, groups, position, velocity)
    assert np.abs(whole[0]).max() > 0.0 < whole[1][1] and whole[3][0] > 100
    assert all(np.array_equal(one, other) for one, other in zip(whole, found, strict=True))


def test_few_pairs_and_single_threads_have_no_parts(touching):
    field, table, *_ = touching
    few = table._replace(touches=table.touches._replace(shape=table.touches.shape[:10]))
    for one in field.in_parts(table, 1), field.in_parts(few, 8):
        ((only,),) = one
        assert only.touches.part == UNDIVIDED


def test_every_number_is_the_same_to_the_last_bit(threads_in_small_nets):
    energies = same_on_threads(SCENE, 2, 3).energies
    assert energies.value[-1, energies.columns.index("dissipated")] > 0.0
