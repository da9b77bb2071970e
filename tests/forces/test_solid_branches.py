"""Elements that relax: energies, rates, dissipation and tangents of branches."""

import numpy as np
import pytest

from tests.derivatives import forces
from tests.forces.remembering import (
    agree,
    at_rest,
    follow_from_the_energy,
    give_way_beside_what_stays,
    give_way_for_good,
    in_motion,
    lost_as_the_energy_falls,
    moved,
    own_states,
    parts_agree,
    rates,
    strains,
    with_rows,
)
from tests.forces.test_elements import BULK, SHEAR, SPAN, mesh
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.element_memory import Branches
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.forces.solids.solid_strain import Prestretch
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import MooneyRivlin
from tissuec.validate.forces.elements import ElementSolid

TIMES = 0.02, 0.5  # [s]


def solid(name, *, cells=1, displaced=0.15, viscosity=0.0):
    """Return elements, every other of which has a second branch, and places of all nodes."""
    position, nodes = mesh(name, cells=cells, displaced=displaced)
    count = len(nodes)
    some = 1.0 + 0.5 * (np.arange(count) % 2)
    shear = SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2)])
    branches = Branches.new(shear, np.outer(TIMES, some))
    material = SolidMaterial(
        SHEAR * some, BULK * some, viscosity * some, np.zeros(count, dtype=np.int64),
        (MooneyRivlin(0.3),),
        prestretch=Prestretch(np.array([0.0, 0.6, 0.8]), False, 1.02 * some), branches=branches,
    )  # fmt: skip
    made = kind_of(SHAPES[name]).of("brain", SHAPES[name], nodes, position, material, 0, SPAN)
    return with_rows(made, position)


def given_way(made, position, **more):
    """Return velocities of all nodes in which each point gave way in its own manner."""
    points = len(made.shape.weights)
    return own_states(made, position, (made.item_count, points, 3, 3), **more)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("size", [5e-4, 6e-3], ids=["strained", "inside out"])
def test_forces_and_matrices_follow_from_the_energy(name, size):
    made, drawn = solid(name)
    position, velocity = moved(made, drawn, size), given_way(made, drawn)
    follow_from_the_energy(made, position, velocity, every=7, matrix=3e-6, rounding=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_what_is_lost_is_what_the_energy_falls_by(name):
    made, drawn = solid(name)
    position = moved(made, drawn)
    for seed in range(5):
        velocity = given_way(made, drawn, seed=seed)
        lost = lost_as_the_energy_falls(made, position, velocity, relative=1e-7, step=1e-7)
        assert lost > 0.0


def test_rates_are_those_of_the_equation_of_evolution():
    made, drawn = solid("hexahedron")
    position, velocity = moved(made, drawn), given_way(made, drawn)
    c, _ = strains(made, drawn, position)
    c = c / np.cbrt(np.linalg.det(c))[..., None, None]
    before = made.branches.tensors(velocity, 8)
    volume = np.linalg.det(before)
    inverse = np.linalg.inv(before) * np.cbrt(volume)[..., None, None]
    third = np.trace(c @ inverse, axis1=-2, axis2=-1)[..., None, None] / 3.0
    expected = (c - third * before) / made.branches.time[..., None, None, None]
    after = velocity.copy()
    after[made.internal_rows] += rates(made, position, velocity)
    found = made.branches.tensors(after, 8) - before
    there = made.branches.shear > 0.0
    np.testing.assert_allclose(found[there], expected[there], rtol=1e-9, atol=1e-9)
    # Of a volume that is not 1, all rates bring it back.
    turning = np.einsum("...kl,...lk->...", np.linalg.inv(before), expected)
    assert (turning[there] * (volume[there] - 1.0) < 1e-12).all()


def test_branches_that_gave_way_for_good_leave_no_stress_and_lose_nothing():
    made, drawn = solid("tetrahedron", cells=2)
    position, velocity = moved(made, drawn, 3e-4), given_way(made, drawn)
    give_way_for_good(made, position, velocity, force=1e-11, energy=1e-12, lost=1e-20)
    assert np.abs(rates(made, position, velocity)).max() < 1e-10
    give_way_beside_what_stays(
        made, position, given_way(made, drawn), 3, lambda v: made.branches.tensors(v, 4)
    )


def test_stress_at_nodes_includes_what_branches_bear():
    made, drawn = solid("hexahedron", cells=2, displaced=0.0)
    position, velocity = moved(made, drawn, 0.0), at_rest(made, drawn)
    # Of elements alike, half of which bear more: the mean of stress is that of virtual work.
    total, volume = made.recalling(velocity).node_stress(position)
    f = np.array([[1.2, 0.3, -0.1], [-0.2, 0.9, 0.2], [0.1, 0.1, 1.05]])
    pulled = -np.einsum("ax,ak->xk", forces(made, position, velocity), drawn)
    mean = total.sum(axis=0) / volume.sum()
    np.testing.assert_allclose(
        mean * np.linalg.det(f), pulled @ f.T / made.volume.sum(), atol=1e-9 * SHEAR
    )


@pytest.mark.parametrize("name", SHAPES)
def test_elements_of_parts_keep_their_branches(name):
    made, drawn = solid(name, cells=2)
    position, velocity = moved(made, drawn), given_way(made, drawn)
    parts_agree(made, position, velocity)


def test_the_fastest_rate_is_that_of_the_branches():
    made, drawn = solid("hexahedron")
    still = at_rest(made, drawn)
    rate = made.giving(drawn, still)
    # As drawn, prestretch alone strains the elements: tr C'/3 of the stretch 1.02.
    stretch = 1.02
    assert rate == pytest.approx((stretch**2 + 2.0 / stretch) / 3.0 / TIMES[0], rel=1e-9)
    assert made.relaxed.giving(drawn, still) == 0.0


@pytest.mark.parametrize("name", SHAPES)
def test_the_reference_agrees_by_formulas_of_its_own(name):
    made, drawn = solid(name, cells=2, viscosity=1.5)
    reference = ElementSolid(made, drawn)
    position = moved(made, drawn)
    velocity = in_motion(made, given_way(made, drawn, size=0.1))
    agree(
        made, reference, position, velocity, force=1e-11, energy=1e-11, lost=1e-10,
        kept=reference.branches,
    )  # fmt: skip


def test_the_reference_has_no_numbers_of_states_that_are_none_instead_of_failing():
    made, drawn = solid("wedge")
    branches, velocity = ElementSolid(made, drawn).branches, at_rest(made, drawn)
    given = branches.read(velocity)
    for wrong in (np.inf, 0.0):
        branches.write(np.full_like(given, wrong), velocity)
        assert not np.isfinite(velocity[made.internal_rows]).any()
