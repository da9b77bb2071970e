"""Walls that yield: energies, rates, dissipation, tangents and the bound of rates."""

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.optimize import brentq

from tests.derivatives import forces
from tests.forces.remembering import (
    agree,
    drift,
    fall_of_energy,
    follow_from_the_energy,
    halves_agree,
    moved,
    own_tensors,
    rates,
    scatter,
    with_hidden_nodes,
)
from tests.forces.test_membrane_branches import TIMES, in_space
from tests.forces.test_membranes import (
    LAWS,
    PLANE,
    SHEAR,
    STRETCHES,
    THICK,
    bulk_of,
    fibres_of,
    mesh,
    wall,
)
from tissuec.forces.membrane_branches import MembraneBranches
from tissuec.forces.membrane_yield import MembraneYield, PlasticPlane
from tissuec.laws.solid.hencky import Hencky
from tissuec.laws.solid.neo_hookean import NeoHookean
from tissuec.validate.forces.membranes import MembraneWall
from tissuec.validate.relaxing import RelaxingFields

LIMIT, VISCOSITY = 0.2 * SHEAR, 30.0  # [Pa], [Pa s]


def yielding(law=LAWS[1], *, cells=2, branched=True, alike=False, **more):
    """Return triangles, of which the second does not yield, and places of all nodes."""
    count = len(mesh(cells)[1])
    some = 1.0 + 0.5 * (np.arange(count) % 3) * (not alike)
    flows = np.where((np.arange(count) == 1) & (not alike), np.inf, 1.0)
    shear = SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2)])
    branches = MembraneBranches.new(shear, np.outer(TIMES, some))
    made, position = wall(
        law, cells=cells, branches=branches if branched else None, parts=not alike,
        yielding=MembraneYield.new(LIMIT * some * flows, VISCOSITY * some * flows), **more,
    )  # fmt: skip
    return with_hidden_nodes(made, position)


def flowed(made, position, size=0.3, seed=8):
    """Return velocities of all nodes in which each tensor is symmetric and its own."""
    random = np.random.default_rng(seed)
    velocity = np.zeros_like(position)
    for kept in (made.branches, made.yielding):
        if kept is not None:
            tensors = own_tensors(random, size, (made.item_count, 2, 2))
            kept.keep(velocity, tensors[:, None], np.arange(made.item_count))
    scatter(made, velocity, random)
    return velocity


CASES = {
    "strained": (LAWS[1], 0.3, 5e-4, {}), "crumpled": (LAWS[1], 0.3, 7e-3, {}),
    "rubber": (LAWS[3], 0.4999, 5e-4, {"prestress": 0.05}),
    "fibred": (LAWS[2], 0.45, 5e-4, {"fibres": fibres_of(8)}),
    "without branches": (NeoHookean(), 0.45, 5e-4, {"branched": False}),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_forces_and_matrices_follow_from_the_energy(case):
    law, ratio, size, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn, size), flowed(made, drawn)
    follow_from_the_energy(made, position, velocity, every=4, matrix=5e-6, rounding=1e-13)


@pytest.mark.parametrize("case", CASES)
def test_what_is_lost_is_what_the_energy_falls_by(case):
    law, ratio, size, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position = moved(made, drawn, size)
    for seed in range(5):
        velocity = flowed(made, drawn, seed=seed)
        lost = made.powers(0.0, position, velocity)[1]
        relaxing = replace(made, yielding=made.yielding.stopped)
        assert lost > 1.001 * relaxing.powers(0.0, position, velocity)[1] >= 0.0
        way = drift(made, position, velocity)
        step = 1e-7 * np.abs(velocity).max() / np.abs(way).max()
        fall = fall_of_energy(made, position, velocity, way, step)
        assert lost == pytest.approx(fall, rel=1e-5)


