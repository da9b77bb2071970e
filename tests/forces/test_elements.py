"""Solid elements against energies, closed forms, and formulas of the reference."""

import numpy as np
import pytest

from tests.derivatives import agree, follow_from_the_energy, forces
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.forces.solids.solid_strain import SolidFibres
from tissuec.geometry.elements import MIDDLES, SHAPES, Measures
from tissuec.laws.solid.invariants import (
    MooneyRivlin,
    NeoHookean,
    SolidExponential,
    VerondaWestmann,
    Yeoh,
)
from tissuec.laws.solid.stretches import Hencky, Ogden
from tissuec.meshes.elements import MIRRORED, mesh_of_elements, node_shares
from tissuec.meshes.generators import ElementMesh
from tissuec.meshes.quadratic import QUADRATIC, with_middles
from tissuec.validate.forces.elements import ElementSolid

LAWS = (NeoHookean(), MooneyRivlin(0.3), Yeoh(0.6, 1.8), SolidExponential(0.4),
        VerondaWestmann(0.3), Hencky(), Ogden(5.3, -3.1, 0.4, 1.7, 0.2))  # fmt: skip
SPAN = Span(Source("scene", ""), 0, 0)
SHEAR, BULK = 2e3, 3e4  # [Pa]
_SIX = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6],
                 [0, 5, 1, 6]])  # fmt: skip
_TWO = np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]])


def mesh(name, cells=2, displaced=0.15, seed=3):
    """Return places and nodes of elements in a cube of 20 mm with displaced inner nodes."""
    count = cells + 1
    number = np.arange(count**3).reshape(count, count, count)
    steps = np.linspace(0.0, 0.02, count)
    position = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
               (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]  # fmt: skip
    hexes = np.stack(
        [number[i:cells + i, j:cells + j, k:cells + k].ravel() for i, j, k in corners], axis=1
    )  # fmt: skip
    inner = ((position > 1e-9) & (position < 0.02 - 1e-9)).all(axis=1)
    moved = np.random.default_rng(seed).uniform(-1.0, 1.0, position.shape)
    position = position + displaced * 0.02 / cells * moved * inner[:, None]
    if name == "hexahedron":
        return position, hexes
    if name == "wedge":
        return position, hexes[:, _TWO].reshape(-1, 6)
    if name == "quadratic hexahedron":
        every = with_middles(mesh_of_elements(position, [ElementMesh("hexahedron", hexes)], {}))
        return every.position, every.elements[0].nodes
    tets = hexes[:, _SIX].reshape(-1, 4)
    edges, place = np.unique(
        np.sort(tets[:, MIDDLES].reshape(-1, 2), axis=1), axis=0, return_inverse=True
    )
    middles = len(position) + place.reshape(-1, 6)
    return np.concatenate([position, position[edges].mean(axis=1)]), np.hstack([tets, middles])


def with_flat_sides(position):
    """Return places of wedges of ``mesh`` whose sides are not twisted, in uneven layers.

    Twisted sides leave forces of uniform strain; see ``test_bending_wedges``.
    """
    count = round(len(position) ** (1.0 / 3.0))
    grid = position.reshape(count, count, count, 3).copy()
    grid[..., :2] = grid[:, :, 1:2, :2]
    return grid.reshape(-1, 3)


def fibres_of(count, seed=4):
    """Return two families of fibres in directions of each element's own."""
    random = np.random.default_rng(seed)
    along = random.normal(size=(count, 2, 3))
    along /= np.linalg.norm(along, axis=2)[..., None]
    numbers = random.uniform((1e3, 0.2, 0.0), (4e3, 0.6, 0.3), (count, 3))
    return SolidFibres(along, *np.ascontiguousarray(numbers.T))


def solid(name, law, *, viscosity=0.0, has_fibres=False, **more):
    """Return elements of two materials, and where their nodes are drawn."""
    position, nodes = mesh(name, **more)
    count = len(nodes)
    part = 1.0 + (np.arange(count) % 2)
    material = SolidMaterial(
        SHEAR * part, BULK * part, viscosity * part, np.zeros(count, dtype=np.int64), (law,),
        fibres_of(count) if has_fibres else None,
    )  # fmt: skip
    made = kind_of(SHAPES[name]).of("liver", SHAPES[name], nodes, position, material, 0, SPAN)
    return made, position


