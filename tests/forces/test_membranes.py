"""Walls of triangles against energies, closed forms, and formulas of the reference."""

from itertools import combinations_with_replacement

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.derivatives import agree, follow_from_the_energy, forces
from tests.forces.test_elements import deformed
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.forces.solids.solid_strain import SolidFibres
from tissuec.forces.surfaces.membranes import MembraneMaterial, Membranes
from tissuec.laws.solid.invariants import (
    MooneyRivlin,
    NeoHookean,
    SolidExponential,
    VerondaWestmann,
    Yeoh,
)
from tissuec.laws.solid.stretches import Hencky, Ogden
from tissuec.meshes.elements import wall_of_triangles
from tissuec.meshes.generators.tube import Tube
from tissuec.validate.forces.membranes import MembraneWall

LAWS = (NeoHookean(), MooneyRivlin(0.3), Yeoh(0.6, 1.8), SolidExponential(0.4),
        VerondaWestmann(0.3))  # fmt: skip
SPAN = Span(Source("scene", ""), 0, 0)
SHEAR = 2e3  # [Pa]
THICK = 1e-3  # [m]
RATIOS = (0.0, 0.3, 0.49, 0.4999)
#: Two directions of a plane that is tilted in space.
PLANE = np.linalg.qr(np.array([[1.0, 0.3, 0.2], [0.2, -1.0, 0.5]]).T)[0].T


def bulk_of(ratio):
    return SHEAR * 2.0 * (1.0 + ratio) / (3.0 * (1.0 - 2.0 * ratio))


def mesh(cells=3, displaced=0.2, seed=3):
    """Return places in the plane and triangles of a square of 20 mm; inner nodes displaced."""
    count = cells + 1
    number = np.arange(count**2).reshape(count, count)
    steps = np.linspace(0.0, 0.02, count)
    flat = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    inner = ((flat > 1e-9) & (flat < 0.02 - 1e-9)).all(axis=1)
    moved = np.random.default_rng(seed).uniform(-1.0, 1.0, flat.shape)
    flat = flat + displaced * 0.02 / cells * moved * inner[:, None]
    a, b, c, d = (number[i:cells + i, j:cells + j].ravel()
                  for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))  # fmt: skip
    return flat, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def fibres_of(count, seed=4):
    """Return two families of fibres in directions of each triangle's own."""
    random = np.random.default_rng(seed)
    along = random.normal(size=(count, 2, 3))
    numbers = random.uniform((1e3, 0.2, 0.0), (4e3, 0.6, 0.3), (count, 3))
    return SolidFibres(along, *np.ascontiguousarray(numbers.T))


def wall(
    law, *, ratio=0.3, viscosity=0.0, fibres=None, prestress=0.0, axis=None, parts=True,
    limits=None, branches=None, yielding=None, **more
):  # fmt: skip
    """Return triangles, of two materials with ``parts``, and where their nodes are drawn."""
    flat, nodes = mesh(**more)
    position, count = flat @ PLANE, len(nodes)
    part = 1.0 + (np.arange(count) % 2) * parts
    material = MembraneMaterial(
        SHEAR * part, bulk_of(ratio) * part, viscosity * part, np.zeros(count, dtype=np.int64),
        (law,), np.full(count, THICK), np.full(count, 1.0 / (1.0 - prestress)), axis, fibres,
        limits, branches, yielding,
    )  # fmt: skip
    return Membranes.of("skin", nodes, position, material, 0, SPAN), position


CASES = [(law, ratio, False) for law in LAWS for ratio in RATIOS]
CASES += [(LAWS[1], ratio, True) for ratio in RATIOS]
NAMES = [f"{type(law).__name__}, {n}{', fibres' if fibred else ''}" for law, n, fibred in CASES]


@pytest.mark.parametrize(("law", "ratio", "fibred"), CASES, ids=NAMES)
@pytest.mark.parametrize("size", [1e-3, 7e-3], ids=["strained", "crumpled"])
def test_forces_and_matrices_follow_from_the_energy(law, ratio, fibred, size):
    fibres = fibres_of(8) if fibred else None
    made, drawn = wall(law, ratio=ratio, cells=2, fibres=fibres)
    position = deformed(drawn, min(size, 3e-3) if fibred else size)
    assert abs(made.energy(0.0, drawn)) < 1e-12 * made.spread(0.0, drawn)
    follow_from_the_energy(made, position, every=5, force=2e-6, matrix=3e-6, rounding=1e-13)


