"""Bodies that touch one another, and themselves: nodes against triangles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contact.scenes import bodies, contact_with, gap_of_balance, play
from tissuec.geometry.nearest import CAPSULE, PLANE, TRIANGLE

BALLS = """language 1
tissue rubber {{ spring constant = 300 N/m; viscosity = 0 N*s/m; mass = 0.3 g }}
body upper {{ mesh is sphere {{ centre = (2, 1, 18.5) mm; radius = 8 mm; subdivisions = 1
  interior is spokes }}; tissue is rubber; velocity = (0, 0.05, -0.4) m/s }}
body lower {{ mesh is sphere {{ centre = (0, 0, 0) mm; radius = 8 mm; subdivisions = 1
  interior is spokes }}; tissue is rubber }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is bodies too; friction = {friction} }}
simulate {{ duration = 40 ms; tolerance = 1e-7 }}
output {{ trajectory every 1 ms; energy every 1 ms }}
"""


def random_contact(kind, rng, *, nodes=40, friction=0.4):
    """Return a contact of nodes in a box with a few shapes in it, and a state."""
    shapes = 6
    points = nodes + np.arange(3 * shapes).reshape(-1, 3)
    if kind != TRIANGLE:
        points[:, 2] = points[:, 1]
    stiffness = np.linspace(40.0, 60.0, nodes)
    contact = contact_with(
        kind, points, nodes, friction=friction, radius=0.3, stiffness=stiffness
    )
    position, velocity = rng.uniform(-1.0, 1.0, (2, 2 * nodes + 3 * shapes, 3))
    velocity[contact.memory] *= 0.1 * contact.rate
    return contact, position, velocity


@pytest.mark.parametrize("kind", [CAPSULE, TRIANGLE])
def test_forces_on_nodes_and_shapes_are_minus_the_gradient_and_cancel(kind):
    contact, position, _ = random_contact(kind, np.random.default_rng(7), friction=0.0)
    still, forces = np.zeros_like(position), np.zeros_like(position)
    contact.add_forces(0.0, position, still, forces)
    assert np.abs(forces.sum(axis=0)).max() < 1e-12 * np.abs(forces).max()
    moments = np.cross(position, forces).sum(axis=0)
    assert np.abs(moments).max() < 1e-11 * np.abs(forces).max()
    h = 1e-6
    for node in range(58):
        for axis in range(3):
            ends = []
            for sign in (1.0, -1.0):
                moved = position.copy()
                moved[node, axis] += sign * h
                ends.append(float(contact.energy(0.0, moved)))
            # Central differences of an energy of about 1 J: h² and rounding over h.
            slope = (ends[1] - ends[0]) / (2.0 * h)
            assert slope == pytest.approx(forces[node, axis], abs=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_balls_that_collide_keep_momentum_and_their_ledger(friction):
    played = play(BALLS.format(friction=friction))
    nodes = bodies(played)  # and not what remembers friction
    position, velocity = played.position[:, nodes], played.velocity[:, nodes]
    mass = played.compiled.network.mass[nodes]
    momentum = np.einsum("n,tnk->tk", mass, velocity)
    # Actions equal reactions to rounding; what is left is rounding of hundreds of steps.
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * np.abs(momentum[0]).max()
    spin = np.einsum("n,tnk->tk", mass, np.cross(position, velocity))
    lost = np.abs(spin - spin[0]).max() / np.abs(spin[0]).max()
    # Forces have no moment, to rounding; what is left is the error of steps in a product.
    assert lost < 1e-11
    _, energies = played.energies()
    assert gap_of_balance(played) < 1e-6
    assert energies["elastic"].max() > 0.1 * energies["kinetic"][0]  # they did collide
    assert (energies["dissipated"][-1] > 1e-9) == (friction > 0.0)


FLAT = """language 1
tissue wall {{ spring constant = 50 N/m; viscosity = 20 mN*s/m; mass = 50 mg }}
body tube {{ mesh is tube {{ axis from (0, 0, 0) mm to (12, 0, 0) mm
  radius = 5 mm; rings = 7; sides = 12; interior is none }}; tissue is wall; bending is soft }}
tool top {{ kind is plane; point = (0, 0, 6) mm; normal = (0, 0, -1) }}
tool bottom {{ kind is plane; point = (0, 0, -6) mm; normal = (0, 0, 1) }}
environment {{ gravity = (0, 0, 0) m/s^2; damping = 2 mN*s/m
  contact is {contact}; contact thickness = 1 mm; contact stiffness = 1 N/mm }}
script {{ from 0 s to 0.1 s: {{
  move top by (0, 0, -5.7) mm using smooth profile
  move bottom by (0, 0, 5.7) mm using smooth profile }} }}
simulate {{ duration = 0.12 s; tolerance = 1e-3 }}
output {{ trajectory every 5 ms; force of top every 5 ms }}
"""


def test_walls_of_a_tube_that_is_pressed_flat_resist_each_other():
    pressed = {}
    for contact in ("tools only", "everywhere"):
        played = play(FLAT.format(contact=contact))
        pressed[contact] = np.linalg.norm(played.log("force of top")[1][-1])
    # Planes 0.6 mm apart leave no room for walls that keep 1 mm between them.
    assert pressed["everywhere"] > 3.0 * pressed["tools only"]


@pytest.mark.parametrize("kind", [CAPSULE, PLANE, TRIANGLE])
def test_what_touches_after_a_short_way_was_listed_before_it(kind):
    for seed in range(20):
        rng = np.random.default_rng(seed)
        contact, before, _ = random_contact(kind, rng)
        way = rng.normal(size=before.shape)
        way *= 0.999 * contact.stride / np.linalg.norm(way, axis=1)[:, None]
        if kind == PLANE:  # which is rigid: it is shifted and turned, half of the way each
            first, ahead = contact.points[:, 0], contact.points[:, 1]
            reach = 0.2 * rng.normal(size=(len(first), 3))
            angle = 0.5 * contact.stride / np.linalg.norm(reach, axis=1)
            axis = np.cross(reach, rng.normal(size=reach.shape))
            axis *= (angle / np.linalg.norm(axis, axis=1))[:, None]
            before[ahead] = before[first] + reach
            way[first] *= 0.5
            way[ahead] = way[first] + Rotation.from_rotvec(axis).apply(reach) - reach
        after = before + way
        listed = {*zip(*contact.near(before, 2.0 * contact.stride)[:4], strict=True)}
        touching = {*zip(*contact.near(after, 0.0)[:4], strict=True)}
        assert touching and touching <= listed