def deformed(position, size, seed=5):
    """Return places of a strained state, with parts that no element can follow."""
    random = np.random.default_rng(seed)
    turn = np.array([[1.2, 0.3, -0.1], [-0.2, 0.9, 0.2], [0.1, 0.1, 1.05]])
    return position @ turn.T + size * random.uniform(-1.0, 1.0, position.shape)


def test_the_volume_is_that_between_the_faces():
    """A cube whose sides become 1 + a z times as wide has the volume 1 + a + a²/3."""
    made, cube = solid("hexahedron", NeoHookean(), cells=1, displaced=0.0)
    wide = cube * (1.0 + 40.0 * cube[:, 2:] * np.array([1.0, 1.0, 0.0]))
    due = 8e-6 * (1.0 + 0.8 + 0.8**2 / 3.0)
    assert made.whole_volume(wide) == pytest.approx(due, rel=1e-14)


CASES = [(name, law, False) for name in SHAPES for law in LAWS]
CASES += [(name, LAWS[1], True) for name in SHAPES]
NAMES = [f"{n}, {type(law).__name__}{', fibres' if fibred else ''}" for n, law, fibred in CASES]


@pytest.mark.parametrize(("name", "law", "fibred"), CASES, ids=NAMES)
@pytest.mark.parametrize("size", [5e-4, 6e-3], ids=["strained", "inside out"])
def test_forces_and_matrices_follow_from_the_energy(name, law, fibred, size):
    made, drawn = solid(name, law, cells=1, has_fibres=fibred)
    # The exponential of fibres leaves the range of numbers in what is far inside out; stretches
    # are then less than 1/30, where laws of stretches are not exact.
    largest = 2e-3 if fibred else 4e-3 if isinstance(law, Hencky | Ogden) else size
    position = deformed(drawn, min(size, largest))
    assert abs(made.energy(0.0, drawn)) < 1e-12 * made.spread(0.0, drawn)
    follow_from_the_energy(made, position, every=7, force=2e-6, matrix=3e-6, rounding=1e-14)


@pytest.mark.parametrize(("name", "law", "fibred"), CASES, ids=NAMES)
def test_the_reference_agrees_by_formulas_of_its_own(name, law, fibred):
    made, drawn = solid(name, law, viscosity=1.5, has_fibres=fibred)
    reference = ElementSolid(made, drawn)
    for size in (5e-4, 1.5e-3):
        position = deformed(drawn, size)
        velocity = np.random.default_rng(2).normal(size=position.shape)
        tight = {"force": 1e-11, "matrix": 1e-11, "energy": 1e-11, "lost": 1e-12}
        agree(made, reference, position, velocity, **tight)


@pytest.mark.parametrize("name", SHAPES)
def test_the_matrix_of_free_nodes_is_a_part_of_that_of_all(name):
    made, drawn = solid(name, NeoHookean())
    count, random = len(drawn), np.random.default_rng(6)
    every = made.matrix(0.0, deformed(drawn, 5e-4), np.arange(count), count)
    for is_free in (random.random(count) < 0.7, random.random(count) < 0.1):
        free = random.permutation(np.flatnonzero(is_free))
        number = np.full(count, -1)
        number[free] = np.arange(len(free))
        for size in (5e-4, 1e-3, 5e-4):  # again at other places
            position = deformed(drawn, size)
            found = made.matrix(0.0, position, number, len(free))
        assert found.has_canonical_format
        rows = (3 * free[:, None] + np.arange(3)).ravel()
        # The same elements add up, in the same order.
        assert (found.toarray() == every[rows][:, rows].toarray()).all()


@pytest.mark.parametrize("name", SHAPES)
def test_elements_at_free_nodes_keep_their_laws_where_all_of_another_law_are_held(name):
    made, drawn = solid(name, NeoHookean())
    below = (drawn[made.nodes, 2].mean(axis=1) < 0.01).astype(np.int64)
    made = replace(made, law=below, laws=(NeoHookean(), Yeoh(2.0, 1.0)))
    position, count = deformed(drawn, 5e-4), len(drawn)
    for is_free in (drawn[:, 2] > 0.0199, drawn[:, 2] < 1e-4):
        free = np.flatnonzero(is_free)
        number = np.full(count, -1)
        number[free] = np.arange(len(free))
        every = made.matrix(0.0, position, np.arange(count), count)
        rows = (3 * free[:, None] + np.arange(3)).ravel()
        found = made.matrix(0.0, position, number, len(free))
        # Formulas of one law and of two differ by rounding.
        due = every[rows][:, rows].toarray()
        assert np.abs(found.toarray() - due).max() < 1e-14 * np.abs(due).max()