def test_stress_below_the_limit_makes_nothing_flow():
    made, drawn = yielding(branched=False)
    still = np.zeros_like(drawn)
    assert made.powers(0.0, drawn, still)[1] == 0.0
    assert not rates(made, drawn, still).any()
    assert made.powers(0.0, moved(made, drawn, 2e-3), still)[1] > 0.0


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("way", STRETCHES)
def test_stress_and_rates_are_those_of_a_solid_without_stress_across(way, ratio):
    plane, bulk, share = STRETCHES[way], bulk_of(ratio), LAWS[1].share
    made, drawn = yielding(alike=True, branched=False, ratio=ratio)
    flat = drawn[: len(drawn) - len(made.hidden)] @ PLANE.T
    position = drawn.copy()
    position[: len(flat)] = flat @ plane.T @ PLANE
    gone = np.diag([1.3, 0.8, 0.0])
    gone[0, 1] = gone[1, 0] = 0.2
    # What a triangle's own directions make of it.
    x = flat[made.nodes]
    side = x[:, 1] - x[:, 0]
    axes = side / np.linalg.norm(side, axis=1)[:, None]
    axes = np.stack([axes, np.stack([-axes[:, 1], axes[:, 0]], axis=1)], axis=1)
    turned = axes @ gone[:2, :2] @ axes.swapaxes(1, 2)
    gone[2, 2] = 1.0 / np.linalg.det(gone[:2, :2])
    velocity = np.zeros_like(position)
    made.yielding.keep(velocity, turned[:, None], np.arange(made.item_count))

    def kirchhoff(thickness):
        """Return the deviator, and the whole stress."""
        f = in_space(plane, thickness)
        j = np.linalg.det(f)
        b = j ** (-2.0 / 3.0) * f @ np.linalg.inv(gone) @ f.T
        own = SHEAR * ((1.0 - share) * b - share * np.linalg.inv(b))
        own = own - np.trace(own) / 3.0 * np.eye(3)
        return own, own + bulk * (j - 1.0) * j * np.eye(3)

    thickness = brentq(lambda t: kirchhoff(t)[1][2, 2], 0.3, 2.5, xtol=1e-15, rtol=1e-15)
    s, whole = kirchhoff(thickness)
    f = in_space(plane, thickness)
    expected = (whole @ np.linalg.inv(f).T)[:2, :2]
    found = forces(made, position, velocity)[: len(flat)]
    piola = -np.einsum("ax,ak->xk", found @ PLANE.T, flat) / (0.02**2 * THICK)
    np.testing.assert_allclose(piola, expected, atol=1e-12 * (bulk + SHEAR))
    stress = np.sqrt(1.5 * (s**2).sum())
    pace = 1.5 * (stress - LIMIT) / VISCOSITY / stress
    assert pace > 0.0
    # Of Cp⁻¹ in space, be = F Cp⁻¹ Fᵀ changes by -λ (s be + be s).
    elastic = f @ np.linalg.inv(gone) @ f.T
    by_inverse = np.linalg.inv(f) @ (-pace * (s @ elastic + elastic @ s)) @ np.linalg.inv(f).T
    change = -gone @ by_inverse @ gone
    step = velocity.copy()
    step[made.hidden] += 1e-3 * rates(made, position, velocity)
    was, became = (made.yielding.tensors(v, 1)[0, :, 0] for v in (velocity, step))
    np.testing.assert_allclose(
        (became - was) / 1e-3, axes @ change[:2, :2] @ axes.swapaxes(1, 2),
        atol=1e-9 * np.abs(change).max() / (1.0 - 2.0 * ratio),
    )  # fmt: skip
    power = pace * (s**2).sum() * 0.02**2 * THICK
    assert made.powers(0.0, position, velocity)[1] == pytest.approx(power, rel=1e-9)


def test_elements_of_parts_keep_how_they_flowed():
    made, drawn = yielding()
    position, velocity = moved(made, drawn), flowed(made, drawn)
    halves_agree(made, position, velocity)
    known = made.recalling(velocity)
    assert known.only(np.array([0])).energy(0.0, position) == pytest.approx(
        made.only(np.array([0])).recalling(velocity).energy(0.0, position), rel=1e-13
    )


@pytest.mark.parametrize("case", CASES)
def test_what_settles_keeps_its_flow_and_loses_its_branches(case):
    law, ratio, _, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn), flowed(made, drawn)
    before = made.yielding.tensors(velocity, 1)
    made.let_relax(velocity, position, np.ones(len(position), dtype=bool))
    assert (made.yielding.tensors(velocity, 1) == before).all()
    rest = made.relaxed
    assert rest.powers(0.0, position, velocity)[1] == 0.0
    found, bare = forces(made, position, velocity), forces(rest, position, velocity)
    np.testing.assert_allclose(found, bare, atol=1e-8 * np.abs(bare).max())
    energies = [each.recalling(velocity).energy(0.0, position) for each in (made, rest)]
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)


