"""Threads share the items of fields: cells, triangles and plates."""

from itertools import combinations

import numpy as np
import pytest

import tissuec
from tests.validate.scenes import compiled_scene
from tests.whole_runs import same_on_threads
from tissuec.compiler.prediction import state_at_start
from tissuec.engine import threads
from tissuec.engine.threads import BLOCK_NODES, LEAST_BLOCKS, parts_of

HEAD = """language 1
environment { gravity = (0, 0, -9.81) m/s^2; contact is off }
"""
#: Each with enough nodes for five blocks.
CELLS = """tissue flesh { spring constant = 500 N/m; viscosity = 10 mN*s/m; mass = 1 g }
body block {
  made of springs
  mesh is lattice {
    kind is sodium chloride; cell = 1 cm; box from (0, 0, 0) cm to (16, 16, 17) cm
  }
  tissue is flesh
}
set floor = nodes of block where z < 1 mm
script { at 0 s: { fix floor; preserve volume of block with 10 kPa }
  from 1 ms to 3 ms: inflate block to 4400 ml }
simulate { duration = 4 ms; step = 0.5 ms; integrator is velocity verlet }
output { trajectory every 2 ms; energy every 2 ms }
"""
PLATES = """tissue cloth {
  Young's modulus = 30 kPa; density = 1 g/cm^3; retardation time = 5 ms
}
body sheet {
  mesh is sheet {
    corner = (0, 0, 0) cm; first edge = (35, 0, 0) cm; second edge = (0, 35, 0) cm
    columns = 72; rows = 72
  }
  tissue is cloth; thickness = 2 mm
}
set rim = nodes of sheet where x < 1 mm
set tip = nodes of sheet where x > 349 mm
script { at 0 s: { fix rim; push tip with (0, 0, 1) N } }
simulate { duration = 0.6 ms; step = 20 us; integrator is velocity verlet }
output { trajectory every 0.3 ms; energy every 0.3 ms }
"""
SCENES = {"cells": CELLS, "plates": PLATES}


def field_of(scene):
    compiled = compiled_scene(HEAD + scene)
    *_, field = state_at_start(compiled).fields  # of a wall, its plates
    return field, compiled.network


def orders(network):
    """Return places of nodes as they are drawn, and in no order."""
    count = network.node_count
    return np.arange(count), np.random.default_rng(3).permutation(count)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_parts_at_a_time_have_no_node_in_common(scene):
    field, network = field_of(scene)
    assert network.node_count >= LEAST_BLOCKS * BLOCK_NODES
    for place in orders(network):
        for group in parts_of(field, place):
            nodes = [set(part.items(place).places.tolist()) for part in group]
            assert not any(one & other for one, other in combinations(nodes, 2))
    drawn = parts_of(field, orders(network)[0])
    assert max(len(group) for group in drawn) >= 2 and len(drawn) <= 3


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_parts_add_up_to_the_field(scene):
    field, network = field_of(scene)
    random = np.random.default_rng(1)
    x = network.position + random.normal(0.0, 1e-4, network.position.shape)
    v = random.normal(0.0, 1.0, x.shape)
    whole, found, power = np.zeros_like(x), np.zeros_like(x), np.zeros(2)
    field.add_forces(0.002, x, v, whole)
    for group in parts_of(field, orders(network)[1]):
        for part in group:
            part.add_forces(0.002, x, v, found)
            power += part.powers(0.002, x, v)
    # Sums of a few dozen terms at each node, in another order.
    assert np.abs(found - whole).max() < 1e-13 * np.abs(whole).max()
    assert power == pytest.approx(field.powers(0.002, x, v), rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_every_number_is_the_same_to_the_last_bit(scene, threads_in_small_nets, monkeypatch):
    one = same_on_threads(HEAD + scene, 3).position[:]
    monkeypatch.setattr(threads, "LEAST_BLOCKS", 10**9)
    whole = tissuec.run(HEAD + scene, companion="off").position[:]
    moved = np.abs(whole - whole[0]).max()
    # Each of up to 30 steps rounds coordinates of up to 35 cm, to 6e-17 m.
    assert 0.0 < np.abs(one - whole).max() < 1e-14 < 1e-6 * moved