@pytest.mark.parametrize("name", SHAPES)
def test_positive_matrices_of_far_swollen_elements_have_no_negative_eigenvalue(name):
    """The energy ln² J/2 of a volume is concave where J is more than e."""
    made, drawn = solid(name, NeoHookean(), cells=1)
    swollen = deformed(drawn, 5e-4) * 1.7
    rows = len(made.nodes), 3 * made.shape.nodes, -1
    exact, positive = (
        made.element_matrices(swollen, exact=each).reshape(rows) for each in (True, False)
    )
    size = np.abs(exact).max()
    assert np.linalg.eigvalsh(exact).min() < -1e-2 * size
    assert np.linalg.eigvalsh(positive).min() > -1e-13 * size


@pytest.mark.parametrize("law", LAWS[1:], ids=lambda law: type(law).__name__)
def test_at_rest_every_law_has_the_same_matrix(law):
    matrices = []
    for each in (LAWS[0], law):
        made, drawn = solid("hexahedron", each)
        numbers = np.arange(len(drawn))
        matrices.append(made.matrix(0.0, drawn, numbers, len(drawn)).toarray())
        assert np.abs(forces(made, drawn)).max() < 1e-12 * SHEAR * 0.02**2
    np.testing.assert_allclose(*matrices, atol=1e-12 * np.abs(matrices[0]).max())


@pytest.mark.parametrize("name", SHAPES)
def test_viscous_forces_are_those_of_their_matrix(name):
    made, drawn = solid(name, NeoHookean(), viscosity=1.5)
    position, count = deformed(drawn, 5e-4), len(drawn)
    velocity = np.random.default_rng(2).normal(size=position.shape)
    braking = forces(made, position, velocity) - forces(made, position)
    _, matrix = made.damping_matrices(position, velocity, np.arange(count), count)
    np.testing.assert_allclose(
        braking.ravel(), -matrix @ velocity.ravel(), atol=1e-12 * np.abs(braking).max()
    )
    power = velocity.ravel() @ (matrix @ velocity.ravel())
    assert made.powers(0.0, position, velocity)[1] == pytest.approx(power, rel=1e-12)
    # Nothing flows in a body that turns.
    turning = np.cross(np.array([3.0, 1.0, 2.0]), position)
    still = forces(made, position, turning) - forces(made, position)
    assert np.abs(still).max() < 1e-12 * np.abs(braking).max()


# --- patches --------------------------------------------------------------------------------

#: Stretches of unit volume: uniaxial, equibiaxial, planar, and a simple shear.
STRETCHES = {
    "uniaxial": np.diag([1.4, 1.4**-0.5, 1.4**-0.5]),
    "pressed": np.diag([0.7, 0.7**-0.5, 0.7**-0.5]),
    "equibiaxial": np.diag([1.2, 1.2, 1.2**-2]),
    "planar": np.diag([1.3, 1.0, 1.0 / 1.3]),
    "shear": np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}


def uniform(made, drawn, deformation):
    """Return σ = P Fᵀ / J of a uniform strain, from the forces on the boundary [Pa].

    Virtual work: Σ f ⊗ X over all nodes is -V P.
    """
    found = forces(made, drawn @ deformation.T)
    piola = -np.einsum("ax,ak->xk", found, drawn) / float(made.volume.sum())
    return found, piola @ deformation.T / np.linalg.det(deformation)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("way", STRETCHES)
def test_uniform_strain_is_in_equilibrium_in_any_mesh(name, way):
    position, nodes = mesh(name, cells=3, displaced=0.25)
    if name == "wedge":
        position = with_flat_sides(position)
    count = len(nodes)
    material = SolidMaterial(
        np.full(count, SHEAR), np.full(count, BULK), np.zeros(count),
        np.zeros(count, dtype=np.int64), (Yeoh(0.6, 1.8),),
    )  # fmt: skip
    made = kind_of(SHAPES[name]).of("cube", SHAPES[name], nodes, position, material, 0, SPAN)
    found, _ = uniform(made, position, 1.1 * STRETCHES[way])
    inner = ((position > 1e-9) & (position < 0.02 - 1e-9)).all(axis=1)
    # The forces on a node are sums of as many terms of the size of the largest one.
    assert np.abs(found[inner]).max() < 1e-12 * np.abs(found).max() * np.sqrt(count)


