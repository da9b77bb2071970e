"""Elements of laws of shape and volume together, against published stresses."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.derivatives import agree, follow_from_the_energy, forces
from tests.forces import test_elements as solids
from tests.forces import test_membranes as walls
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.laws.solid.whole import HolmesMow, SaintVenantKirchhoff, UnconstrainedOgden
from tissuec.validate.forces.elements import ElementSolid
from tissuec.validate.forces.membranes import MembraneWall

LAWS = (SaintVenantKirchhoff(), HolmesMow(0.6), UnconstrainedOgden(5.3, -3.1, 0.4, 1.7, 0.2))
SHEAR, RATIO = 2e3, 0.3  # [Pa]
LAME = 2.0 * SHEAR * RATIO / (1.0 - 2.0 * RATIO)
BULK = LAME + 2.0 / 3.0 * SHEAR
TURN = np.array([[1.25, 0.3, -0.1], [-0.2, 0.9, 0.2], [0.1, 0.1, 1.1]])
DEFORMATIONS = {
    "uniaxial": np.diag([1.4, 0.9, 0.9]),
    "pressed": np.diag([0.7, 1.1, 1.1]),
    "biaxial": np.diag([1.3, 1.2, 0.8]),
    "simple shear": np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "any": TURN,
}
each_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)


def cauchy(law, f, lame=LAME):
    """Return the stress as it is published for each law [Pa], shape (3, 3)."""
    b, j, one = f @ f.T, np.linalg.det(f), np.eye(3)
    i1 = np.trace(b)
    i2 = 0.5 * (i1**2 - np.trace(b @ b))
    match law:
        case SaintVenantKirchhoff():
            e = 0.5 * (f.T @ f - one)
            second = lame * np.trace(e) * one + 2.0 * SHEAR * e
            return f @ second @ f.T / j
        case HolmesMow(exponent=beta):
            modulus = lame + 2.0 * SHEAR
            q = beta / modulus * ((2.0 * SHEAR - lame) * (i1 - 3.0) + lame * (i2 - 3.0))
            part = (2.0 * SHEAR + lame * (i1 - 1.0)) * b - lame * b @ b - modulus * one
            return 0.5 / j * np.exp(q) / j ** (2.0 * beta) * part
        case UnconstrainedOgden():
            square, axes = np.linalg.eigh(b)
            stretch, found = np.sqrt(square), np.full(3, lame * (j - 1.0))
            for share, m in law.terms:
                found = found + 2.0 * SHEAR * share / m * (stretch**m - 1.0) / j
            return (axes * found) @ axes.T
    raise TypeError(law)


def solid(name, law, bulk=BULK):
    position, nodes = solids.mesh(name, displaced=0.2)
    if name == "wedge":
        position = solids.with_flat_sides(position)
    count = len(nodes)
    material = SolidMaterial(
        np.full(count, SHEAR), np.full(count, bulk), np.zeros(count),
        np.zeros(count, dtype=np.int64), (law,),
    )  # fmt: skip
    given = "cube", SHAPES[name], nodes, position, material, 0, solids.SPAN
    return kind_of(SHAPES[name]).of(*given), position


@each_law
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("way", DEFORMATIONS)
def test_uniform_strain_has_the_published_stress(name, law, way):
    made, drawn = solid(name, law)
    f = DEFORMATIONS[way]
    _, stress = solids.uniform(made, drawn, f)
    expected = cauchy(law, f)
    np.testing.assert_allclose(stress, expected, atol=1e-11 * np.abs(expected).max())


@each_law
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("size", [5e-4, 3e-3], ids=["strained", "inside out"])
def test_forces_and_matrices_follow_from_the_energy(name, law, size):
    made, drawn = solids.solid(name, law, cells=1)
    position = solids.deformed(drawn, size)
    assert abs(made.energy(0.0, drawn)) < 1e-12 * made.spread(0.0, drawn)
    assert np.abs(forces(made, drawn)).max() < 1e-11 * SHEAR * 0.02**2
    follow_from_the_energy(made, position, every=7, force=2e-6, matrix=3e-6, rounding=1e-13)


@each_law
@pytest.mark.parametrize("name", SHAPES)
def test_the_reference_agrees_by_formulas_of_its_own(name, law):
    made, drawn = solids.solid(name, law, viscosity=1.5, has_fibres=True)
    reference = ElementSolid(made, drawn)
    for size in (5e-4, 1.5e-3):
        position = solids.deformed(drawn, size)
        velocity = np.random.default_rng(2).normal(size=position.shape)
        tight = {"force": 1e-11, "matrix": 1e-11, "energy": 1e-11, "lost": 1e-12}
        agree(made, reference, position, velocity, **tight)


@each_law
@pytest.mark.parametrize("name", SHAPES)
def test_at_rest_every_law_has_the_same_matrix(name, law):
    matrices = []
    for each in (NeoHookean(), law):
        made, drawn = solid(name, each)
        numbers = np.arange(len(drawn))
        matrices.append(made.matrix(0.0, drawn, numbers, len(drawn)).toarray())
    if name in ("tetrahedron", "quadratic hexahedron"):  # whole laws have no mean volume
        matrices = [matrix @ (drawn @ TURN.T).ravel() for matrix in matrices]
    np.testing.assert_allclose(*matrices, atol=1e-12 * np.abs(matrices[0]).max())


@each_law
@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("way", ["uniaxial", "pressed", "biaxial", "simple shear"])
def test_walls_have_the_published_stress(law, ratio, way):
    made, drawn = walls.wall(law, ratio=ratio, parts=False)
    plane = DEFORMATIONS[way][:2, :2]
    lame = 2.0 * SHEAR * ratio / (1.0 - 2.0 * ratio)

    def whole(thickness):
        f = np.eye(3)
        f[:2, :2], f[2, 2] = plane, thickness
        return cauchy(law, f, lame)

    thickness = brentq(lambda t: whole(t)[2, 2], 0.2, 1.6, xtol=1e-15, rtol=1e-15)
    np.testing.assert_allclose(
        made.thinner(drawn @ walls.PLANE.T @ plane.T @ walls.PLANE), thickness, rtol=1e-12
    )
    stress = made.stresses(drawn @ walls.PLANE.T @ plane.T @ walls.PLANE)
    turned = walls.PLANE @ stress[:, 0] @ walls.PLANE.T
    expected = whole(thickness)[:2, :2]
    np.testing.assert_allclose(
        turned, np.broadcast_to(expected, turned.shape), atol=1e-11 * np.abs(expected).max()
    )


@each_law
def test_the_reference_agrees_on_walls(law):
    fibres = walls.fibres_of(18)
    made, drawn = walls.wall(law, viscosity=1.5, fibres=fibres, prestress=0.05)
    reference = MembraneWall(made)
    random = np.random.default_rng(7)
    position = drawn @ TURN.T + 1e-3 * random.uniform(-1.0, 1.0, drawn.shape)
    velocity = random.normal(size=position.shape)
    agree(
        made, reference, position, velocity, force=1e-10, matrix=1e-9, energy=1e-10, lost=1e-10
    )
