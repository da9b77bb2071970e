"""Elements that yield: energies, rates, dissipation, tangents and invariance of the flow."""

import numpy as np
import pytest

from tests.derivatives import forces
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
    strains,
    tangents_agree,
    with_rows,
)
from tests.forces.test_elements import BULK, LAWS, SHEAR, SPAN, deformed, fibres_of, mesh
from tests.forces.test_solid_branches import TIMES, given_way
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph
from tissuec.core.structs import replace
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.element_memory import Branches, ElementYield
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.forces.solids.solid_point import largest_modulus
from tissuec.forces.solids.solid_strain import Prestretch
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.validate.forces.elements import ElementSolid
from tissuec.validate.yielding import RelaxingFields

LIMIT, VISCOSITY = 0.2 * SHEAR, 30.0  # [Pa], [Pa s]


def solid(name, law=LAWS[1], *, cells=1, viscosity=0.0, fibred=True, branched=True):
    """Return elements, of which the second does not yield, and places of all nodes."""
    position, nodes = mesh(name, cells=cells)
    count = len(nodes)
    some = 1.0 + 0.5 * (np.arange(count) % 3)
    flows = np.where(np.arange(count) == 1, np.inf, 1.0)
    branches = Branches.new(
        SHEAR * np.array([0.7 * some, 0.4 * (np.arange(count) % 2)]), np.outer(TIMES, some)
    )
    material = SolidMaterial(
        SHEAR * some, BULK * some, viscosity * some, np.zeros(count, dtype=np.int64), (law,),
        fibres=fibres_of(count) if fibred else None,
        prestretch=Prestretch(np.array([0.0, 0.6, 0.8]), False, 1.02 * some),
        branches=branches if branched else None,
        yielding=ElementYield.new(LIMIT * some * flows, VISCOSITY * some * flows),
    )  # fmt: skip
    made = kind_of(SHAPES[name]).of("clay", SHAPES[name], nodes, position, material, 0, SPAN)
    return with_rows(made, position)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("size", [5e-4, 6e-3], ids=["strained", "inside out"])
@pytest.mark.parametrize("law", LAWS[:3], ids=lambda law: type(law).__name__)
def test_forces_and_matrices_follow_from_the_energy(name, size, law):
    made, drawn = solid(name, law, fibred=size < 1e-3)
    position, velocity = moved(made, drawn, size), given_way(made, drawn)
    follow_from_the_energy(made, position, velocity, every=7, matrix=3e-6, rounding=1e-14)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("size", [5e-4, 6e-3], ids=["strained", "inside out"])
def test_what_is_lost_is_what_the_energy_falls_by(name, size):
    made, drawn = solid(name, fibred=size < 1e-3)
    position = moved(made, drawn, size)
    for seed in range(5):
        velocity = given_way(made, drawn, seed=seed)
        lost = lost_as_the_energy_falls(made, position, velocity, relative=1e-5)
        relaxing = replace(made, yielding=made.yielding.stopped)
        assert lost > 1.01 * relaxing.powers(0.0, position, velocity)[1] > 0.0


@pytest.mark.parametrize("name", SHAPES)
def test_the_tangents_of_implicit_steps_are_those_of_the_loops(name):
    made, drawn = solid(name)
    position, velocity = moved(made, drawn), given_way(made, drawn)
    tangents_agree(made, position, velocity, relative=1e-6)


def test_stress_below_the_limit_makes_nothing_flow():
    made, drawn = solid("hexahedron", branched=False)
    position, still = drawn.copy(), at_rest(made, drawn)
    assert made.powers(0.0, position, still)[1] == 0.0
    assert not rates(made, position, still).any()
    assert made.powers(0.0, moved(made, drawn), still)[1] > 0.0