def tension(law, stretch):
    """Return λ ∂W/∂λ over the shear modulus, by stretches."""
    if isinstance(law, Hencky):
        return 2.0 * np.log(stretch)
    terms = (
        (1.0 - law.second_share - law.third_share, law.exponent),
        (law.second_share, law.second_exponent),
        (law.third_share, law.third_exponent),
    )
    return sum(2.0 * share / a * stretch**a for share, a in terms)


def principal(law, b):
    """Return σ but for a pressure of a solid without change of volume, from B = F Fᵀ [Pa].

    σ = 2 μ (ψ1 B - ψ2 B⁻¹) (A. E. Green, W. Zerna, Theoretical Elasticity, 1968).
    """
    inverse = np.linalg.inv(b)
    i1, i2 = np.trace(b), np.trace(inverse)
    match law:
        case NeoHookean():
            first, second = 0.5, 0.0
        case MooneyRivlin(share=s):
            first, second = 0.5 * (1.0 - s), 0.5 * s
        case Yeoh(second=c, third=d):
            first, second = 0.5 + c * (i1 - 3.0) + 1.5 * d * (i1 - 3.0) ** 2, 0.0
        case SolidExponential(stiffening=k):
            first, second = 0.5 * np.exp(k * (i1 - 3.0)), 0.0
        case VerondaWestmann(stiffening=k):
            first, second = np.exp(k * (i1 - 3.0)), -0.5
        case Hencky() | Ogden():  # σ = λ ∂W/∂λ along each axis
            square, axes = np.linalg.eigh(b)
            return SHEAR * (axes * tension(law, np.sqrt(square))) @ axes.T
    assert i2 >= 3.0 - 1e-12
    return 2.0 * SHEAR * (first * b - second * inverse)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("way", STRETCHES)
@pytest.mark.parametrize(("name", "cells"), [("hexahedron", 1), ("hexahedron", 10),
                                             ("tetrahedron", 3), ("wedge", 4)])  # fmt: skip
def test_each_law_gives_its_stress_in_any_mode(name, cells, way, law):
    position, nodes = mesh(name, cells=cells, displaced=0.2)
    count = len(nodes)
    material = SolidMaterial(
        np.full(count, SHEAR), np.full(count, 1e3 * SHEAR), np.zeros(count),
        np.zeros(count, dtype=np.int64), (law,),
    )  # fmt: skip
    made = kind_of(SHAPES[name]).of("cube", SHAPES[name], nodes, position, material, 0, SPAN)
    f = STRETCHES[way]
    _, stress = uniform(made, position, f)
    expected = principal(law, f @ f.T)
    for one in (stress, expected):
        one -= np.trace(one) / 3.0 * np.eye(3)
    # Rounding of volumes by 1e-16 costs K 1e-16.
    np.testing.assert_allclose(stress, expected, atol=1e-9 * SHEAR)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("name", SHAPES)
def test_stress_at_nodes_is_that_of_the_forces(name, law):
    made, drawn = solid(name, law, displaced=0.1)
    even = replace(made, shear=made.shear.mean() + 0.0 * made.shear,
                   bulk=made.bulk.mean() + 0.0 * made.bulk,
                   local=made.local.mean() + 0.0 * made.local)  # fmt: skip
    turn = 1.05 * STRETCHES["planar"] @ STRETCHES["shear"]
    _, stress = uniform(even, drawn, turn)
    total, volume = even.node_stress(drawn @ turn.T)
    np.testing.assert_allclose(
        total / volume[:, None, None], np.tile(stress, (len(drawn), 1, 1)),
        atol=1e-11 * np.abs(stress).max(),
    )  # fmt: skip
    assert volume.sum() == pytest.approx(0.02**3, rel=1e-13)


