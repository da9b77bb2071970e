"""Elements that relax: energies, rates, dissipation and tangents of branches."""

import numpy as np
import pytest

from tests.derivatives import forces, slopes, stiffness
from tests.forces.test_elements import BULK, SHEAR, SPAN, deformed, mesh
from tissuec.compiled.calls import kernel_on
from tissuec.forces.elements import SolidElements, SolidMaterial
from tissuec.forces.solid_branches import SolidBranches
from tissuec.forces.solid_prestretch import Prestretch
from tissuec.forces.solid_strain import SolidStrain
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.mooney_rivlin import MooneyRivlin
from tissuec.validate.forces.elements import ElementSolid
from tissuec.validate.relaxing import RelaxingFields

TIMES = 0.02, 0.5  # [s]
FASTEST = 300.0  # [1/s]


def solid(name, *, cells=1, displaced=0.15, viscosity=0.0):
    """Return elements, every other of which has a second branch, and places of all nodes."""
    position, nodes = mesh(name, cells=cells, displaced=displaced)
    count = len(nodes)
    some = 1.0 + 0.5 * (np.arange(count) % 2)
    shear = SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2)])
    branches = SolidBranches.new(shear, np.outer(TIMES, some))
    material = SolidMaterial(
        SHEAR * some, BULK * some, viscosity * some, np.zeros(count, dtype=np.int64),
        (MooneyRivlin(0.3),),
        prestretch=Prestretch(np.array([0.0, 0.6, 0.8]), False, 1.02 * some), branches=branches,
    )  # fmt: skip
    none = np.zeros((0, 2), dtype=np.int32)
    made = SolidElements.of("brain", SHAPES[name], nodes, position, material, none, 0, SPAN)
    made = made.stored(len(position), FASTEST)
    hidden = np.zeros((len(made.hidden), 3))
    assert made.hidden.tolist() == list(range(len(position), len(position) + len(hidden)))
    return made, np.concatenate([position, hidden])


def given_way(made, position, size=0.3, seed=8):
    """Return velocities of all nodes in which each branch has given way in its own manner."""
    random = np.random.default_rng(seed)
    tensors = np.eye(3) + size * random.uniform(-1.0, 1.0, (made.item_count, 8, 3, 3))
    tensors = tensors @ tensors.swapaxes(-1, -2)
    velocity = np.zeros_like(position)
    points = len(made.shape.weights)
    made.branches.keep(velocity, tensors[:, :points], np.arange(made.item_count))
    other = 0.02 * random.normal(size=(len(made.hidden), 3))
    velocity[made.hidden] += other * np.abs(velocity[made.hidden]).max()
    return velocity


def moved(made, drawn, size=5e-4):
    position = drawn.copy()
    bodies = len(drawn) - len(made.hidden)
    position[:bodies] = deformed(drawn[:bodies], size)
    return position


def rates(made, position, velocity):
    """Return what the kernel adds to hidden nodes, the rates of what they keep [m/s²]."""
    found, power = np.zeros_like(position), np.zeros(2)
    table = made.table(np.arange(len(position)), None, position)
    kernel_on(made.kernel, table)(
        0.0, position.ravel(), velocity.ravel(), found.reshape(-1), power
    )
    return found[made.hidden]


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("size", [5e-4, 6e-3], ids=["strained", "inside out"])
def test_forces_and_matrices_follow_from_the_energy(name, size):
    made, drawn = solid(name)
    position, velocity = moved(made, drawn, size), given_way(made, drawn)
    known = made.recalling(velocity)
    count, bodies = len(position), len(position) - len(made.hidden)
    by_energy = slopes(lambda x: known.energy(0.0, x), position, range(bodies), 1e-8)
    found = forces(made, position, velocity)
    assert not found[bodies:].any()
    np.testing.assert_allclose(found[:bodies], by_energy, atol=2e-6 * np.abs(found).max())
    matrix = known.matrix(0.0, position, np.arange(count), count).toarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-14 * np.abs(matrix).max())

    class AtOnce:
        def add_forces(self, time, x, v, to):
            made.add_forces(time, x, velocity, to)

    for column in range(0, 3 * bodies, 7):
        by_force = stiffness(AtOnce(), position, column, 1e-9)
        np.testing.assert_allclose(
            matrix[:, column], by_force, atol=3e-6 * np.abs(matrix).max()
        )


@pytest.mark.parametrize("name", SHAPES)
def test_what_is_lost_is_what_the_energy_falls_by(name):
    made, drawn = solid(name)
    position = moved(made, drawn)
    for seed in range(5):
        velocity = given_way(made, drawn, seed=seed)
        lost = made.powers(0.0, position, velocity)[1]
        assert lost > 0.0
        way, step = np.zeros_like(velocity), 1e-7
        way[made.hidden] = rates(made, position, velocity)
        after, before = (
            made.recalling(velocity + sign * step * way).energy(0.0, position)
            for sign in (1, -1)
        )
        assert lost == pytest.approx((before - after) / (2.0 * step), rel=1e-7)


