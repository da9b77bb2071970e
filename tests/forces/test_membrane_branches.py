"""Walls that relax: energies, rates, dissipation and tangents of branches."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.derivatives import forces, slopes, stiffness
from tests.forces.test_membranes import (
    LAWS,
    PLANE,
    SHEAR,
    STRETCHES,
    THICK,
    bulk_of,
    deformed,
    fibres_of,
    mesh,
    wall,
)
from tests.forces.test_solid_branches import FASTEST, rates
from tissuec.forces.membrane_branches import MembraneBranches
from tissuec.laws.solid.neo_hookean import NeoHookean
from tissuec.validate.forces.membranes import MembraneWall
from tissuec.validate.relaxing import RelaxingFields

TIMES = 0.02, 0.5  # [s]


def relaxing(law=LAWS[1], *, cells=2, second=True, **more):
    """Return triangles, every other of which has a second branch, and places of all nodes."""
    count = len(mesh(cells)[1])
    some = 1.0 + 0.5 * (np.arange(count) % 2) * second
    shear = SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2) * second])
    branches = MembraneBranches.new(shear, np.outer(TIMES, some))
    made, position = wall(law, cells=cells, branches=branches, **more)
    made = made.stored(len(position), FASTEST)
    hidden = np.zeros((len(made.hidden), 3))
    assert made.hidden.tolist() == list(range(len(position), len(position) + len(hidden)))
    return made, np.concatenate([position, hidden])


def given_way(made, position, size=0.3, seed=8):
    """Return velocities of all nodes in which each branch has given way in its own manner."""
    random = np.random.default_rng(seed)
    tensors = np.eye(2) + size * random.uniform(-1.0, 1.0, (made.item_count, 2, 2))
    tensors = tensors @ tensors.swapaxes(-1, -2)
    velocity = np.zeros_like(position)
    made.branches.keep(velocity, tensors, np.arange(made.item_count))
    other = 0.02 * random.normal(size=(len(made.hidden), 3))
    velocity[made.hidden] += other * np.abs(velocity[made.hidden]).max()
    return velocity


def moved(made, drawn, size=5e-4):
    position = drawn.copy()
    bodies = len(drawn) - len(made.hidden)
    position[:bodies] = deformed(drawn[:bodies], size)
    return position


CASES = {
    "strained": (LAWS[1], 0.3, 5e-4, {}), "crumpled": (LAWS[1], 0.3, 7e-3, {}),
    "rubber": (LAWS[3], 0.4999, 5e-4, {"prestress": 0.05}),
    "fibred": (LAWS[2], 0.45, 5e-4, {"fibres": fibres_of(8)}),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_forces_and_matrices_follow_from_the_energy(case):
    law, ratio, size, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn, size), given_way(made, drawn)
    known = made.recalling(velocity)
    count, bodies = len(position), len(position) - len(made.hidden)
    by_energy = slopes(lambda x: known.energy(0.0, x), position, range(bodies), 1e-8)
    found = forces(made, position, velocity)
    assert not found[bodies:].any()
    np.testing.assert_allclose(found[:bodies], by_energy, atol=2e-6 * np.abs(found).max())
    matrix = known.matrix(0.0, position, np.arange(count), count).toarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-13 * np.abs(matrix).max())

    class AtOnce:
        def add_forces(self, time, x, v, to):
            made.add_forces(time, x, velocity, to)

    for column in range(0, 3 * bodies, 4):
        by_force = stiffness(AtOnce(), position, column, 1e-9)
        np.testing.assert_allclose(
            matrix[:, column], by_force, atol=5e-6 * np.abs(matrix).max()
        )


@pytest.mark.parametrize("case", CASES)
def test_what_is_lost_is_what_the_energy_falls_by(case):
    law, ratio, size, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, **more)
    position = moved(made, drawn, size)
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
        assert lost == pytest.approx((before - after) / (2.0 * step), rel=1e-6)


# --- closed forms -----------------------------------------------------------------------------


def in_space(plane, thickness):
    found = np.zeros((3, 3))
    found[:2, :2], found[2, 2] = plane, thickness
    return found


def unimodular(c):
    return c / np.cbrt(np.linalg.det(c))


def of_branch(shear, f, gone):
    """Return J σ of a branch (A. Lion, Acta Mechanica 123:1, 1997), which has no trace.

    Args:
        f, gone: F, and Ci of the volume 1.
    """
    own = np.linalg.det(f) ** (-2.0 / 3.0) * f @ np.linalg.inv(gone) @ f.T
    return shear * (own - np.trace(own) / 3.0 * np.eye(3))


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("way", STRETCHES)
def test_stress_and_rates_are_those_of_a_solid_without_stress_across(way, ratio):
    plane, bulk, shear = STRETCHES[way], bulk_of(ratio), 0.7 * SHEAR
    made, drawn = relaxing(NeoHookean(), second=False, parts=False, ratio=ratio)
    flat = drawn[: len(drawn) - len(made.hidden)] @ PLANE.T
    position = drawn.copy()
    position[: len(flat)] = flat @ plane.T @ PLANE
    gone = np.array([[1.3, 0.2, 0.0], [0.2, 0.8, 0.0], [0.0, 0.0, 1.0]])
    # What a triangle's own directions make of it.
    x = flat[made.nodes]
    side = x[:, 1] - x[:, 0]
    axes = side / np.linalg.norm(side, axis=1)[:, None]
    axes = np.stack([axes, np.stack([-axes[:, 1], axes[:, 0]], axis=1)], axis=1)
    turned = axes @ gone[:2, :2] @ axes.swapaxes(1, 2)
    gone[2, 2] = 1.0 / np.linalg.det(gone[:2, :2])
    velocity = np.zeros_like(position)
    made.branches.keep(velocity, turned, np.arange(made.item_count))

    def stress(thickness):
        f = in_space(plane, thickness)
        j = np.linalg.det(f)
        own = SHEAR * j ** (-2.0 / 3.0) * f @ f.T
        own = own - np.trace(own) / 3.0 * np.eye(3) + bulk * (j - 1.0) * j * np.eye(3)
        return own + of_branch(shear, f, gone)

    thickness = brentq(lambda t: stress(t)[2, 2], 0.3, 2.5, xtol=1e-15, rtol=1e-15)
    f = in_space(plane, thickness)
    expected = (stress(thickness) @ np.linalg.inv(f).T)[:2, :2]
    found = forces(made, position, velocity)[: len(flat)]
    piola = -np.einsum("ax,ak->xk", found @ PLANE.T, flat) / (0.02**2 * THICK)
    np.testing.assert_allclose(piola, expected, atol=1e-12 * (bulk + SHEAR))
    # dCi/dt = (C' - tr(C' Ci⁻¹)/3 Ci)/τ, in the directions of each triangle.
    c = unimodular(f.T @ f)
    change = (c - np.trace(c @ np.linalg.inv(gone)) / 3.0 * gone) / TIMES[0]
    step = velocity.copy()
    step[made.hidden] += 1e-3 * rates(made, position, velocity)
    was, became = (made.branches.tensors(v)[0] for v in (velocity, step))
    by_kernel = (became - was) / 1e-3
    np.testing.assert_allclose(
        by_kernel, axes @ change[:2, :2] @ axes.swapaxes(1, 2),
        atol=1e-9 * np.abs(change).max() / (1.0 - 2.0 * ratio),
    )  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_branches_that_gave_way_for_good_leave_no_stress_and_lose_nothing(case):
    law, ratio, _, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn, 3e-4), given_way(made, drawn)
    bodies = np.ones(len(position), dtype=bool)
    made.let_relax(velocity, position, bodies)
    found, bare = forces(made, position, velocity), forces(made.relaxed, position)
    np.testing.assert_allclose(found, bare, atol=1e-8 * np.abs(bare).max())
    energies = (each.energy(0.0, position) for each in (made.recalling(velocity), made))
    assert next(energies) == pytest.approx(next(energies), rel=1e-9)
    assert made.powers(0.0, position, velocity)[1] < 1e-15 * made.spread(0.0, position)
    # Triangles at nodes that stay do not change.
    kept = given_way(made, drawn)
    other = kept.copy()
    bodies[:] = False
    bodies[made.nodes[0]] = True
    made.let_relax(other, position, bodies)
    same = (made.branches.tensors(other) == made.branches.tensors(kept)).all(axis=(-1, -2))
    touches = bodies[made.nodes].any(axis=1)
    there = made.branches.shear > 0.0
    assert not same[there & touches].any()
    assert same[:, ~touches].all()


def test_triangles_of_parts_keep_their_branches():
    made, drawn = relaxing()
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
    made, drawn = relaxing()
    still = np.zeros_like(drawn)
    assert made.giving(drawn, still) == pytest.approx(1.0 / TIMES[0], rel=1e-9)
    assert made.relaxed.giving(drawn, still) == 0.0


def test_what_relaxes_does_not_count_for_limits():
    from tests.forces.test_membrane_limits import breakable

    made, drawn = breakable(LAWS[1], cells=2, stress=1e3)
    count, position = made.item_count, deformed(drawn, 5e-4)
    branches = MembraneBranches.new(np.full((1, count), SHEAR), np.full((1, count), 0.1))
    more, _ = breakable(LAWS[1], cells=2, stress=1e3, branches=branches)
    found = more.stored(len(drawn), FASTEST).breakable.loads(position)
    assert np.array_equal(found, made.breakable.loads(position))


@pytest.mark.parametrize("case", CASES)
def test_the_reference_agrees_by_formulas_of_its_own(case):
    law, ratio, _, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, viscosity=1.5, **more)
    reference = MembraneWall(made)
    position = moved(made, drawn)
    velocity = given_way(made, drawn, size=0.1)
    bodies = len(drawn) - len(made.hidden)
    velocity[:bodies] = np.random.default_rng(2).normal(size=(bodies, 3))
    found, own = forces(made, position, velocity), np.zeros_like(position)
    reference.add_forces(0.0, position, velocity, own)
    loose = 1e-11 * max(1.0, bulk_of(ratio) / SHEAR / 100.0)
    np.testing.assert_allclose(found, own, atol=loose * np.abs(own).max())
    energy = reference.energy(0.0, position) + reference.remembered_energy(position, velocity)
    assert made.recalling(velocity).energy(0.0, position) == pytest.approx(energy, rel=1e-10)
    lost = made.powers(0.0, position, velocity)[1]
    assert lost == pytest.approx(reference.dissipated(0.0, position, velocity), rel=1e-9)
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
    # Both give way for good alike.
    other = velocity.copy()
    fields.let_relax(position, velocity, np.arange(bodies))
    made.let_relax(other, position, np.ones(len(other), dtype=bool))
    np.testing.assert_allclose(
        velocity[made.hidden], other[made.hidden], atol=1e-8 * np.abs(other[made.hidden]).max()
    )