@pytest.mark.parametrize("dispersion", [0.0, 0.2])
@pytest.mark.parametrize("name", SHAPES)
def test_fibres_add_four_times_k1_along_them(name, dispersion):
    position, nodes = mesh(name)
    count, along, part = len(nodes), np.array([0.6, 0.0, 0.8]), 1e-6
    fibres = SolidFibres(np.tile(along, (count, 1, 1)), np.full(count, 7e3),
                         np.full(count, 3.0), np.full(count, dispersion))  # fmt: skip
    modulus = 4.0 * 7e3 * (1.0 - 3.0 * dispersion) ** 2
    np.testing.assert_allclose(fibres.modulus, modulus, rtol=1e-14)
    law = np.zeros(count, dtype=np.int64)
    bare, fibred = (
        kind_of(SHAPES[name]).of("muscle", SHAPES[name], nodes, position,
            SolidMaterial(np.full(count, SHEAR), np.full(count, BULK), np.zeros(count), law,
                          (NeoHookean(),), each), 0, SPAN,
        )
        for each in (None, fibres)
    )  # fmt: skip
    np.testing.assert_allclose(
        fibred.rigidity, (SHEAR + BULK + modulus) * fibred.volume, rtol=1e-14
    )
    longer = np.eye(3) + part * np.outer(along, along)
    more = uniform(fibred, position, longer)[1] - uniform(bare, position, longer)[1]
    np.testing.assert_allclose(
        more, modulus * part * np.outer(along, along), atol=1e-4 * 7e3 * part
    )
    # Fibres that are pressed do nothing. Cells that bend have a single point without any, not
    # eight or six, whose sums are rounded.
    shorter = np.eye(3) - part * np.outer(along, along)
    whole = uniform(bare, position, shorter)[1]
    left = uniform(fibred, position, shorter)[1] - whole
    assert np.abs(left).max() <= (1e-13 * SHEAR if SHAPES[name].bends else 0.0)


@pytest.mark.parametrize("name", SHAPES)
def test_pressure_follows_from_the_bulk_modulus(name):
    made, drawn = solid(name, NeoHookean(), displaced=0.0)
    _, stress = uniform(made, drawn, 1.02 * np.eye(3))
    mean = 1.5 * BULK * np.log(1.02**3) / 1.02**3  # half of the elements have K, half have 2 K
    np.testing.assert_allclose(stress, mean * np.eye(3), rtol=1e-12, atol=1e-9 * mean)