def test_rates_are_those_of_the_equation_of_evolution():
    made, drawn = solid("hexahedron")
    position, velocity = moved(made, drawn), given_way(made, drawn)
    strain = SolidStrain(made.deformations(position))
    c = strain.f.swapaxes(-1, -2) @ strain.f * (strain.j ** (-2.0 / 3.0))[..., None, None]
    before = made.branches.tensors(velocity, 8)
    volume = np.linalg.det(before)
    inverse = np.linalg.inv(before) * np.cbrt(volume)[..., None, None]
    third = np.trace(c @ inverse, axis1=-2, axis2=-1)[..., None, None] / 3.0
    expected = (c - third * before) / made.branches.time[..., None, None, None]
    after = velocity.copy()
    after[made.hidden] += rates(made, position, velocity)
    found = made.branches.tensors(after, 8) - before
    there = made.branches.shear > 0.0
    np.testing.assert_allclose(found[there], expected[there], rtol=1e-9, atol=1e-9)
    # Of a volume that is not 1, all rates bring it back.
    turning = np.einsum("...kl,...lk->...", np.linalg.inv(before), expected)
    assert (turning[there] * (volume[there] - 1.0) < 1e-12).all()


def test_branches_that_gave_way_for_good_leave_no_stress_and_lose_nothing():
    made, drawn = solid("tetrahedron", cells=2)
    position, velocity = moved(made, drawn, 3e-4), given_way(made, drawn)
    bodies = np.ones(len(position), dtype=bool)
    made.let_relax(velocity, position, bodies)
    found, bare = forces(made, position, velocity), forces(made.relaxed, position)
    np.testing.assert_allclose(found, bare, atol=1e-11 * np.abs(bare).max())
    energies = (each.energy(0.0, position) for each in (made.recalling(velocity), made))
    assert next(energies) == pytest.approx(next(energies), rel=1e-12)
    assert made.powers(0.0, position, velocity)[1] < 1e-20 * made.spread(0.0, position)
    assert np.abs(rates(made, position, velocity)).max() < 1e-10
    # Elements at nodes that stay do not change.
    kept = given_way(made, drawn)
    other = kept.copy()
    bodies[:] = False
    bodies[made.nodes[3]] = True
    made.let_relax(other, position, bodies)
    same = (made.branches.tensors(other, 4) == made.branches.tensors(kept, 4)).all(
        axis=(-1, -2)
    )
    touches = bodies[made.nodes].any(axis=1)
    there = made.branches.shear > 0.0
    assert not same[there & touches].any()
    assert same[:, ~touches].all()


def test_stress_at_nodes_includes_what_branches_bear():
    made, drawn = solid("hexahedron", cells=2, displaced=0.0)
    position, velocity = moved(made, drawn, 0.0), np.zeros_like(drawn)
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
    whole = forces(made, position, velocity)
    halves = [made.only(np.arange(k, made.item_count, 2)) for k in (0, 1)]
    parts = [forces(half, position, velocity) for half in halves]
    np.testing.assert_allclose(sum(parts), whole, atol=1e-12 * np.abs(whole).max())
    energies = [half.recalling(velocity).energy(0.0, position) for half in halves]
    energy = made.recalling(velocity).energy(0.0, position)
    assert sum(energies) == pytest.approx(energy, rel=1e-13)
    chosen = made.recalling(velocity).only(np.array([1]))
    assert chosen.energy(0.0, position) == pytest.approx(
        halves[1].only(np.array([0])).recalling(velocity).energy(0.0, position), rel=1e-13
    )
    assert sorted(np.concatenate([half.hidden for half in halves])) == made.hidden.tolist()


def test_the_fastest_rate_is_that_of_the_branches():
    made, drawn = solid("hexahedron")
    still = np.zeros_like(drawn)
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
    velocity = given_way(made, drawn, size=0.1)
    velocity[: len(drawn) - len(made.hidden)] = np.random.default_rng(2).normal(
        size=(len(drawn) - len(made.hidden), 3)
    )
    found, own = forces(made, position, velocity), np.zeros_like(position)
    reference.add_forces(0.0, position, velocity, own)
    np.testing.assert_allclose(found, own, atol=1e-11 * np.abs(own).max())
    energy = reference.energy(0.0, position) + reference.remembered_energy(position, velocity)
    assert made.recalling(velocity).energy(0.0, position) == pytest.approx(energy, rel=1e-11)
    lost = made.powers(0.0, position, velocity)[1]
    assert lost == pytest.approx(reference.dissipated(0.0, position, velocity), rel=1e-10)
    # Its unknowns are the inverses, whose rates follow from those of the tensors.
    branches, fields = reference.branches, RelaxingFields((reference,))
    given = branches.read(velocity)
    copied = np.zeros_like(velocity)
    branches.write(given, copied)
    np.testing.assert_allclose(copied[made.hidden], velocity[made.hidden], rtol=1e-9, atol=1e-9)
    step, way = 1e-7, np.zeros_like(velocity)
    way[made.hidden] = rates(made, position, velocity)
    after, before = (branches.read(velocity + sign * step * way) for sign in (1, -1))
    expected = (after - before) / (2.0 * step)
    np.testing.assert_allclose(
        fields.rates(position, velocity), expected, atol=1e-6 * np.abs(expected).max()
    )


def test_the_reference_has_no_numbers_of_states_that_are_none_instead_of_failing():
    made, drawn = solid("wedge")
    branches, velocity = ElementSolid(made, drawn).branches, np.zeros_like(drawn)
    given = branches.read(velocity)
    for wrong in (np.inf, 0.0):
        branches.write(np.full_like(given, wrong), velocity)
        assert not np.isfinite(velocity[made.hidden]).any()
