"""Elements between held nodes are left out of steps, which changes no bit of the result."""

import numpy as np
import pytest

import tissuec
from tests.validate.scenes import compiled_scene
from tissuec.forces.fields import Field
from tissuec.mechanics.state import State

#: A strip of which most is fixed, is let go, moves as a tool would, and is fixed again.
SCENE = """language 1
tissue gum {{
  Young's modulus = 20 kPa; Poisson's ratio = 0.4; density = 1000 kg/m^3
  retardation time = 1 ms
}}
body strip {{
  mesh is {mesh}
  tissue is gum{wall}
}}
set base = nodes of strip where x < 21 mm
set part = nodes of strip where x < 11 mm
environment {{ gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m }}
script {{
  at 0 s: {{ fix base; fix part }}
  at 4 ms: free base
  from 6 ms to 8 ms: move part by (0, 0, 0.1) mm using smooth profile
  at 8.5 ms: fix base
}}
simulate {{ duration = 10 ms; integrator is {method}; tolerance = 1e-2 }}
output {{ trajectory every 1 ms; force(base) every 1 ms; energy every 1 ms }}
"""
SOLID = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (40, 5, 5) mm }", ""
WALL = (
    "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 10, 0) mm; "
    "columns = 9; rows = 3 }",
    "; thickness = 1 mm; bending is elastic",
)


def scene(kind, method="automatic"):
    return SCENE.format(mesh=kind[0], wall=kind[1], method=method)


@pytest.mark.parametrize("method", ["dop853", "esdirk43"])
@pytest.mark.parametrize("kind", [SOLID, WALL], ids=["solid", "wall"])
def test_a_run_is_the_same_to_the_bit(kind, method, monkeypatch):
    without = tissuec.run(scene(kind, method), companion="off")
    monkeypatch.setattr(Field, "moving", lambda field, still: field)
    every = tissuec.run(scene(kind, method), companion="off")
    assert np.array_equal(without.position[:], every.position[:])
    assert np.array_equal(without.energies.value, every.energies.value)
    one, other = (run.logs["force of base"].value for run in (without, every))
    assert np.array_equal(one, other)


@pytest.mark.parametrize("kind", [SOLID, WALL], ids=["solid", "wall"])
def test_elements_with_a_node_that_moves_remain(kind):
    network = compiled_scene(scene(kind)).network
    still = network.position[:, 0] < 21e-3
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    for field in state.fields:
        left, moves = field.moving(still), (~still[field.nodes]).any(axis=1)
        assert left is not None and 0 < moves.sum() < len(moves)
        assert np.array_equal(left.nodes, field.nodes[moves])
        assert field.moving(np.ones_like(still)) is None
        assert field.moving(np.zeros_like(still)) is field


@pytest.mark.parametrize("kind", [SOLID, WALL], ids=["solid", "wall"])
def test_their_rows_of_the_matrix_are_those_of_all(kind):
    network = compiled_scene(scene(kind)).network
    free = network.position[:, 0] > 21e-3
    number, every = np.where(free, np.cumsum(free) - 1, -1), np.arange(len(free))
    rows = np.flatnonzero(np.repeat(free, 3))
    for field in State.start(network, gravity=np.zeros(3), drag=0.0).elements:
        own = field.matrix(0.0, network.position, number, int(free.sum())).toarray()
        whole = field.matrix(0.0, network.position, every, len(free)).toarray()
        assert not field.matrix(0.0, network.position, np.full_like(number, -1), 0).nnz
        # The same sums in another order.
        assert own == pytest.approx(whole[np.ix_(rows, rows)], abs=1e-14 * whole.max())