@pytest.mark.parametrize("law", [*LAWS, Hencky()], ids=lambda law: type(law).__name__)
def test_the_bound_of_rates_holds_in_tension(law):
    made, drawn = yielding(law, alike=True, branched=False, ratio=0.4999)
    fluid = replace(made, yielding=MembraneYield(
        made.yielding.slot, made.yielding.rate, np.zeros(8), made.yielding.viscosity
    ))  # fmt: skip
    flat = drawn[: len(drawn) - len(made.hidden)] @ PLANE.T

    def rate(stretch, plastic):
        """Return the rate of the logarithm of the plastic stretch along the first side."""
        position, velocity = drawn.copy(), np.zeros_like(drawn)
        way = np.diag([plastic**2, 1.0 / plastic])
        x = flat[made.nodes]
        side = x[:, 1] - x[:, 0]
        axes = side / np.linalg.norm(side, axis=1)[:, None]
        axes = np.stack([axes, np.stack([-axes[:, 1], axes[:, 0]], axis=1)], axis=1)
        position[: len(flat)] = flat @ np.diag([stretch, stretch**-0.5]) @ PLANE
        turned = axes @ way @ axes.swapaxes(1, 2)
        fluid.yielding.keep(velocity, turned[:, None], np.arange(8))
        after = velocity.copy()
        after[fluid.hidden] += rates(fluid, position, velocity)
        change = (fluid.yielding.tensors(after, 1) - fluid.yielding.tensors(velocity, 1))[0]
        change = axes.swapaxes(1, 2) @ change[:, 0] @ axes
        return change[0, 0, 0] / (2.0 * plastic**2), fluid.giving(position, velocity)

    for stretch in (0.7, 1.0, 1.5):
        step = 1e-6
        fastest = (rate(stretch, 1.0 - step)[0] - rate(stretch, 1.0 + step)[0]) / (2.0 * step)
        bound = rate(stretch, 1.0)[1]
        assert 0.999 * fastest <= bound < 10.0 * fastest
    at_rest = 3.0 * made.shear[0] / made.yielding.viscosity[0]
    assert rate(1.0, 1.0)[1] == pytest.approx(at_rest, rel=1e-6)
    assert fluid.relaxed.giving(drawn, np.zeros_like(drawn)) == 0.0


def test_the_equivalent_strain_of_a_strip_is_its_logarithm():
    way = np.diag([1.5**2, 1.0 / 1.5])
    plastic = PlasticPlane(np.linalg.inv(way)[None], np.array([1.5]))
    np.testing.assert_allclose(plastic.equivalent, np.log(1.5), rtol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_the_reference_agrees_by_formulas_of_its_own(case):
    law, ratio, _, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, viscosity=1.5, **more)
    position, velocity = moved(made, drawn), flowed(made, drawn, size=0.1)
    bodies = len(drawn) - len(made.hidden)
    velocity[:bodies] = np.random.default_rng(2).normal(size=(bodies, 3))
    reference = MembraneWall(made, velocity)
    close = max(1.0, bulk_of(ratio) / SHEAR / 100.0)
    agree(
        made, reference, position, velocity, energy=1e-10, lost=1e-9 * close, step=1e-8,
        kept=RelaxingFields((reference,)), force=1e-11 * close,
    )  # fmt: skip
    number = np.arange(len(position))
    rest = replace(made, branches=None, remembered=None)
    bare = MembraneWall(rest, velocity)
    matrix = rest.recalling(velocity).matrix(0.0, position, number, len(number)).toarray()
    other = bare.matrix(0.0, position, number, len(number)).toarray()
    np.testing.assert_allclose(matrix, other, atol=1e-10 * close * np.abs(other).max())
    # Both give way for good alike.
    other = velocity.copy()
    RelaxingFields((reference,)).let_relax(position, velocity, np.arange(bodies))
    made.let_relax(other, position, np.ones(len(other), dtype=bool))
    np.testing.assert_allclose(
        velocity[made.hidden], other[made.hidden], atol=1e-8 * np.abs(other[made.hidden]).max()
    )
