"""Surfaces are what they are, however they are divided into triangles; pieces of lines too."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from tests.contact.scenes import by_loops, contact_with
from tests.derivatives import forces
from tissuec.core.structs import replace
from tissuec.geometry.inclusion import shared_elements, weights
from tissuec.geometry.nearest import CAPSULE, TRIANGLE

RADIUS, STIFFNESS, LAYER = 0.1, 50.0, 0.05  # of ``contact_with``


def triangulation(rng, columns=7):
    """Return a unit square of irregular triangles: places, shape (node, 3), and corners."""
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, columns)] * 2), axis=-1).reshape(-1, 2)
    inner = ((grid > 0.0) & (grid < 1.0)).all(axis=1)
    grid[inner] += rng.uniform(-0.3, 0.3, (inner.sum(), 2)) / columns
    # A straight rim has flat triangles of three collinear points in it, which are none.
    corners = Delaunay(grid).simplices.astype(np.int64)
    a, b, c = grid[corners].swapaxes(0, 1)
    solid = np.abs(np.linalg.det(np.stack([b - a, c - a], axis=1))) > 1e-9
    return np.column_stack([grid, np.zeros(len(grid))]), corners[solid]


def on_surface(nodes, surface, corners, **options):
    """Return a contact of nodes with a surface, and the places of all [m]."""
    contact = contact_with(TRIANGLE, len(nodes) + corners, len(nodes), **options)
    return contact, np.concatenate([nodes, surface, np.zeros((len(contact.memory), 3))])


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))]
)
@pytest.mark.parametrize("depth", [0.02, 0.07])
def test_a_flat_sheet_is_flat_whatever_its_triangles(seed, depth):
    rng = np.random.default_rng(seed)
    across = rng.uniform(0.0, 1.0, (200, 2))  # to the very rim
    nodes = np.column_stack([across, np.full(200, RADIUS - depth)])
    contact, x = on_surface(nodes, *triangulation(rng), friction=0.3)
    v = np.zeros_like(x)
    v[:200], v[contact.memory] = (0.3, 0.1, -0.2), contact.rate * np.array([2e-3, 1e-3, 0.0])
    found = forces(contact, x, v)[:200]
    deep = depth - LAYER / 2 if depth > LAYER else depth**2 / (2 * LAYER)
    pressure = STIFFNESS * deep * (1.0 + 0.1 * 0.2)  # with contact damping of 0.1 s/m
    reach = pressure / STIFFNESS + LAYER / 2
    rubbing = -pressure / reach * np.array([2e-3, 1e-3])
    # Some hundred roundings of forces that cancel.
    assert found[:, 2] == pytest.approx(pressure, rel=1e-12)
    assert found[:, :2] == pytest.approx(np.tile(rubbing, (200, 1)), abs=1e-12 * pressure)
    _, _, touches = by_loops(contact, x, v)
    rates = touches.bent
    assert rates == pytest.approx(np.tile(rates[0], (200, 1)), rel=1e-9)
    # Of each node: one or two depths, and damping that lets go of nothing.
    assert touches.bends[0] == 200 * (2 + (depth > LAYER))


def test_beside_a_flat_sheet_a_node_feels_the_nearest_point_of_its_rim():
    rng = np.random.default_rng(3)
    along = rng.uniform(0.1, 0.9, 50)
    nodes = np.column_stack([np.full(50, -0.03), along, np.full(50, 0.04)])
    contact, x = on_surface(nodes, *triangulation(rng))
    found = forces(contact, x, np.zeros_like(x))[:50]
    depth = RADIUS - 0.05
    size = STIFFNESS * depth**2 / (2 * LAYER)
    # Corners of the rim lie on it to rounding only.
    assert found == pytest.approx(
        np.tile(size * np.array([-0.6, 0.0, 0.8]), (50, 1)), abs=1e-10
    )


def test_energy_of_a_bent_surface_does_not_depend_on_its_triangles():
    rng = np.random.default_rng(4)
    corners = np.array(
        [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [0, 1, 5]]
    )  # a fan and a fin
    surface = rng.uniform(-0.1, 0.1, (6, 3))
    middle = surface[corners].mean(axis=1)
    new = 6 + np.arange(len(corners))
    finer = np.concatenate(
        [np.stack([corners[:, i], corners[:, (i + 1) % 3], new], axis=1) for i in range(3)]
    )
    nodes = rng.uniform(-0.15, 0.15, (100, 3))
    energies, found = [], []
    for places, faces in ((surface, corners), (np.concatenate([surface, middle]), finer)):
        contact, x = on_surface(nodes, places, faces)
        energies.append(float(contact.energy(0.0, x)))
        found.append(forces(contact, x, np.zeros_like(x))[:100])
    assert energies[0] > 0.1
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)
    assert found[0] == pytest.approx(found[1], abs=1e-9 * np.abs(found[0]).max())


def test_pieces_of_a_line_press_as_the_whole_line():
    ends = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros((6, 2))])
    pieces = np.array([[i, i + 1, i + 1] for i in range(5)])
    nodes = np.column_stack([np.linspace(0.01, 0.99, 50), np.zeros(50), np.full(50, 0.05)])
    contact = contact_with(CAPSULE, 50 + pieces, 50)
    found = forces(contact, np.concatenate([nodes, ends]), np.zeros((56, 3)))[:50]
    expected = STIFFNESS * 0.05**2 / (2 * LAYER) * np.array([0.0, 0.0, 1.0])
    assert found == pytest.approx(np.tile(expected, (50, 1)), abs=1e-12)


def test_weights_of_all_elements_at_a_point_add_up_to_one():
    _, corners = triangulation(np.random.default_rng(0))
    corners = np.concatenate([corners, [[0, 1, 60], [0, 1, 61]]])  # three sheets at one edge
    faces = np.arange(0, len(corners), 2)  # and with holes
    count = len(corners)
    shared = shared_elements(corners, np.full(count, 3), np.zeros(count, dtype=np.int64))
    found = weights(np.zeros(len(faces), dtype=np.int64), faces, shared.parts)
    weight = np.zeros(len(shared.parts))
    weight[faces], weight[found.element] = 1.0, found.weight
    points = np.concatenate([corners, shared.points])
    of = [frozenset(row) for row in points.tolist()]
    for element in {part for face in faces for part in shared.parts[face] if part >= 0}:
        over = [other for other in range(len(of)) if of[element] <= of[other]]
        assert weight[over].sum() == 1.0


def oblique(seed, kind):
    """Return contact and a random state of a bent surface or line that nodes rub on."""
    rng = np.random.default_rng(seed)
    surface, corners = triangulation(rng)
    if kind == CAPSULE:
        corners = np.array([[i, i + 1, i + 1] for i in range(len(surface) - 1)])
    surface = surface + 0.05 * rng.normal(size=surface.shape)
    nodes = np.column_stack([rng.uniform(0.0, 1.0, (60, 2)), 0.1 * rng.normal(size=60)])
    contact = contact_with(
        kind, 60 + corners, 60, friction=0.4, stiffness=np.linspace(40.0, 60.0, 60)
    )
    x = np.concatenate([nodes, surface, np.zeros((60, 3))])
    v = rng.normal(size=x.shape)
    v[contact.memory] *= 5e-3 * contact.rate
    return contact, x, v


@pytest.mark.parametrize("seed", range(3))
def test_friction_on_a_surface_has_no_force_and_no_moment_as_a_whole(seed):
    contact, x, v = oblique(seed, TRIANGLE)
    found = forces(contact, x, v)
    assert np.abs(found - forces(replace(contact, friction=0.0), x, v)).max() > 0.01
    moments = np.cross(x, found)
    # Roundings of hundreds of forces, and of those that take up couples in narrow triangles.
    assert np.abs(found.sum(axis=0)).max() < 1e-13 * np.abs(found).sum()
    assert np.abs(moments.sum(axis=0)).max() < 1e-13 * np.abs(moments).sum()


@pytest.mark.parametrize("kind", [TRIANGLE, CAPSULE])
def test_all_that_contact_takes_out_is_booked(kind):
    contact, x, v = oblique(7, kind)
    shown = v * (np.arange(len(x)) < contact.memory[0])[:, None]
    h = 1e-7
    done = np.vdot(forces(contact, x, v), shown)
    ahead, behind = (float(contact.energy(0.0, x + s * h * shown)) for s in (1.0, -1.0))
    lost = contact.powers(0.0, x, v)[1]
    # Central differences of an energy of about 1 J.
    assert done + (ahead - behind) / (2.0 * h) == pytest.approx(-lost, rel=1e-6)


def test_what_turns_as_a_whole_does_not_slide():
    contact, x, v = oblique(2, TRIANGLE)
    v[contact.memory] = 0.0
    slides = np.abs(by_loops(contact, x, v)[2].bent).max()
    v = np.cross([1.0, -2.0, 0.5], x) + np.array([0.2, 0.1, -0.3])
    v[contact.memory] = 0.0
    turned = np.abs(by_loops(contact, x, v)[2].bent).max()
    assert turned < 1e-10 * slides


def test_what_is_held_by_friction_holds_still_whatever_it_weighs():
    weights = np.logspace(-9, 0, 10)  # [N]
    deep = np.sqrt(2.0 * LAYER * weights / STIFFNESS)
    deep = np.where(deep < LAYER, deep, weights / STIFFNESS + 0.5 * LAYER)
    nodes = np.column_stack([np.linspace(0.1, 0.9, 10), np.full(10, 0.4), RADIUS - deep])
    contact, x = on_surface(nodes, *triangulation(np.random.default_rng(6)), friction=0.3)
    v = np.zeros_like(x)
    reach = weights / STIFFNESS + 0.5 * LAYER
    v[contact.memory, 0] = 0.99 * 0.3 * reach * contact.rate
    found = forces(contact, x, v)[:10]
    assert found[:, 2] == pytest.approx(weights, rel=1e-6)  # depths of nanometres below 0.1 m
    assert found[:, 0] == pytest.approx(-0.99 * 0.3 * weights, rel=1e-6)
    assert not by_loops(contact, x, v)[2].bent.any()


def test_friction_is_at_most_that_of_coulomb_under_the_least_pressure():
    rng = np.random.default_rng(5)
    nodes = np.column_stack(
        [rng.uniform(0.0, 1.0, (50, 2)), RADIUS - np.logspace(-9, -1.2, 50)]
    )
    contact, x = on_surface(nodes, *triangulation(rng), friction=0.3)
    v = np.zeros_like(x)
    v[contact.memory] = contact.rate * np.array([1.0, 0.0, 0.0])  # bent beyond all measure
    found = forces(contact, x, v)[:50]
    assert found[:, 2].min() > 0.0
    assert -found[:, 0] == pytest.approx(0.3 * found[:, 2], rel=1e-6)
