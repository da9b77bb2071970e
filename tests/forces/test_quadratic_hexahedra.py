"""Hexahedra with 27 nodes: bending, torsion, nearly incompressible, faces and stable steps."""

from itertools import product

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from tests.derivatives import agree, forces
from tests.forces.test_bending_cells import YOUNG, bar, made_of
from tissuec.forces.enclosed.pressed_faces import FORMS
from tissuec.forces.solids.quadratic import linear_functions
from tissuec.geometry.elements import CUBE_27, SHAPES, triquadratic
from tissuec.meshes.elements import MIRRORED, mesh_of_elements
from tissuec.meshes.generators import ElementMesh
from tissuec.meshes.quadratic import QUADRATIC, with_middles
from tissuec.validate.forces.elements import ElementSolid

SHAPE = SHAPES[QUADRATIC]


def quadratic_bar(counts, sides, poisson, at=lambda places: places, law=None):
    """Return a bar of elements with 27 nodes, and where its nodes are; see ``bar``.

    Args:
        at: Moves nodes of the box.
    """
    hexahedra, places = bar(counts, sides, poisson)
    cells = mesh_of_elements(places, [ElementMesh("hexahedron", hexahedra.nodes)], {})
    mesh = with_middles(cells)
    places = at(mesh.position)
    return made_of(QUADRATIC, places, mesh.elements[0].nodes, poisson, law), places


def settled(elements, start, held, load=0.0, most=30):
    """Return where nodes come to rest by Newton's method, some of them held.

    Args:
        start: Where they begin [m], shape (node, 3).
        held: Which components stay, of the same shape.
        load: Forces [N], of the same shape.
    """
    free, count, x = np.flatnonzero(~held.ravel()), len(start), start.copy()
    scale = None
    for _ in range(most):
        left = (forces(elements, x) + load).ravel()[free]
        stiff = elements.matrix(0.0, x, np.arange(count), count)[free][:, free]
        step = spsolve(stiff.tocsc(), left)
        x.ravel()[free] += step
        scale = scale or np.abs(step).max()
        if np.abs(step).max() < 1e-9 * np.ptp(start):
            return x
    raise AssertionError("Newton's method does not converge")


# --- the volume -------------------------------------------------------------------------------


def distorted(seed=1, size=0.15):
    """Return the nodes of an element with curved sides, shape (27, 3)."""
    return CUBE_27 + size * np.random.default_rng(seed).uniform(-1.0, 1.0, CUBE_27.shape)


def test_functions_are_orthogonal_and_linear():
    weight = SHAPE.point_volumes(distorted()[None])
    found = linear_functions(SHAPE, weight)[0]
    volume = weight.sum()
    inner = np.einsum("q,qk,ql->kl", weight[0], found, found)
    np.testing.assert_allclose(inner, volume * np.eye(4), atol=1e-13 * volume)
    np.testing.assert_allclose(found[:, 0], 1.0, rtol=1e-13)
    places = SHAPE.lumped @ CUBE_27
    basis = np.column_stack([np.ones(27), places])
    fitted = basis @ np.linalg.lstsq(basis, found, rcond=None)[0]
    np.testing.assert_allclose(fitted, found, atol=1e-12)


def test_shape_functions_are_those_of_their_nodes():
    values, _ = triquadratic(CUBE_27)
    np.testing.assert_array_equal(values, np.eye(27))
    # A biquadratic function of all three coordinates is represented exactly.
    places = np.random.default_rng(2).uniform(-1.0, 1.0, (5, 3))
    values, slopes = triquadratic(places)

    def function(p):
        x, y, z = p.T
        return (1.0 + 2.0 * x - x * x) * (3.0 - y + 0.5 * y * y) * (0.5 + z - 2.0 * z * z)

    np.testing.assert_allclose(values @ function(CUBE_27), function(places), rtol=1e-13)
    moved = [function(places + 1e-20j * axis).imag / 1e-20 for axis in np.eye(3)]
    found = np.einsum("qak,a->kq", slopes, function(CUBE_27))
    np.testing.assert_allclose(found, moved, rtol=1e-12)


def test_a_linear_pressure_is_free_of_the_mesh():
    """J is linear in the height, as in a fluid under its own weight."""
    elements, places = quadratic_bar((1, 1, 1), (1.0, 1.0, 1.0), 0.4999)
    small = 1e-6
    moved = places.copy()
    moved[:, 2] += 0.5 * small * places[:, 2] ** 2  # J = 1 + small z
    bulk = YOUNG / 3.0 / (1.0 - 2.0 * 0.4999)
    found = elements.energy(0.0, moved)
    # ∫ K/2 (small z)² + 2/3 μ (small z)² + O(small³)
    shear = YOUNG / 2.0 / 1.4999
    due = (bulk / 2.0 + 2.0 / 3.0 * shear) * small**2 / 3.0
    assert found == pytest.approx(due, rel=1e-5)