@pytest.mark.parametrize(("law", "ratio", "fibred"), CASES, ids=NAMES)
def test_the_reference_agrees_by_formulas_of_its_own(law, ratio, fibred):
    fibres = fibres_of(18) if fibred else None
    made, drawn = wall(law, ratio=ratio, viscosity=1.5, fibres=fibres, prestress=0.05)
    reference = MembraneWall(made)
    for size in (1e-3, 3e-3):
        position = deformed(drawn, size)
        velocity = np.random.default_rng(2).normal(size=position.shape)
        # The stress across is a difference of terms of K, which rounding spoils.
        loose = 1e-11 * max(1.0, bulk_of(ratio) / SHEAR / 100.0)
        agree(
            made, reference, position, velocity,
            force=loose, matrix=10.0 * loose, energy=1e-10, lost=1e-10,
        )  # fmt: skip


# --- uniform strain ---------------------------------------------------------------------------

#: Stretches of the plane.
STRETCHES = {
    "pulled": np.diag([1.4, 0.8]),
    "pressed": np.diag([0.7, 1.1]),
    "equibiaxial": 1.3 * np.eye(2),
    "shear": np.array([[1.0, 0.5], [0.0, 1.0]]),
}


def uniform(made, drawn, plane):
    """Return P of a uniform strain in the directions of the plane, and all forces.

    Virtual work: Σ f ⊗ X over all nodes is -V P, V being the volume as drawn.
    """
    flat = drawn @ PLANE.T
    found = forces(made, flat @ plane.T @ PLANE)
    return found, -np.einsum("ax,ak->xk", found @ PLANE.T, flat) / (0.02**2 * THICK)


def derivatives(law, i1, i2):
    """Return ψ1 and ψ2."""
    match law:
        case NeoHookean():
            return 0.5, 0.0
        case MooneyRivlin(share=s):
            return 0.5 * (1.0 - s), 0.5 * s
        case Yeoh(second=c, third=d):
            return 0.5 + c * (i1 - 3.0) + 1.5 * d * (i1 - 3.0) ** 2, 0.0
        case SolidExponential(stiffening=k):
            return 0.5 * np.exp(k * (i1 - 3.0)), 0.0
        case VerondaWestmann(stiffening=k):
            return np.exp(k * (i1 - 3.0)), -0.5
    raise TypeError(law)


def cauchy(law, bulk, plane, thickness):
    """Return σ of a compressible solid with B = F Fᵀ (G. A. Holzapfel 2000, eq. 6.97)."""
    f = np.zeros((3, 3))
    f[:2, :2], f[2, 2] = plane, thickness
    j = np.linalg.det(f)
    b = j ** (-2.0 / 3.0) * f @ f.T
    i1, i2 = np.trace(b), 0.5 * (np.trace(b) ** 2 - np.trace(b @ b))
    first, second = derivatives(law, i1, i2)
    extra = 2.0 * SHEAR / j * ((first + i1 * second) * b - second * b @ b)
    return extra - np.trace(extra) / 3.0 * np.eye(3) + bulk * np.log(j) / j * np.eye(3)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("way", STRETCHES)
def test_each_law_gives_its_stress_in_any_mesh(law, ratio, way):
    plane, bulk = STRETCHES[way], bulk_of(ratio)
    made, drawn = wall(law, ratio=ratio, parts=False)
    found, piola = uniform(made, drawn, plane)
    thickness = brentq(
        lambda t: cauchy(law, bulk, plane, t)[2, 2], 0.3, 2.5, xtol=1e-15, rtol=1e-15
    )
    stress = cauchy(law, bulk, plane, thickness)[:2, :2]
    expected = np.linalg.det(plane) * thickness * stress @ np.linalg.inv(plane).T
    np.testing.assert_allclose(piola, expected, atol=2e-13 * (bulk + SHEAR))
    np.testing.assert_allclose(piola, expected, atol=1e-6 * SHEAR)
    # Inner nodes are in equilibrium.
    flat = drawn @ PLANE.T
    inner = ((flat > 1e-9) & (flat < 0.02 - 1e-9)).all(axis=1)
    assert np.abs(found[inner]).max() < 1e-12 * np.abs(found).max() * max(1.0, bulk / SHEAR)
    total, volume = made.node_stress(flat @ plane.T @ PLANE)
    np.testing.assert_allclose(
        PLANE @ (total / volume[:, None, None]) @ PLANE.T,
        np.tile(stress, (len(drawn), 1, 1)), atol=2e-13 * (bulk + SHEAR),
    )  # fmt: skip


