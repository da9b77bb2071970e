"""Walls that yield: energies, rates, dissipation, tangents and the bound of rates."""

import numpy as np
import pytest

from tests.forces.remembering import (
    agree,
    at_rest,
    flow_is_kept_when_settled,
    follow_from_the_energy,
    in_motion,
    lost_as_the_energy_falls,
    matrices_agree,
    moved,
    parts_agree,
    rates,
    rates_are_bounded,
    tangents_agree,
    with_rows,
)
from tests.forces.test_membrane_branches import CASES as RELAXING
from tests.forces.test_membrane_branches import (
    GONE,
    TIMES,
    axes_of_triangles,
    bears,
    change_as,
    give_way_alike,
    give_way_for_good_alike,
    given_way,
    in_space,
    stretched,
    without_stress_across,
)
from tests.forces.test_membranes import (
    LAWS,
    SHEAR,
    STRETCHES,
    THICK,
    bulk_of,
    mesh,
    wall,
)
from tissuec.core.structs import replace
from tissuec.forces.solids.element_memory import Branches, ElementYield
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.laws.solid.stretches import Hencky
from tissuec.validate.forces.membranes import MembraneWall
from tissuec.validate.yielding import RelaxingFields

LIMIT, VISCOSITY = 0.2 * SHEAR, 30.0  # [Pa], [Pa s]


def yielding(law=LAWS[1], *, cells=2, branched=True, alike=False, **more):
    """Return triangles, of which the second does not yield, and places of all nodes."""
    count = len(mesh(cells)[1])
    some = 1.0 + 0.5 * (np.arange(count) % 3) * (not alike)
    flows = np.where((np.arange(count) == 1) & (not alike), np.inf, 1.0)
    shear = SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2)])
    branches = Branches.new(shear, np.outer(TIMES, some), 2)
    made, position = wall(
        law, cells=cells, branches=branches if branched else None, parts=not alike,
        yielding=ElementYield.new(LIMIT * some * flows, VISCOSITY * some * flows, 2), **more,
    )  # fmt: skip
    return with_rows(made, position)


CASES = RELAXING | {"without branches": (NeoHookean(), 0.45, 5e-4, {"branched": False})}


@pytest.mark.parametrize("case", CASES)
def test_forces_and_matrices_follow_from_the_energy(case):
    law, ratio, size, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn, size), given_way(made, drawn)
    follow_from_the_energy(made, position, velocity, every=4, matrix=5e-6, rounding=1e-13)


@pytest.mark.parametrize("case", CASES)
def test_what_is_lost_is_what_the_energy_falls_by(case):
    law, ratio, size, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position = moved(made, drawn, size)
    for seed in range(5):
        velocity = given_way(made, drawn, seed=seed)
        lost = lost_as_the_energy_falls(made, position, velocity, relative=1e-5)
        relaxing = replace(made, yielding=made.yielding.stopped)
        assert lost > 1.001 * relaxing.powers(0.0, position, velocity)[1] >= 0.0


def test_stress_below_the_limit_makes_nothing_flow():
    made, drawn = yielding(branched=False)
    still = at_rest(made, drawn)
    assert made.powers(0.0, drawn, still)[1] == 0.0
    assert not rates(made, drawn, still).any()
    assert made.powers(0.0, moved(made, drawn, 2e-3), still)[1] > 0.0


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("way", STRETCHES)
def test_stress_and_rates_are_those_of_a_solid_without_stress_across(way, ratio):
    plane, bulk, share = STRETCHES[way], bulk_of(ratio), LAWS[1].share
    made, drawn = yielding(alike=True, branched=False, ratio=ratio)
    flat, position = stretched(made, drawn, plane)
    axes = axes_of_triangles(made, flat)
    velocity = give_way_alike(made, made.yielding, position, axes, GONE[:2, :2])

    def kirchhoff(thickness):
        """Return the deviator, and the whole stress."""
        f = in_space(plane, thickness)
        j = np.linalg.det(f)
        b = j ** (-2.0 / 3.0) * f @ np.linalg.inv(GONE) @ f.T
        own = SHEAR * ((1.0 - share) * b - share * np.linalg.inv(b))
        own = own - np.trace(own) / 3.0 * np.eye(3)
        return own, own + bulk * np.log(j) * np.eye(3)

    thickness = without_stress_across(lambda t: kirchhoff(t)[1])
    s, whole = kirchhoff(thickness)
    f = in_space(plane, thickness)
    expected = (whole @ np.linalg.inv(f).T)[:2, :2]
    bears(made, position, velocity, flat, expected, 1e-12 * (bulk + SHEAR))
    stress = np.sqrt(1.5 * (s**2).sum())
    pace = 1.5 * (stress - LIMIT) / VISCOSITY / stress
    assert pace > 0.0
    # Of Cp⁻¹ in space, be = F Cp⁻¹ Fᵀ changes by -λ (s be + be s).
    elastic = f @ np.linalg.inv(GONE) @ f.T
    by_inverse = np.linalg.inv(f) @ (-pace * (s @ elastic + elastic @ s)) @ np.linalg.inv(f).T
    change = -GONE @ by_inverse @ GONE
    close = 1e-9 * np.abs(change).max() / (1.0 - 2.0 * ratio)
    change_as(made, made.yielding, position, velocity, axes, change[:2, :2], close)
    power = pace * (s**2).sum() * 0.02**2 * THICK
    assert made.powers(0.0, position, velocity)[1] == pytest.approx(power, rel=1e-9)