def test_rates_are_those_of_the_flow_in_space():
    made, drawn = solid("hexahedron", cells=2, branched=False)
    position, velocity = moved(made, drawn), given_way(made, drawn, size=0.1)
    c, j = strains(made, drawn, position)
    # Any F with FᵀF = C: what follows is turned with it.
    f, tensors = np.linalg.cholesky(c).swapaxes(-1, -2), made.yielding.tensors(velocity, 8)[0]
    elastic = f @ np.linalg.inv(tensors) @ f.swapaxes(-1, -2)
    volume = (j**2 / np.linalg.det(tensors))[..., None, None]
    b = elastic * volume ** (-1.0 / 3.0)
    shear, share = made.shear[:, None, None, None], LAWS[1].share
    # Bent hexahedra have C with a determinant of nearly J² only, so that b is not unimodular.
    wide = np.trace(b, axis1=-2, axis2=-1)[..., None, None]
    kirchhoff = shear * ((1.0 - share) * b + share * (wide * b - b @ b))
    s = kirchhoff - np.trace(kirchhoff, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
    stress = np.sqrt(1.5 * (s**2).sum(axis=(-2, -1)))
    limit, viscosity = made.yielding.limit[:, None], made.yielding.viscosity[:, None]
    pace = 1.5 * np.maximum(stress - limit, 0.0) / viscosity / stress
    assert (pace > 0.0).any()
    # Of Cp⁻¹ in space, b changes by -λ (s b + b s).
    turned = -pace[..., None, None] * (s @ elastic + elastic @ s)
    back = np.linalg.inv(f)
    by_inverse = back @ turned @ back.swapaxes(-1, -2)
    expected = -tensors @ by_inverse @ tensors
    after = velocity.copy()
    after[made.internal_rows] += rates(made, position, velocity)
    found = made.yielding.tensors(after, 8)[0] - made.yielding.tensors(velocity, 8)[0]
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())
    assert not found[1].any()
    assert np.abs(np.trace(np.linalg.solve(tensors, found), axis1=-2, axis2=-1)).max() < (
        1e-12 * np.abs(found).max()
    )


def test_rotations_change_neither_rates_nor_energies():
    made, drawn = solid("tetrahedron")
    position, velocity = moved(made, drawn), given_way(made, drawn)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    turned = position @ turn.T
    one, two = rates(made, position, velocity), rates(made, turned, velocity)
    np.testing.assert_allclose(one, two, atol=1e-10 * np.abs(one).max())
    one, two = forces(made, position, velocity), forces(made, turned, velocity)
    np.testing.assert_allclose(one @ turn.T, two, atol=1e-10 * np.abs(one).max())
    energies = [made.recalling(velocity).energy(0.0, x) for x in (position, turned)]
    assert energies[0] == pytest.approx(energies[1], rel=1e-11)


