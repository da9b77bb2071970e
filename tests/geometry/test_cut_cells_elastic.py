"""Elasticity of parts of cells: patch tests, rank, moments, masses and the stable step."""

import numpy as np
import pytest
from scipy.sparse import diags
from scipy.sparse.linalg import eigsh

from tests.every import every
from tests.geometry.cut_bodies import SHAPES, Body, assembled, blades, stiffness, surface_loads
from tests.geometry.test_cut_cells import curved
from tissuec.geometry.cut_cells.masses import MOST, node_volumes
from tissuec.geometry.cut_cells.quadrature import PartMoments, matched_points, points_of_degree
from tissuec.geometry.elements import SHAPES as ELEMENTS
from tissuec.geometry.elements import Measures
from tissuec.geometry.moments import moments
from tissuec.geometry.natural_coordinates import functions

LAME = 1.5  # with a shear modulus of 1: Poisson's ratio is 0.3
BODIES = {
    "hexahedra": lambda: Body.cube("hexahedron"),
    "distorted hexahedra": lambda: Body.cube("hexahedron", 3, displaced=0.2),
    "quadratic hexahedra": lambda: Body.cube("quadratic hexahedron", 2),
    "distorted quadratic hexahedra": lambda: Body.cube("quadratic hexahedron", 2, 0.2),
    "curved hexahedra": lambda: curved(2),
    "wedges": lambda: Body.cube("wedge", 3),
    "distorted wedges": lambda: Body.cube("wedge", 3, displaced=0.2),
    "tetrahedra": lambda: Body.random(2),
}


def residual(body, made):
    """Return the largest force at inner nodes over that at others, of uniform strains.

    Each connected piece has a displacement of its own, with tractions on its sides of cuts.
    """
    piece = body.connected
    slope = np.random.default_rng(0).normal(size=(piece.max() + 1, 3, 3))
    strain = 0.5 * (slope + slope.swapaxes(1, 2))
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
    stress = 2.0 * strain + LAME * trace * np.eye(3)
    moved = np.einsum("pxy,pay->pax", slope[piece], body.corners)
    force = np.zeros((len(body.position), 3))
    each = np.einsum("paxby,pby->pax", stiffness(body, LAME), moved)
    np.add.at(force, body.parts.nodes, each)
    for side in (0, 1):
        force -= surface_loads(body, made.cut, stress[piece], side)
    return np.abs(force[body.inner]).max() / np.abs(force[~body.inner]).max()


@pytest.mark.parametrize("kind", BODIES)
def test_uniform_strain_of_each_side_leaves_inner_nodes_at_rest(kind):
    body = BODIES[kind]()
    for normal, offset in blades(4, seed=21, least=0.0):
        after, made = body.cut(body.position @ normal - offset)
        assert residual(after, made) < 1e-12


@pytest.mark.parametrize("kind", ["hexahedra", "quadratic hexahedra", "wedges", "tetrahedra"])
@every("offset", [0.5, 0.5 + 1e-5, 0.75 - 1e-4, 0.3])
def test_so_do_blades_in_faces_and_next_to_them(offset, kind):
    body = BODIES[kind]()
    after, made = body.cut(body.position[:, 2] - offset)
    assert residual(after, made) < 1e-12


@pytest.mark.parametrize("shape", SHAPES)
def test_parts_resist_all_but_rigid_motions(shape):
    """Others than these are modes of strain."""
    body = Body.cube(shape, 2, displaced=0.2)
    for normal, offset in blades(12, seed=22):
        after, _ = body.cut(body.position @ normal - offset)
        size = 3 * after.parts.nodes.shape[1]
        values = np.linalg.eigvalsh(stiffness(after, LAME).reshape(-1, size, size))
        rigid = 6
        # Rounding beside the largest one is 1e-16 times the number of terms.
        assert np.abs(values[:, :rigid] / values[:, -1:]).max() < 1e-12
        large = after.parts.fractions > 1e-3
        assert (values[large, rigid] / values[large, -1]).min() > 1e-9


@pytest.mark.parametrize("shape", SHAPES)
def test_whole_cells_have_their_usual_points(shape):
    for displaced in (0.0, 0.2):
        body = Body.cube(shape, 2, displaced)
        usual, found = Measures.of(ELEMENTS[shape], body.corners), body.measures
        np.testing.assert_allclose(found.volume.sum(1), usual.volume.sum(1), rtol=1e-13)
        if displaced and shape != "tetrahedron":
            continue
        mean = usual.gradients.mean(axis=1, keepdims=True)
        factor = np.sqrt(0.75) if shape == "hexahedron" else 1.0
        due = mean + factor * (usual.gradients - mean)
        np.testing.assert_allclose(found.gradients, due, atol=1e-12)


