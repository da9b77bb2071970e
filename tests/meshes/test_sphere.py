"""The sphere: counts, Euler's formula, roundness, opposite nodes."""

import numpy as np
import pytest

from tissuec.meshes.generators.sphere import Sphere, antipodes, divide, icosahedron

CENTRE = np.array([0.1, -0.2, 0.3])


def sphere(subdivisions, interior="none", radius=0.02):
    return Sphere(CENTRE, radius, subdivisions, interior)


@pytest.mark.parametrize("subdivisions", range(6))
def test_counts_follow_the_closed_form_and_euler(subdivisions):
    mesh, quarters = sphere(subdivisions).build(), 4**subdivisions
    nodes, springs, faces = len(mesh.position), len(mesh.ends), len(mesh.skin)
    assert (nodes, springs, faces) == (10 * quarters + 2, 30 * quarters, 20 * quarters)
    assert nodes - springs + faces == 2


@pytest.mark.parametrize("interior", ["none", "antipodes"])
def test_every_surface_node_is_at_the_radius(interior):
    position = sphere(4, interior).build().position
    assert np.linalg.norm(position - CENTRE, axis=1) == pytest.approx(0.02, rel=1e-14)


def test_volume_error_falls_with_the_square_of_the_edge():
    exact = 4.0 / 3.0 * np.pi * 0.02**3
    errors = []
    for subdivisions in (2, 3, 4, 5):
        mesh = sphere(subdivisions).build()
        a, b, c = (mesh.position[mesh.skin] - CENTRE).transpose(1, 0, 2)
        errors.append(1.0 - np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0 / exact)
    assert np.log2(errors[:-1]) - np.log2(errors[1:]) == pytest.approx(2.0, abs=0.05)


def test_spokes_end_at_one_more_node_in_the_centre():
    mesh = sphere(2, "spokes").build()
    assert np.array_equal(mesh.position[-1], CENTRE)
    assert (mesh.ends[:, 1] == len(mesh.position) - 1).sum() == len(mesh.position) - 1


def test_antipodes_pass_through_the_centre():
    plain, mesh = sphere(3).build(), sphere(3, "antipodes").build()
    drawn = {tuple(pair) for pair in plain.ends.tolist()}
    added = np.array([pair for pair in mesh.ends.tolist() if tuple(pair) not in drawn])
    assert len(added) == len(mesh.position) // 2
    assert np.ptp(mesh.position[added].mean(axis=1) - CENTRE, axis=0) == pytest.approx(
        0, abs=1e-16
    )


def test_opposite_nodes_are_exact_negatives():
    unit, triangles = icosahedron()
    for _ in range(5):
        unit, triangles = divide(unit, triangles)
        assert np.array_equal(unit[antipodes(unit)], -unit)


def test_coordinate_directions_hold_a_node():
    unit, _ = divide(*icosahedron())
    for direction in np.concatenate((np.eye(3), -np.eye(3))):
        assert (unit == direction).all(axis=1).any()