def test_elements_of_parts_keep_how_they_flowed():
    made, drawn = yielding()
    position, velocity = moved(made, drawn), given_way(made, drawn)
    parts_agree(made, position, velocity)


@pytest.mark.parametrize("case", CASES)
def test_what_settles_keeps_its_flow_and_loses_its_branches(case):
    law, ratio, _, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn), given_way(made, drawn)
    flow_is_kept_when_settled(made, position, velocity, points=1, force=1e-8, energy=1e-9)


@pytest.mark.parametrize("law", [*LAWS, Hencky()], ids=lambda law: type(law).__name__)
def test_the_bound_of_rates_holds_in_tension(law):
    made, drawn = yielding(law, alike=True, branched=False, ratio=0.4999)
    fluid = replace(made, yielding=replace(made.yielding, limit=np.zeros(8)))

    def rate(stretch, plastic):
        """Return the rate of the logarithm of the plastic stretch along the first side."""
        flat, position = stretched(fluid, drawn, np.diag([stretch, stretch**-0.5]))
        axes = axes_of_triangles(fluid, flat)
        way = np.diag([plastic**2, 1.0 / plastic])
        velocity = give_way_alike(fluid, fluid.yielding, position, axes, way)
        after = velocity.copy()
        after[fluid.internal_rows] += rates(fluid, position, velocity)
        change = (fluid.yielding.tensors(after, 1) - fluid.yielding.tensors(velocity, 1))[0]
        change = axes.swapaxes(1, 2) @ change[:, 0] @ axes
        return change[0, 0, 0] / (2.0 * plastic**2), fluid.giving(position, velocity)

    rates_are_bounded(fluid, drawn, rate, least=0.999)


def test_the_equivalent_strain_of_a_strip_is_its_logarithm():
    made, drawn = yielding(alike=True)
    velocity, way = at_rest(made, drawn), np.diag([1.5**2, 1.0 / 1.5])
    made.yielding.keep(velocity, np.broadcast_to(way, (8, 1, 2, 2)), np.arange(8))
    found = made.yielding.equivalent(velocity, 1)
    np.testing.assert_allclose(found, np.log(1.5), rtol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_the_reference_agrees_by_formulas_of_its_own(case):
    law, ratio, _, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, viscosity=1.5, **more)
    position = moved(made, drawn)
    velocity = in_motion(made, given_way(made, drawn, size=0.1))
    reference = MembraneWall(made, velocity)
    close = max(1.0, bulk_of(ratio) / SHEAR / 100.0)
    agree(
        made, reference, position, velocity, energy=1e-10, lost=1e-9 * close, step=1e-8,
        kept=RelaxingFields((reference,)), force=1e-11 * close,
    )  # fmt: skip
    rest = replace(made, branches=None)
    bare = MembraneWall(rest, velocity)
    matrices_agree(rest, bare, position, velocity, relative=1e-10 * close)
    give_way_for_good_alike(made, reference, position, velocity)


@pytest.mark.parametrize("case", CASES)
def test_the_tangents_of_implicit_steps_are_those_of_the_loops(case):
    law, ratio, size, more = CASES[case]
    made, drawn = yielding(law, ratio=ratio, **more)
    position, velocity = moved(made, drawn, size), given_way(made, drawn)
    tangents_agree(made, position, velocity, relative=1e-6)
