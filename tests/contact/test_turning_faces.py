"""The stiffness of contact between soft bodies, whose faces turn as they are pressed."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene

BLOCKS = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body lower { mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 5) mm }
  tissue is gel }
body upper { mesh is lattice { cell = 3 mm; box from (1.3, 2.1, 6.1) mm to (7.3, 8.1, 9.1) mm }
  tissue is gel }
environment { gravity = (0, 0, 0) m/s^2; contact is bodies too; contact thickness = 1 mm }
simulate { duration = 1 ms }
"""


@pytest.fixture(scope="module")
def pressed():
    """Return the contact of two blocks, where they are when pressed together, and disturbed."""
    network = compiled_scene(BLOCKS).network
    position = network.position.copy()
    upper = network.bodies[1].nodes
    position[upper, 2] -= 0.5e-3
    chance = np.random.default_rng(3)
    return network.contact, position + 1.5e-4 * chance.standard_normal(position.shape)


def stiffness(contact, position, **choices):
    count = len(position)
    found = contact.matrix(0.0, position, np.arange(count), count, **choices)
    return found.toarray()


def test_the_matrix_is_minus_the_derivative_of_the_forces_on_both_bodies(pressed):
    contact, position = pressed
    matrix = stiffness(contact, position)
    assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()
    still, size = np.zeros_like(position), 1e-9
    for seed in range(3):
        way = np.random.default_rng(seed).standard_normal(position.shape)
        change = np.zeros_like(position)
        for side in (1.0, -1.0):
            forces = np.zeros_like(position)
            contact.add_forces(0.0, position + side * size * way, still, forces)
            change += side * forces / (2.0 * size)
        error = np.abs(matrix @ way.ravel() + change.ravel()).max()
        assert error < 1e-5 * np.abs(change).max()


def test_without_exact_parts_nothing_weakens_and_the_bound_holds(pressed):
    contact, position = pressed
    clamped = np.linalg.eigvalsh(stiffness(contact, position, exact=False))
    assert clamped[0] > -1e-12 * clamped[-1]
    lowest = np.linalg.eigvalsh(stiffness(contact, position))[0]
    bound = contact.weakening(0.0, position, np.arange(len(position)), len(position))
    assert -bound <= lowest < 0.0