# --- shapes ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SHAPES)
def test_volumes_and_masses_add_up(name):
    position, nodes = mesh(name, cells=3, displaced=0.25)
    measured = Measures.of(SHAPES[name], position[nodes])
    assert measured.volume.sum() == pytest.approx(0.02**3, rel=1e-14)
    np.testing.assert_allclose(SHAPES[name].lumped.sum(axis=1), 1.0, rtol=1e-15)
    # Points of hexahedra with 27 nodes have negative parts in some, their elements have none.
    lumped = SHAPES[name].weights @ SHAPES[name].lumped
    assert (lumped > 0.0).all()
    assert (node_shares(SHAPES[name], position[nodes]) > 0.0).all()
    if name == "quadratic hexahedron":
        kinds = [1] * 8 + [4] * 12 + [16] * 6 + [64]
        np.testing.assert_allclose(lumped, 8.0 / 216.0 * np.array(kinds), rtol=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_enclose_the_volume(name):
    position, nodes = mesh(name, cells=1, displaced=0.0)
    # Of faces through the origin, the pyramids have no volume.
    position = position + np.array([0.03, 0.05, 0.07])
    a, b, c = np.moveaxis(position[nodes[:, SHAPES[name].triangles]], 2, 0)
    enclosed = np.einsum("etk,etk->e", a, np.cross(b, c)) / 6.0
    volume = Measures.of(SHAPES[name], position[nodes]).volume.sum(axis=1)
    np.testing.assert_allclose(enclosed, volume, rtol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_of_a_face_lie_side_by_side(name):
    position, nodes = mesh(name, cells=1, displaced=0.0)
    a, b, c = np.moveaxis(position[nodes[0, SHAPES[name].triangles]], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    same = SHAPES[name].faces[:, None] == SHAPES[name].faces
    np.testing.assert_array_equal(normal @ normal.T > 1.0 - 1e-9, same)


@pytest.mark.parametrize("name", SHAPES)
def test_edges_are_those_of_faces(name):
    shape = SHAPES[name]
    faces = {}
    for triangle, face in zip(shape.triangles.tolist(), shape.faces.tolist(), strict=True):
        for a, b in zip(triangle, triangle[1:] + triangle[:1], strict=True):
            faces.setdefault((min(a, b), max(a, b)), set()).add(face)
    # The diagonals of flat faces with four corners are no edges.
    due = {pair for pair, both in faces.items() if len(both) == 2 or name == "tetrahedron"}
    if name == "quadratic hexahedron":  # all pairs of neighbours, also inside
        places, (nodes,) = mesh(name, cells=1, displaced=0.0)
        apart = np.linalg.norm(places[nodes][:, None] - places[nodes], axis=2)
        near = np.argwhere(np.triu(np.abs(apart - 0.01) < 1e-9))
        assert len(due) == 24
        due = {(int(a), int(b)) for a, b in near}
    assert {tuple(sorted(pair)) for pair in shape.edges.tolist()} == due
    assert len(shape.edges) == len(due)


@pytest.mark.parametrize("name", SHAPES)
def test_elements_that_are_inside_out_are_refused(name):
    position, nodes = mesh(name, cells=1)
    turned = nodes.copy()
    # Corners 0 and 1 change places, and of a tetrahedron what lies between them and the others.
    swapped = [0, 1, 5, 6, 7, 8] if name == "tetrahedron" else [0, 1]
    turned[0, swapped] = turned[0, [swapped[k ^ 1] for k in range(len(swapped))]]
    if name == "quadratic hexahedron":
        turned[0] = nodes[0, MIRRORED[QUADRATIC]]
    material = SolidMaterial(*np.full((3, len(nodes)), 1e3), np.zeros(len(nodes), int),
                             (NeoHookean(),))  # fmt: skip
    with pytest.raises(ValueError, match=f"{name} 0 is flat or inside out"):
        kind_of(SHAPES[name]).of("cube", SHAPES[name], turned, position, material, 0, SPAN)


@pytest.mark.parametrize("name", SHAPES)
def test_a_cut_edge_takes_its_elements(name):
    made, _ = solid(name, NeoHookean())
    alive = np.ones(made.walls.max() + 1, dtype=bool)
    alive[made.walls[5]] = False
    gone = np.unique(made.walled[made.walls == made.walls[5]])
    np.testing.assert_array_equal(made.lost_items(alive), gone)
    assert made.intact(alive).item_count == made.item_count - len(gone)


@pytest.mark.parametrize("name", SHAPES)
def test_what_is_turned_inside_out_pushes_back(name):
    made, drawn = solid(name, NeoHookean(), displaced=0.0)
    centre = drawn.mean(axis=0)
    last = None
    for part in (0.5, 0.2, 0.05, -0.2, -0.8):
        pressed = np.where(np.arange(3) == 2, centre + part * (drawn - centre), drawn)
        upper = np.abs(drawn[:, 2] - 0.02) < 1e-9
        push = float(forces(made, pressed)[upper, 2].sum())
        assert push > 0.0
        assert last is None or push > last
        last = push


@pytest.mark.parametrize("name", SHAPES)
def test_items_are_the_nodes_of_each_element(name):
    made, drawn = solid(name, NeoHookean())
    place = np.random.default_rng(6).permutation(len(drawn))
    node, start = made.items(place)
    assert start[0] == 0
    assert start[-1] == len(node)
    for k, nodes in enumerate(made.nodes):
        np.testing.assert_array_equal(node[start[k] : start[k + 1]], place[nodes])


@pytest.mark.parametrize("has_fibres", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_the_estimate_of_the_largest_frequency_is_near_it(name, has_fibres):
    made, drawn = solid(name, NeoHookean(), has_fibres=has_fibres)
    count = len(drawn)
    mass = np.bincount(made.nodes.ravel(), 1e3 * made.shares.sum(axis=1).ravel(), count)
    stiff = made.matrix(0.0, drawn, np.arange(count), count).toarray()
    root = np.repeat(mass, 3) ** -0.5
    largest = np.sqrt(np.linalg.eigvalsh(root[:, None] * stiff * root)[-1])
    assert 0.9 * largest < made.fastest(mass) < 1.5 * largest


@pytest.mark.parametrize("cells", [2, 4])
@pytest.mark.parametrize("name", SHAPES)
def test_the_estimate_of_the_largest_stiffness_is_near_it(name, cells):
    made, drawn = solid(name, NeoHookean(), cells=cells)
    count = 3 * made.nodes.shape[1]
    stiff = made.element_matrices(drawn, exact=True).reshape(-1, count, count)
    largest = np.linalg.eigvalsh(stiff).max()
    assert 0.25 * largest < made.stiffest < largest