def test_quadratic_fields_have_their_own_slopes_in_parts_of_hexahedra():
    """In parts of cubes with 27 nodes, for any polynomial of degree 2, by its derivative."""
    body = Body.cube("quadratic hexahedron", 2)
    after, _ = body.cut(body.position @ [0.5, 0.7, 0.2] - 0.6)
    points = matched_points(after.parts, after.moments)
    places = functions(after.parts.shape, points.reshape(-1, 3)).values
    places = places.reshape(*points.shape[:2], 27) @ after.corners
    half = np.random.default_rng(2).normal(size=(3, 3))
    values = np.einsum("pax,xy,pay->pa", after.corners, half, after.corners)
    found = np.einsum("pqax,pa->pqx", after.measures.gradients, values)
    np.testing.assert_allclose(found, places @ (half + half.T), atol=1e-12)


@every("degree", [2, 5, 8, 15])
def test_points_integrate_polynomials_of_their_degree(degree):
    points, weights = points_of_degree(degree)
    from math import factorial, prod

    for powers in np.ndindex(*(degree + 1,) * 4):
        if sum(powers) != degree:
            continue
        due = 6.0 * prod(map(factorial, powers)) / factorial(degree + 3)
        assert weights @ (points ** np.array(powers)).prod(axis=1) == pytest.approx(
            due, rel=1e-13
        )


@pytest.mark.parametrize("kind", BODIES)
def test_moments_of_parts_add_up_to_those_of_cells(kind):
    body = BODIES[kind]()
    once, _ = body.cut(body.position @ [0.3, 0.8, -0.5] - 0.2)
    again, _ = once.cut(once.position @ [0.7, -0.4, 0.4] - 0.3)
    found = again.moments
    cell = again.parts.cell
    due = moments(body.parts.shape, body.corners)
    np.testing.assert_allclose(np.bincount(cell, found.volume), due.volume, rtol=1e-13)
    for k in range(3):
        first = np.bincount(cell, found.volume * again.centroids[:, k])
        if kind == "curved hexahedra":  # 27 points are not enough for their first moments
            np.testing.assert_allclose(first, first_moments(body)[:, k], rtol=1e-12)
        else:
            np.testing.assert_allclose(first, due.first[:, k], rtol=1e-12)


def first_moments(body):
    """Return ∫ x dV of whole hexahedra with 27 nodes, whose degree is 7 along each axis."""
    line, weight = np.polynomial.legendre.leggauss(4)
    points = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.einsum("i,j,k->ijk", weight, weight, weight).ravel()
    at = functions(body.parts.shape, points)
    places = at.values @ body.corners
    size = np.linalg.det(np.einsum("eax,qak->eqxk", body.corners, at.gradients))
    return np.einsum("q,eq,eqx->ex", weights, size, places)


@pytest.mark.parametrize("shape", SHAPES)
def test_points_have_the_volume_centroid_and_covariance_of_a_part(shape):
    """Against means of points that are evenly spread in the part, by an independent count."""
    body = Body.cube(shape, 1)
    after, _ = body.cut(body.position @ [0.5, 0.7, 0.2] - 0.6)
    found = after.moments
    points = matched_points(after.parts, found)
    share = ELEMENTS[shape].weights / ELEMENTS[shape].weights.sum()
    np.testing.assert_allclose(share @ points, found.centroid, atol=1e-14)
    away = points - found.centroid[:, None]
    covariance = np.einsum("q,pqx,pqy->pxy", share, away, away)
    np.testing.assert_allclose(covariance, found.covariance, atol=1e-14)
    pieces = after.parts.pieces
    corners, weight = after.parts.natural(pieces), pieces.inside.fraction
    for part in range(len(after.parts)):
        own = pieces.part == part
        if not own.any():
            continue
        w = weight[own] / weight[own].sum()
        mean = w @ corners[own].mean(axis=1)
        d = corners[own] - mean
        # ∫ x x of a tetrahedron: V/20 (Σ d d + Σ d Σ d).
        total = d.sum(axis=1)
        second = np.einsum("pax,pay->pxy", d, d) + np.einsum("px,py->pxy", total, total)
        np.testing.assert_allclose(found.centroid[part], mean, atol=1e-14)
        due = np.einsum("p,pxy->xy", w, second) / 20.0
        np.testing.assert_allclose(found.covariance[part], due, atol=1e-14)


def lumped(body, bulk=13.0 / 6.0):
    """Return the volumes that nodes stand for; the bulk modulus is that of ``LAME``."""
    ratio = np.full(len(body.parts), bulk)
    found = node_volumes(body.parts, body.corners, body.measures, ratio)
    return found, np.bincount(body.parts.nodes.ravel(), found.ravel(), len(body.position))