@pytest.mark.parametrize("name", SHAPES)
def test_stress_at_nodes_is_that_beyond_the_flow(name):
    made, drawn = solid(name, cells=2, fibred=False)
    velocity = given_way(made, drawn)
    # The strain of cells that bend is that of their nodes only where it is even.
    position = deformed(drawn, 0.0) if SHAPES[name].bends else moved(made, drawn)
    # Of a single element, Σ w J σ is the virtual work; its points share the nodes' volumes.
    own = made.only(np.array([3]))
    f = own.deformations(position)[0]
    pulled = -np.einsum("ax,ak->xk", forces(own, position, velocity), position)
    half = own.recalling(velocity)._recorded("cauchy", position)[0]
    cauchy = half[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]
    weight = own.drawn.volume[own.row][0]
    work = np.einsum("q,qxy->xy", weight * np.linalg.det(f), cauchy)
    stress = own.recalling(velocity).stresses(position)
    shares = np.einsum("eqa,eqxy->eaxy", own.shares, stress)
    total = np.einsum("q,qxy->xy", weight, cauchy)
    np.testing.assert_allclose(shares[0].sum(axis=0), total, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(work, pulled, atol=1e-10 * np.abs(pulled).max())


def test_stress_at_nodes_is_without_viscosity():
    made, drawn = solid("hexahedron", viscosity=5.0)
    position, velocity = moved(made, drawn), given_way(made, drawn)
    still, moving = (
        made.recalling(each).node_stress(position)[0]
        for each in (velocity, in_motion(made, velocity))
    )
    assert np.array_equal(still, moving)


def test_elements_of_parts_keep_how_they_flowed():
    made, drawn = solid("wedge", cells=2)
    position, velocity = moved(made, drawn), given_way(made, drawn)
    parts_agree(made, position, velocity)


def test_what_settles_keeps_its_flow_and_loses_its_branches():
    made, drawn = solid("hexahedron")
    position, velocity = moved(made, drawn), given_way(made, drawn)
    flow_is_kept_when_settled(made, position, velocity, points=8, force=1e-11, energy=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_the_bound_of_rates_holds_in_tension(law):
    made, drawn = solid("hexahedron", law, fibred=False, branched=False)
    made = replace(made, prestretch=None).only(np.array([0]))
    fluid = replace(made, yielding=replace(made.yielding, limit=np.zeros(1)))

    def rate(stretch, plastic):
        """Return the rate of the logarithm of the plastic stretch."""
        velocity = at_rest(fluid, drawn)
        widths = np.array([stretch, stretch**-0.5, stretch**-0.5])
        shear = np.linalg.inv(fluid.deformations(drawn)[0, 0])
        position = drawn @ (np.diag(widths) @ shear).T
        way = np.array([plastic**2, 1.0 / plastic, 1.0 / plastic])
        fluid.yielding.keep(velocity, np.broadcast_to(np.diag(way), (1, 8, 3, 3)), np.arange(1))
        after = velocity.copy()
        after[fluid.internal_rows] += rates(fluid, position, velocity)
        change = fluid.yielding.tensors(after, 8)[0, 0, 0, 0, 0] - plastic**2
        return change / (2.0 * plastic**2), fluid.giving(position, velocity)

    rates_are_bounded(fluid, drawn, rate, least=0.999999)


@pytest.mark.parametrize("stretch", [0.6, 1.0, 1.7])
def test_the_bound_of_rates_has_a_closed_form_in_tension(stretch):
    """By each derivative of a law; b = Fe Feᵀ has the eigenvalues λ², 1/λ and 1/λ."""
    b = np.array([stretch**2, 1.0 / stretch, 1.0 / stretch])
    wide, thin = ((each - each.mean()) @ each for each in (b, 1.0 / b))
    ends = [2.0 * each.mean() + np.sqrt(8.0 / 3.0 * square)
            for each, square in ((b, wide), (1.0 / b, thin))]  # fmt: skip
    if stretch > 1.0:
        assert ends[0] == pytest.approx(2.0 * b.max())
    if stretch < 1.0:
        assert ends[1] == pytest.approx(2.0 / b.min())
    due = [*ends, 2.0 * wide, 4.0 * np.sqrt(wide * thin), 2.0 * thin]
    graph = Graph()
    i1, i2 = graph.input("i1"), graph.input("i2")
    one, two = i1 - b.sum(), i2 - (1.0 / b).sum()
    energies = [i1, i2, 0.5 * one * one, one * two, 0.5 * two * two]
    moduli = [largest_modulus(each, i1, i2) for each in energies]
    found = evaluate(moduli, {"i1": b.sum(), "i2": (1.0 / b).sum()})
    np.testing.assert_allclose(np.array(found), due, atol=1e-12)


def test_the_equivalent_strain_of_a_bar_is_its_logarithm():
    way = np.diag([1.5**2, 1.0 / 1.5, 1.0 / 1.5])
    made, drawn = solid("hexahedron")
    velocity = at_rest(made, drawn)
    count = len(made.nodes)
    tensors = 7.0 * np.broadcast_to(way, (count, 8, 3, 3))
    made.yielding.keep(velocity, tensors, np.arange(count))
    yields = made.yields
    found = made.yielding.equivalent(velocity, 8)[yields]
    np.testing.assert_allclose(found, np.log(1.5), rtol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("law", [NeoHookean(), *LAWS[1:3]], ids=lambda law: type(law).__name__)
def test_the_reference_agrees_by_formulas_of_its_own(name, law):
    made, drawn = solid(name, law, cells=2, viscosity=1.5)
    position = moved(made, drawn)
    velocity = in_motion(made, given_way(made, drawn, size=0.1))
    reference = ElementSolid(made, drawn, velocity)
    agree(
        made, reference, position, velocity, force=1e-11, energy=1e-11, lost=1e-10,
        kept=RelaxingFields((reference,)), step=1e-8,
    )  # fmt: skip
    rest = replace(made, branches=None)
    bare = ElementSolid(rest, drawn, velocity)
    matrices_agree(rest, bare, position, velocity, relative=1e-10)