@pytest.mark.parametrize("law", [NeoHookean(), MooneyRivlin(0.3)], ids=["neo", "mooney"])
def test_a_nearly_incompressible_sheet_follows_the_formulas_of_rubber(law):
    # P. Treloar, The Physics of Rubber Elasticity, 1975: σ = 2 μ (λ² - λ⁻⁴)(ψ1 + λ² ψ2) in
    # equibiaxial stretch.
    made, drawn = wall(law, ratio=0.499999, parts=False)
    for stretch in (0.8, 1.1, 1.5, 3.0):
        _, piola = uniform(made, drawn, stretch * np.eye(2))
        first, second = derivatives(law, 0.0, 0.0)
        stress = 2.0 * SHEAR * (stretch**2 - stretch**-4) * (first + stretch**2 * second)
        np.testing.assert_allclose(piola, stress / stretch * np.eye(2), rtol=2e-4, atol=1e-7)


PRINCIPAL = {
    "ogden": (Ogden(5.0), lambda x: 2.0 * SHEAR / 5.0 * x**5.0),
    "two terms": (
        Ogden(-3.0, second_exponent=7.0, second_share=0.4),
        lambda x: -2.0 / 3.0 * 0.6 * SHEAR * x**-3.0 + 2.0 / 7.0 * 0.4 * SHEAR * x**7.0,
    ),
    "hencky": (Hencky(), lambda x: 2.0 * SHEAR * np.log(x)),
}


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("name", PRINCIPAL)
@pytest.mark.parametrize("way", ["pulled", "pressed", "equibiaxial"])
def test_laws_in_principal_stretches(name, ratio, way):
    # J σ_i is x dψ/dx without its mean over the isochoric stretches x, plus K ln J.
    law, slope = PRINCIPAL[name]
    plane, bulk = np.diag(STRETCHES[way]), bulk_of(ratio)

    def stress(thickness):
        stretch = np.array([*plane, thickness])
        j = stretch.prod()
        part = slope(j ** (-1.0 / 3.0) * stretch)
        return part - part.mean() + bulk * np.log(j)

    thickness = brentq(lambda t: stress(t)[2], 0.3, 2.5, xtol=1e-15, rtol=1e-15)
    made, drawn = wall(law, ratio=ratio, parts=False)
    _, piola = uniform(made, drawn, np.diag(plane))
    np.testing.assert_allclose(piola, np.diag(stress(thickness)[:2] / plane), atol=1e-6 * SHEAR)


@pytest.mark.parametrize("ratio", [-0.4, *RATIOS])
def test_small_strain_has_the_plate_modulus(ratio):
    made, drawn = wall(NeoHookean(), ratio=ratio, parts=False)
    young, small = 2.0 * SHEAR * (1.0 + ratio), 1e-6
    _, piola = uniform(made, drawn, np.eye(2) + np.diag([small, 0.0]))
    np.testing.assert_allclose(
        np.diag(piola), young / (1.0 - ratio**2) * small * np.array([1.0, ratio]),
        atol=3e-6 * young * small * max(1.0, 1e-4 * bulk_of(ratio) / SHEAR),
    )  # fmt: skip


def test_fibres_add_four_times_k1_along_them():
    along, part = np.array([0.6, 0.8]), 1e-6
    count = len(mesh()[1])
    fibres = SolidFibres(
        np.tile(along @ PLANE, (count, 1, 1)), np.full(count, 7e3), np.full(count, 3.0),
        np.zeros(count),
    )  # fmt: skip
    line = np.outer(along, along)
    made = [wall(NeoHookean(), fibres=each, parts=False) for each in (fibres, None)]
    longer, plain = (uniform(*one, np.eye(2) + part * line)[1] for one in made)
    np.testing.assert_allclose(longer - plain, 4.0 * 7e3 * part * line, atol=1e-4 * 7e3 * part)
    shorter, plain = (uniform(*one, np.eye(2) - part * line)[1] for one in made)
    assert np.abs(shorter - plain).max() == 0.0