@pytest.mark.parametrize("kind", BODIES)
def test_masses_of_places_stay_what_they_are(kind):
    body = BODIES[kind]()
    _, before = lumped(body)
    for normal, offset in blades(6, seed=24):
        after, _ = body.cut(body.position @ normal - offset)
        each, masses = lumped(after)
        assert each.min() > 0.0
        places = np.bincount(after.parent, masses, len(before))
        np.testing.assert_allclose(places, before, atol=1e-14)
        # So do those of a velocity field that is linear: mass, momenta and kinetic energy.
        speed = np.array([[0.3, 1.0, -0.2], [0.1, 0.4, 0.8], [-0.7, 0.2, 0.5]])
        old, new = body.drawn @ speed, after.position @ speed
        np.testing.assert_allclose(masses @ new, before @ old, atol=1e-12)
        energy = before @ (old**2).sum(axis=1)
        assert masses @ (new**2).sum(axis=1) == pytest.approx(energy, rel=1e-12)
        turn = [m @ np.cross(x, v) for m, x, v in
                ((masses, after.position, new), (before, body.drawn, old))]  # fmt: skip
        np.testing.assert_allclose(*turn, atol=1e-12)


def largest_eigenvalue(body):
    matrix = assembled(body, stiffness(body, LAME))
    scale = diags(1.0 / np.sqrt(np.repeat(lumped(body)[1], 3)))
    start = np.ones(matrix.shape[0])
    start[::2] = -0.3
    found = eigsh(scale @ matrix @ scale, 1, which="LA", tol=1e-3, v0=start)
    return found[0][0]


@pytest.mark.parametrize("kind", BODIES)
def test_the_stable_step_falls_to_no_less_than_half(kind):
    """The largest eigenvalue of M⁻¹ K is at most four times that before."""
    body = BODIES[kind]()
    before = largest_eigenvalue(body)
    smallest = 1.0
    for normal, offset in blades(6, seed=26):
        # The plane passes next to a node, so that a corner of a cell is cut off.
        corners = np.unique(body.parts.nodes[:, : len(body.parts.division.corners)])
        corners = corners[body.inner[corners]]
        node = corners[np.argmin(np.abs(body.position[corners] @ normal - offset))]
        offset = body.position[node] @ normal + (-1.0) ** node * 1e-4
        after, _ = body.cut(body.position @ normal - offset)
        smallest = min(smallest, after.parts.fractions.min())
        assert largest_eigenvalue(after) < 4.0 * before
    assert smallest < 1e-9
    for normal, offset in blades(10, seed=27):
        after, _ = body.cut(body.position @ normal - offset)
        assert largest_eigenvalue(after) < 4.0 * before


@pytest.mark.parametrize("kind", ["hexahedra", "quadratic hexahedra", "wedges", "tetrahedra"])
def test_so_it_does_where_corners_of_a_body_are_cut_off(kind):
    """Parts there share no nodes with others, and have eigenvalues of their own."""
    body, rng = BODIES[kind](), np.random.default_rng(1)
    before = largest_eigenvalue(body)
    corners = np.unique(body.parts.nodes[:, : len(body.parts.division.corners)])
    outer = corners[~body.inner[corners]]
    for _ in range(12):
        normal = rng.normal(size=3)
        heights = (body.position - body.position[rng.choice(outer)]) @ normal
        after, _ = body.cut(heights / np.linalg.norm(normal) - 10.0 ** rng.uniform(-5.0, -0.5))
        assert largest_eigenvalue(after) < 4.0 * before


def test_small_parts_of_tetrahedra_take_volume_over():
    body = Body.random(2)
    corner = body.position[body.parts.nodes[0, 0]]
    after, _ = body.cut(np.linalg.norm(body.position - corner, axis=1) - 0.02)
    found = lumped(after)[0].sum(axis=1)
    own = after.moments.volume
    assert (found > own + 1e-12).any() and (found < own - 1e-12).any()
    np.testing.assert_allclose(
        np.bincount(after.parts.cell, found), np.bincount(after.parts.cell, own), rtol=1e-13
    )
    whole = after.parts.are_whole
    np.testing.assert_allclose(found[whole], own[whole], rtol=1e-15)
    assert min(MOST.values()) > 1.0


@pytest.mark.parametrize("kind", BODIES)
def test_some_parts_have_the_measures_that_they_have_among_all(kind):
    body = BODIES[kind]()
    after, _ = body.cut(body.position @ [0.3, 0.8, -0.5] - 0.2)
    chosen = np.arange(len(after.parts)) % 3 > 0
    own = after._replace(parts=after.parts.some(chosen))
    np.testing.assert_allclose(own.measures.volume, after.measures.volume[chosen], rtol=1e-14)
    due = after.measures.gradients[chosen]
    np.testing.assert_allclose(own.measures.gradients, due, atol=1e-11 * np.abs(due).max())


def test_moments_need_no_cell_to_be_divided():
    body = Body.cube("wedge", 1)
    found = PartMoments.of(body.parts, body.corners)
    np.testing.assert_allclose(body.centroids, body.corners.mean(axis=1), atol=1e-14)
    values = functions("wedge", found.centroid).values
    np.testing.assert_allclose(values, 1.0 / 6.0, atol=1e-14)