def test_the_reference_agrees_where_it_is_nearly_incompressible():
    elements, places = quadratic_bar((2, 1, 1), (2.0, 1.0, 1.0), 0.4999)
    random = np.random.default_rng(3)
    position = places + 0.02 * random.uniform(-1.0, 1.0, places.shape)
    reference = ElementSolid(elements, places)
    tight = {"force": 1e-11, "matrix": 1e-11, "energy": 1e-11, "lost": 1e-12}
    agree(elements, reference, position, np.zeros_like(places), **tight)


# --- bodies -----------------------------------------------------------------------------------


def cook(count, poisson):
    """Return how far the upper corner of Cook's membrane rises [m], in plane strain.

    With a shear modulus of 80.1938 Pa, of 1 m thickness, under 100 N at its end.
    """

    def at(places):
        part, across = places[:, 0] / 48.0, places[:, 1]
        high = 44.0 * part + across * (44.0 - 28.0 * part)
        return np.column_stack([places[:, 0], high, places[:, 2]])

    elements, places = quadratic_bar((count, count, 1), (48.0, 1.0, 1.0), poisson, at)
    unit = YOUNG / 2.0 / (1.0 + poisson) / 80.1938  # of force
    held = np.zeros(places.shape, dtype=bool)
    held[places[:, 0] < 1e-9] = True
    held[:, 2] = True
    load = np.zeros_like(places)
    along, over = np.linspace(44.0, 60.0, 2 * count + 1), np.linspace(0.0, 1.0, 3)
    simpson = np.full(len(along), 2.0)
    simpson[1::2], simpson[[0, -1]] = 4.0, 1.0
    for (y, one), (z, other) in product(
        zip(along, simpson / simpson.sum(), strict=True),
        zip(over, np.array([1.0, 4.0, 1.0]) / 6.0, strict=True),
    ):
        (node,) = np.flatnonzero(np.linalg.norm(places - (48.0, y, z), axis=1) < 1e-6)
        load[node, 1] = 100.0 * unit * one * other
    x = places
    for part in (0.25, 0.5, 0.75, 1.0):
        x = settled(elements, x, held, part * load)
    top = np.argmax(places[:, 1])
    return x[top, 1] - places[top, 1]


@pytest.mark.parametrize(
    ("poisson", "count", "due", "within"),
    # The references are the limits of finer meshes.
    [(0.3, 1, 8.77, 0.017), (0.3, 2, 8.77, 0.005), (0.3, 4, 8.77, 0.005),
     (0.4999, 1, 6.92, 0.015), (0.4999, 2, 6.92, 0.007), (0.4999, 4, 6.92, 0.007)],
)  # fmt: skip
def test_cooks_membrane(poisson, count, due, within):
    assert cook(count, poisson) == pytest.approx(due, rel=within)


def leaning(shape):
    """Return what moves the nodes of six boxes of a slender beam; inner planes lean by 45°."""

    def at(places):
        along, high = places[:, 0], places[:, 2] - 0.1
        turn = {
            "boxes": 0.0, "parallelograms": 1.0, "trapezoids": np.cos(np.pi * along)
        }[shape]  # fmt: skip
        is_inner = (along > 1e-9) & (along < 6.0 - 1e-9)
        return places + np.outer(turn * high * is_inner, [1.0, 0.0, 0.0])

    return at


@pytest.mark.parametrize("shape", ["boxes", "parallelograms", "trapezoids"])
def test_a_slender_beam_bends_whatever_the_shape_of_its_elements(shape):
    """(R. H. MacNeal, R. L. Harder, Finite Elem. Anal. Des. 1:3, 1985: 6 x 0.2 x 0.1.)"""
    straight, places = bar((6, 1, 1), (6.0, 0.1, 0.2), 0.3)
    cells = [ElementMesh("hexahedron", straight.nodes)]
    mesh = with_middles(mesh_of_elements(leaning(shape)(places), cells, {}))
    places = mesh.position
    elements = made_of(QUADRATIC, places, mesh.elements[0].nodes, 0.3)
    count = len(places)
    stiff = elements.matrix(0.0, places, np.arange(count), count).tocsc()
    free = np.flatnonzero(np.repeat(places[:, 0] > 1e-9, 3))
    tip = np.isclose(places[:, 0], 6.0)
    middle = np.abs(places[tip, 1:] - (0.05, 0.1)) < 1e-9
    share = np.where(middle, 4.0, 1.0).prod(axis=1) / 36.0
    load = np.zeros_like(places)
    load[tip, 2] = share
    moved = np.zeros(3 * count)
    moved[free] = spsolve(stiff[free][:, free], load.ravel()[free])
    found = moved.reshape(-1, 3)[tip, 2] @ share
    second = 0.1 * 0.2**3 / 12.0
    due = 6.0**3 / (3.0 * YOUNG * second) + 6.0 / (5.0 / 6.0 * 0.02 * YOUNG / 2.6)
    assert found == pytest.approx(due, rel=0.015)