@pytest.mark.parametrize("part", [0.1, -0.05])
def test_prestress_along_an_axis_is_that_of_a_bar(part):
    axis = np.array([0.8, 0.6])
    made, drawn = wall(NeoHookean(), ratio=0.49999, prestress=part, axis=axis @ PLANE,
                       parts=False)  # fmt: skip
    _, piola = uniform(made, drawn, np.eye(2))
    longer = 1.0 / (1.0 - part)
    stress = SHEAR * (longer**2 - 1.0 / longer)
    np.testing.assert_allclose(
        piola, stress * np.outer(axis, axis), rtol=1e-3, atol=1e-4 * abs(stress)
    )


def test_a_prestressed_sheet_is_as_one_that_is_stretched():
    law, part = Yeoh(0.6, 1.8), 0.1
    stressed, drawn = wall(law, prestress=part, parts=False)
    plain, _ = wall(law, parts=False)
    longer = 1.0 / (1.0 - part)
    _, found = uniform(stressed, drawn, np.eye(2))
    thickness = plain.thinner(longer * drawn)[0]
    _, piola = uniform(plain, drawn, longer * np.eye(2))
    # The same true stress, in a wall that is as thick as said where it is drawn.
    np.testing.assert_allclose(found, piola / (longer * thickness), rtol=1e-12, atol=1e-9)
    assert stressed.weight.sum() == pytest.approx(
        0.02**2 * THICK / (longer**2 * thickness), rel=1e-12
    )


@pytest.mark.parametrize("law", [NeoHookean(), MooneyRivlin(0.3)], ids=["neo", "mooney"])
def test_a_wider_tube_needs_the_pressure_of_laplace(law):
    # Of both laws, σ = μ (λ² - λ⁻²) around a tube that becomes no longer (R. S. Rivlin, Phil.
    # Trans. R. Soc. A 242:173, 1949).
    sides, radius, step = 24, 0.005, 0.001
    tube = Tube(axis=((0, 0, 0), (4 * step, 0, 0)), radius=radius, rings=5, sides=sides)
    mesh = wall_of_triangles(tube.build())
    x, nodes = mesh.position, mesh.elements[0].nodes
    even = np.ones(len(nodes))
    material = MembraneMaterial(
        SHEAR * even, bulk_of(0.49999) * even, 0.0 * even, np.zeros(len(nodes), dtype=np.int64),
        (law,), THICK * even, even,
    )  # fmt: skip
    made = Membranes.of("tube", nodes, x, material, 0, SPAN)
    ring = np.arange(2 * sides, 3 * sides)
    for stretch in (0.9, 1.1, 1.6, 2.5):
        wide = x * [1.0, stretch, stretch]
        outward = wide[ring] * [0.0, 1.0, 1.0] / (stretch * radius)
        inward = -np.einsum("nk,nk->n", forces(made, wide)[ring], outward)
        tension = SHEAR * (stretch**2 - stretch**-2) / stretch * THICK
        # Each facet pulls its two nodes along itself.
        expected = 2.0 * tension * step * np.sin(np.pi / sides)
        np.testing.assert_allclose(inward, expected, rtol=1e-3)


# --- states that are hard ---------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [-0.9, -0.3, *RATIOS])
@pytest.mark.parametrize("law", LAWS[:3], ids=lambda law: type(law).__name__)
def test_thickness_is_found_at_any_stretch(law, ratio):
    made, drawn = wall(law, ratio=ratio, cells=1, parts=False)
    flat = drawn @ PLANE.T
    sizes = [0.0, 1e-8, 1e-3, 0.1, 0.21, 0.5, 1.0, 3.0, 12.0]
    for one, other in combinations_with_replacement(sizes, 2):
        position = flat @ np.diag([one, other]) @ PLANE
        found = forces(made, position)
        assert np.isfinite(found).all(), (one, other)
        # By the logarithm of the root of the volume, a third of that of the thickness.
        slope, bend = (each[:, 0] for each in made.seen("across", position))
        slope, bend = slope / 3.0, bend / 9.0
        assert (np.abs(slope) <= 1e-10 * np.maximum(bend, made.bulk)).all(), (one, other)
        p = -np.einsum("ax,ak->xk", found @ PLANE.T, flat) / (0.02**2 * THICK)
        np.testing.assert_allclose(
            PLANE @ made.piola(position)[0, 0], p,
            atol=1e-10 * (np.abs(p).max() + made.bulk[0] * made.thinner(position).max()),
        )  # fmt: skip


