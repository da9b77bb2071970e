"""Strain and stress at nodes, against deformations and loads of which both are known."""

from itertools import product

import numpy as np
import pytest

from tissuec.mechanics.deformation import (
    COMPONENTS,
    Surroundings,
    hats,
    mean_of_springs,
    von_mises,
)

ORDER = [f"{'xyz'[i]}{'xyz'[j]}" for i, j in COMPONENTS]


def lattice(counts=(4, 4, 4), side=2e-3):
    """Nodes of cubes, and springs along their edges and the diagonals of their faces."""
    grid = np.array(list(product(*map(range, counts))), dtype=float)
    near = [
        (a, b)
        for a, b in product(range(len(grid)), repeat=2)
        if a < b
        and np.abs(grid[a] - grid[b]).max() == 1
        and np.abs(grid[a] - grid[b]).sum() < 3
    ]
    return side * grid, np.array(near)


def six(matrix):
    return np.array([matrix[i, j] for i, j in COMPONENTS])


def turned(angle, axis):
    axis = np.array(axis) / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def test_components_stand_in_the_order_of_vtk():
    assert ORDER == ["xx", "yy", "zz", "xy", "yz", "xz"]


@pytest.mark.parametrize(
    "gradient",
    [
        np.diag([1.1, 1.0, 1.0]),
        np.diag([1.1, 0.95, 0.95]),
        np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.1, 0.0, 1.0]]),
        turned(1.2, (1, 2, 3)) @ np.diag([1.1, 1.1, 1.1]),
        turned(2.0, (3, -1, 1)),
    ],
)
def test_a_uniform_deformation_is_returned_at_every_node(gradient):
    drawn, ends = lattice()
    strain, ratio = Surroundings.of(drawn, ends, 3).strain(drawn @ gradient.T + 0.01)
    exact = 0.5 * (gradient.T @ gradient - np.eye(3))
    assert np.abs(strain - six(exact)).max() < 1e-12
    assert np.abs(ratio - np.linalg.det(gradient)).max() < 1e-12


def test_a_flat_net_has_no_strain_across_itself_however_it_is_turned():
    drawn, ends = lattice((4, 5, 1))
    turn = turned(0.7, (1, 1, 0))
    gradient = turn @ np.diag([1.1, 1.0, 1.0])
    for dimension in (2, 3):  # what leads nowhere is found out
        around = Surroundings.of(drawn, ends, dimension)
        strain, ratio = around.strain(drawn @ gradient.T)
        assert (around.directions == 2).all()
        assert np.abs(strain - six(np.diag([0.105, 0.0, 0.0]))).max() < 1e-12
        assert np.abs(ratio - 1.1).max() < 1e-12


def test_a_node_without_springs_is_not_strained():
    drawn, ends = lattice((2, 2, 2))
    drawn = np.concatenate([drawn, [[0.1, 0.1, 0.1]]])
    around = Surroundings.of(drawn, ends, 3)
    strain, ratio = around.strain(2.0 * drawn)
    assert around.directions[-1] == 0
    assert not strain[-1].any() and ratio[-1] == 1.0
    assert np.isfinite(strain).all()
    assert not around.virial(2.0 * drawn, np.ones(len(ends)))[-1].any()


def test_stress_sums_to_the_virial_and_balances_a_pull():
    # Springs along z only, each with the same tension: σ_zz = t n / A in the middle.
    drawn, ends = lattice((3, 3, 5), side=1e-3)
    upright = (drawn[ends[:, 0], :2] == drawn[ends[:, 1], :2]).all(axis=1)
    ends = ends[upright]
    virial = Surroundings.of(drawn, ends, 3).virial(drawn, np.full(len(ends), 2e-3))
    stress = virial / 1e-9  # as of nodes inside
    middle = np.isclose(drawn[:, 2], 2e-3)
    assert np.allclose(stress[middle], [0, 0, 2e-3 / 1e-6, 0, 0, 0], rtol=1e-12)
    ending = np.isclose(drawn[:, 2], 0.0)
    assert np.allclose(stress[ending, 2], 1e-3 / 1e-6, rtol=1e-12)
    total = virial.sum(axis=0)
    assert total[2] == pytest.approx(len(ends) * 2e-3 * 1e-3, rel=1e-12)


def test_stress_turns_with_the_net():
    drawn, ends = lattice((3, 3, 3))
    random = np.random.default_rng(3)
    tension = random.normal(size=len(ends))
    around, turn = Surroundings.of(drawn, ends, 3), turned(0.9, (1, -2, 1))
    here = around.virial(drawn, tension)
    there = around.virial(drawn @ turn.T, tension)
    full = here[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    expected = np.array([six(turn @ one @ turn.T) for one in full])
    assert np.allclose(there, expected, rtol=1e-12, atol=1e-12 * np.abs(here).max())
    assert np.allclose(von_mises(there), von_mises(here), rtol=1e-12)


def test_von_mises_is_the_pull_of_a_bar_and_leaves_out_pressure():
    pull, shear = np.array([[7.0, 0, 0, 0, 0, 0]]), np.array([[0.0, 0, 0, 2, 0, 0]])
    assert von_mises(pull) == pytest.approx([7.0])
    assert von_mises(pull + np.array([3, 3, 3, 0, 0, 0])) == pytest.approx([7.0])
    assert von_mises(shear) == pytest.approx([2.0 * np.sqrt(3.0)])


def test_means_are_over_the_springs_of_a_node():
    ends = np.array([[0, 1], [1, 2]])
    assert mean_of_springs(ends, np.array([2.0, 4.0]), 4).tolist() == [2.0, 3.0, 4.0, 0.0]


def test_hats_count_each_site_of_a_crystal_alike():
    cubes, _ = lattice((5, 5, 5), side=1.0)
    both = np.concatenate([cubes, cubes + 0.5])  # body-centred
    near = hats(both, 1.0)
    middle = np.flatnonzero((np.abs(both - 2.25) < 0.6).all(axis=1))
    of_cubes = near[:, : len(cubes)].sum(axis=1)
    of_centres = near[:, len(cubes) :].sum(axis=1)
    assert np.allclose(of_cubes[middle], 1.0, rtol=1e-12)
    assert np.allclose(of_centres[middle], 1.0, rtol=1e-12)
    assert (hats(cubes, 1.0) != np.eye(len(cubes))).sum() == 0
