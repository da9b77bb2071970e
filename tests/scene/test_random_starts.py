"""Cubes whose nodes begin anywhere return to their shape.

(B. Smith, F. de Goes, T. Kim, ACM Trans. Graph. 37:12, 2018, section 6.)
"""

import numpy as np
import pytest

import tissuec

STEPS = np.array([0.0, 5.0, 10.0])  # [mm]
PLACES = np.stack(np.meshgrid(STEPS, STEPS, STEPS, indexing="ij"), axis=-1).reshape(-1, 3)


def scene(seed, *, law="", script="at 3 us: settle", every="1 us", simulate="duration = 5 us"):
    """Return a scene of a cube whose 27 nodes are moved to places in it by chance."""
    moved = np.random.default_rng(seed).uniform(0.0, 10.0, PLACES.shape) - PLACES
    nodes = range(1, len(PLACES) + 1)
    sets = "\n".join(f"set n{k} = nodes of cube in [{k}]" for k in nodes)
    way = "from 0 s to 1 us: move n{} by ({:.6f}, {:.6f}, {:.6f}) mm using constant speed"
    moves = "\n".join(way.format(k, *each) for k, each in zip(nodes, moved, strict=True))
    return f"""language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 20 ms; {law}
}}
body cube {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }}
  tissue is gel
}}
{sets}
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 5 Hz }}
script {{
{moves}
  at 2 us: free cube
  at 2 us: change velocity of cube to (0, 0, 0) m/s
  {script}
}}
simulate {{ {simulate} }}
output {{ elastic energy of cube every {every} }}
"""


def left(text):
    """Return the part of the energy that is left in the end."""
    with tissuec.run(text, companion="off") as run:
        assert run.finished
        energy = run.logs["elastic energy of cube"].value.ravel()
    return energy[-1] / energy.max()


def test_a_cube_settles_to_its_shape_from_anywhere():
    assert left(scene(1)) < 1e-12


@pytest.mark.slow
def test_most_cubes_settle_to_their_shape():
    """The others end in equilibria of cells that are inside out."""
    returned = [left(scene(seed)) < 1e-12 for seed in range(20)]
    assert sum(returned) >= 17


@pytest.mark.slow
def test_a_cube_moves_to_its_shape_from_anywhere():
    motion = {"script": "", "every": "10 ms",
              "simulate": "duration = 2 s; integrator is trbdf2; tolerance = 1e-2"}  # fmt: skip
    assert left(scene(2, **motion)) < 1e-9