def test_a_triangle_that_is_pressed_into_a_line_opens_again():
    made, drawn = wall(NeoHookean(), ratio=0.45, cells=1, parts=False)
    flat = drawn @ PLANE.T
    for width in (1e-3, 1e-2, 0.1):
        _, piola = uniform(made, drawn, np.diag([1.0, width]))
        assert piola[1, 1] < -SHEAR * width
    closed = forces(made, flat @ np.diag([1.0, 0.0]) @ PLANE)
    assert np.isfinite(closed).all()


def test_viscous_forces_are_those_of_their_matrix():
    made, drawn = wall(NeoHookean(), viscosity=1.5)
    position, count = deformed(drawn, 2e-3), len(drawn)
    velocity = np.random.default_rng(2).normal(size=position.shape)
    braking = forces(made, position, velocity) - forces(made, position)
    _, matrix = made.damping_matrices(position, velocity, np.arange(count), count)
    np.testing.assert_allclose(
        braking.ravel(), -matrix @ velocity.ravel(), atol=1e-12 * np.abs(braking).max()
    )
    power = velocity.ravel() @ (matrix @ velocity.ravel())
    assert made.powers(0.0, position, velocity)[1] == pytest.approx(power, rel=1e-12)
    lowest = float(np.linalg.eigvalsh(matrix.toarray())[0])
    assert lowest > -1e-13 * np.abs(matrix.toarray()).max()
    turning = np.cross(np.array([3.0, 1.0, 2.0]), position)
    still = forces(made, position, turning) - forces(made, position)
    assert np.abs(still).max() < 1e-12 * np.abs(braking).max()


def test_viscosity_is_that_of_trouton():
    # Three times the viscosity in uniaxial flow without change of volume, six times in
    # equibiaxial flow (F. T. Trouton, Proc. R. Soc. A 77:426, 1906).
    made, drawn = wall(NeoHookean(), ratio=0.4999999, viscosity=1.5, parts=False)
    flat, rate = drawn @ PLANE.T, 0.7
    for plane, factor in (([1.0, -0.5], 3.0), ([1.0, 1.0], 6.0)):
        velocity = flat @ (rate * np.diag(plane)) @ PLANE
        braking = forces(made, drawn, velocity) - forces(made, drawn)
        stress = -np.einsum("ax,ak->xk", braking @ PLANE.T, flat) / (0.02**2 * THICK)
        assert stress[0, 0] == pytest.approx(factor * 1.5 * rate, rel=1e-6)


def test_threads_share_triangles_without_another_bit():
    made, drawn = wall(Yeoh(0.6, 1.8), cells=5)
    position = deformed(drawn, 2e-3)
    parts = [made.only(np.arange(k, made.item_count, 3)) for k in range(3)]
    whole = made.energies(position)
    for k, part in enumerate(parts):
        assert (part.energies(position) == whole[k::3]).all()


def test_a_triangle_without_an_area_is_refused():
    _, drawn = wall(NeoHookean(), cells=1)
    material = MembraneMaterial(
        *np.full((3, 1), SHEAR), np.zeros(1, int), (NeoHookean(),), *np.full((2, 1), 0.1)
    )
    with pytest.raises(ValueError, match="triangle 0 has no area"):
        Membranes.of("a", np.array([[0, 1, 1]]), drawn, material,
                     0, SPAN)  # fmt: skip


def test_a_lost_edge_takes_its_triangles_with_it():
    made, _ = wall(NeoHookean(), cells=2)
    alive = np.ones(int(made.walls.max()) + 1, dtype=bool)
    alive[made.walls[0]] = False
    left = made.intact(alive)
    owners = made.walled[made.walls == made.walls[0]]
    assert left.item_count == made.item_count - len(owners)
    assert replace(made, name="other").item_count == made.item_count