def test_a_bar_twisted_by_a_right_angle():
    """A bar of 60 x 10 x 10 whose ends are held, with two elements across.

    The torque is that of elements of order 5, which agrees with Richardson's extrapolation.
    """
    elements, places = quadratic_bar((6, 2, 2), (60.0, 10.0, 10.0), 0.3)
    held = np.zeros(places.shape, dtype=bool)
    base, tip = np.isclose(places[:, 0], 0.0), np.isclose(places[:, 0], 60.0)
    held[base | tip] = True
    x, middle = places.copy(), np.array([60.0, 5.0, 5.0])
    for turned in np.radians([30.0, 60.0, 90.0]):
        cos, sin = np.cos(turned), np.sin(turned)
        turn = np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])
        x[tip] = middle + (places[tip] - middle) @ turn.T
        x = settled(elements, x, held)
    push = -forces(elements, x)[tip]
    torque = np.cross(x[tip] - middle, push)[:, 0].sum()
    # In units of YOUNG and of the size of the bar: 142.56 mN mm at 10 kPa and in mm.
    assert torque == pytest.approx(142.56e-6 * (YOUNG / 10e3) * 1e9, rel=0.02)


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
def test_the_stable_step_is_that_of_as_many_nodes(poisson):
    """With the same spacing of nodes, steps are 0.77 times those of eight nodes or more.

    Masses are 1, 4, 16 and 64 parts of 216 of an element.
    """
    largest = []
    for make, count in ((bar, 4), (quadratic_bar, 2)):
        elements, places = make((count,) * 3, (1.0, 1.0, 1.0), poisson)
        share = elements.shares.sum(axis=1)
        mass = np.bincount(elements.nodes.ravel(), share.ravel(), len(places))
        assert (mass > 0.0).all() and mass.sum() == pytest.approx(1.0, rel=1e-12)
        stiff = elements.matrix(0.0, places, np.arange(len(places)), len(places)).toarray()
        root = np.repeat(mass, 3) ** -0.5
        largest.append(np.linalg.eigvalsh(root[:, None] * stiff * root)[-1])
    assert 0.77 < np.sqrt(largest[0] / largest[1]) < 0.81


# --- faces ------------------------------------------------------------------------------------


def test_weighted_triangles_enclose_the_volume_of_curved_sides():
    form, weight = FORMS[8]
    enclosed, corners = 0.0, distorted()
    for face in range(6):
        local = SHAPE.triangles[SHAPE.faces == face]
        ring = corners[[*local[:, 1], local[0, 0]]]
        enclosed += (weight * np.linalg.det(ring[form])).sum() / 6.0
    assert enclosed == pytest.approx(SHAPE.volumes(corners[None])[0], rel=1e-13)


def test_mirror_images_have_the_same_triangles():
    order = MIRRORED[QUADRATIC]
    own = {frozenset(each) for each in SHAPE.triangles.tolist()}
    turned = {frozenset(order[node] for node in each) for each in SHAPE.triangles.tolist()}
    assert own == turned
    assert SHAPE.volumes(CUBE_27[order][None])[0] == pytest.approx(-8.0, rel=1e-14)


def test_middles_join_groups_and_keep_the_numbers_of_corners():
    hexahedra, places = bar((2, 1, 1), (2.0, 1.0, 1.0), 0.3)
    groups = {"end": np.flatnonzero(places[:, 0] > 1.9), "edge": np.array([0, 1])}
    mesh = with_middles(
        mesh_of_elements(places, [ElementMesh("hexahedron", hexahedra.nodes)], groups)
    )
    np.testing.assert_array_equal(mesh.position[: len(places)], places)
    assert len(mesh.position) == 5 * 3 * 3
    assert (mesh.position[mesh.groups["end"], 0] > 1.9).all() and len(mesh.groups["end"]) == 9
    assert len(mesh.groups["edge"]) == 3
    assert len(mesh.skin) == 10 * 8
    assert mesh.volume.sum() == pytest.approx(2.0, rel=1e-14)
