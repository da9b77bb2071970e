"""Walls that relax: energies, rates, dissipation and tangents of branches."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.derivatives import forces
from tests.forces.remembering import (
    FASTEST,
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
    with_rows,
)
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
from tissuec.forces.solids.element_memory import Branches
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.validate.forces.membranes import MembraneWall
from tissuec.validate.yielding import RelaxingFields

TIMES = 0.02, 0.5  # [s]


def relaxing(law=LAWS[1], *, cells=2, second=True, **more):
    """Return triangles, every other of which has a second branch, and places of all nodes."""
    count = len(mesh(cells)[1])
    some = 1.0 + 0.5 * (np.arange(count) % 2) * second
    shear = SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2) * second])
    branches = Branches.new(shear, np.outer(TIMES, some), 2)
    made, position = wall(law, cells=cells, branches=branches, **more)
    return with_rows(made, position)


def given_way(made, position, **more):
    """Return velocities of all nodes in which each triangle gave way in its own manner."""
    return own_states(made, position, (made.item_count, 1, 2, 2), **more)


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
    follow_from_the_energy(made, position, velocity, every=4, matrix=5e-6, rounding=1e-13)


@pytest.mark.parametrize("case", CASES)
def test_what_is_lost_is_what_the_energy_falls_by(case):
    law, ratio, size, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, **more)
    position = moved(made, drawn, size)
    for seed in range(5):
        velocity = given_way(made, drawn, seed=seed)
        lost = lost_as_the_energy_falls(made, position, velocity, relative=1e-6, step=1e-7)
        assert lost > 0.0


# --- closed forms -----------------------------------------------------------------------------


def in_space(plane, thickness):
    found = np.zeros((3, 3))
    found[:2, :2], found[2, 2] = plane, thickness
    return found


def axes_of_triangles(made, flat):
    """Return the first side of each triangle, and what is across it; shape (item, axis, 2)."""
    x = flat[made.nodes]
    side = x[:, 1] - x[:, 0]
    along = side / np.linalg.norm(side, axis=1)[:, None]
    return np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)


def stretched(made, drawn, plane):
    """Return drawn places in the plane of a wall, and places of all nodes, evenly deformed."""
    flat = drawn @ PLANE.T
    return flat, flat @ plane.T @ PLANE


def give_way_alike(made, kept, position, axes, gone):
    """Return velocities of all nodes in which each triangle gave way in the same manner.

    Args:
        kept: What triangles remember: one branch, or their flow.
        axes: See ``axes_of_triangles``.
        gone: In the plane of the wall, shape (2, 2).
    """
    velocity = at_rest(made, position)
    turned = axes @ gone @ axes.swapaxes(1, 2)
    kept.keep(velocity, turned[:, None], np.arange(len(axes)))
    return velocity


def bears(made, position, velocity, flat, expected, close):
    """Check the first Piola-Kirchhoff stress of a wall [Pa], by the virtual work of forces.

    Args:
        close: Differences that are allowed [Pa].
    """
    found = forces(made, position, velocity)[: len(flat)]
    piola = -np.einsum("ax,ak->xk", found @ PLANE.T, flat) / (0.02**2 * THICK)
    np.testing.assert_allclose(piola, expected, atol=close)


def change_as(made, kept, position, velocity, axes, change, close):
    """Check the rates of what triangles remember.

    Args:
        kept: What triangles remember: one branch, or their flow.
        axes: See ``axes_of_triangles``.
        change: Its rates in the plane of the wall [1/s], shape (2, 2).
        close: Differences that are allowed [1/s].
    """
    step = velocity.copy()
    step[made.internal_rows] += 1e-3 * rates(made, position, velocity)
    was, became = (kept.tensors(v, 1)[0, :, 0] for v in (velocity, step))
    np.testing.assert_allclose(
        (became - was) / 1e-3, axes @ change @ axes.swapaxes(1, 2), atol=close
    )


def without_stress_across(stress):
    """Return the thickness at which a stress, a function of it, has no part across."""
    return brentq(lambda t: stress(t)[2, 2], 0.3, 2.5, xtol=1e-15, rtol=1e-15)


#: What each triangle gave way by, of the volume 1, in space.
GONE = np.array([[1.3, 0.2, 0.0], [0.2, 0.8, 0.0], [0.0, 0.0, 1.0]])
GONE[2, 2] /= np.linalg.det(GONE)


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
    flat, position = stretched(made, drawn, plane)
    axes = axes_of_triangles(made, flat)
    velocity = give_way_alike(made, made.branches, position, axes, GONE[:2, :2])

    def stress(thickness):
        f = in_space(plane, thickness)
        j = np.linalg.det(f)
        own = SHEAR * j ** (-2.0 / 3.0) * f @ f.T
        own = own - np.trace(own) / 3.0 * np.eye(3) + bulk * np.log(j) * np.eye(3)
        return own + of_branch(shear, f, GONE)

    thickness = without_stress_across(stress)
    f = in_space(plane, thickness)
    expected = (stress(thickness) @ np.linalg.inv(f).T)[:2, :2]
    bears(made, position, velocity, flat, expected, 1e-12 * (bulk + SHEAR))
    # dCi/dt = (C' - tr(C' Ci⁻¹)/3 Ci)/τ, in the directions of each triangle.
    c = unimodular(f.T @ f)
    change = (c - np.trace(c @ np.linalg.inv(GONE)) / 3.0 * GONE) / TIMES[0]
    close = 1e-9 * np.abs(change).max() / (1.0 - 2.0 * ratio)
    change_as(made, made.branches, position, velocity, axes, change[:2, :2], close)


@pytest.mark.parametrize("case", CASES)
def test_branches_that_gave_way_for_good_leave_no_stress_and_lose_nothing(case):
    law, ratio, _, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn, 3e-4), given_way(made, drawn)
    give_way_for_good(made, position, velocity, force=1e-8, energy=1e-9, lost=1e-15)
    give_way_beside_what_stays(
        made, position, given_way(made, drawn), 0, lambda v: made.branches.tensors(v, 1)
    )


def test_triangles_of_parts_keep_their_branches():
    made, drawn = relaxing()
    position, velocity = moved(made, drawn), given_way(made, drawn)
    parts_agree(made, position, velocity)


def test_the_fastest_rate_is_that_of_the_branches():
    made, drawn = relaxing()
    still = at_rest(made, drawn)
    assert made.giving(drawn, still) == pytest.approx(1.0 / TIMES[0], rel=1e-9)
    assert made.relaxed.giving(drawn, still) == 0.0


def test_what_relaxes_does_not_count_for_limits():
    from tests.forces.test_membrane_limits import breakable

    made, drawn = breakable(LAWS[1], cells=2, stress=1e3)
    count, position = made.item_count, deformed(drawn, 5e-4)
    branches = Branches.new(np.full((1, count), SHEAR), np.full((1, count), 0.1), 2)
    more, _ = breakable(LAWS[1], cells=2, stress=1e3, branches=branches)
    found = more.stored(len(drawn), FASTEST).breakable.loads(position)
    assert np.array_equal(found, made.breakable.loads(position))


def give_way_for_good_alike(made, reference, position, velocity):
    """Check that a wall and its reference remember the same where they give way for good."""
    found, expected = velocity.copy(), velocity.copy()
    RelaxingFields((reference,)).let_relax(position, found, np.arange(len(position)))
    made.let_relax(expected, position, np.ones(len(position), dtype=bool))
    found, expected = found[made.internal_rows], expected[made.internal_rows]
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("case", CASES)
def test_the_reference_agrees_by_formulas_of_its_own(case):
    law, ratio, _, more = CASES[case]
    made, drawn = relaxing(law, ratio=ratio, viscosity=1.5, **more)
    reference = MembraneWall(made)
    position = moved(made, drawn)
    velocity = in_motion(made, given_way(made, drawn, size=0.1))
    agree(
        made, reference, position, velocity, energy=1e-10, lost=1e-9, kept=reference.branches,
        force=1e-11 * max(1.0, bulk_of(ratio) / SHEAR / 100.0),
    )  # fmt: skip
    give_way_for_good_alike(made, reference, position, velocity)
