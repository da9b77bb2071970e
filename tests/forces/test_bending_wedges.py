"""Wedges: layers in bending, plates, shells, uniform and large strain, and stable steps."""

from itertools import pairwise, product

import numpy as np
import pytest
from scipy.linalg import eigvalsh, solve
from scipy.sparse import block_array, coo_array, csc_matrix
from scipy.sparse.linalg import spsolve
from scipy.spatial import Delaunay

from tests.derivatives import forces
from tests.forces.test_beams_of_papers import elastica
from tests.forces.test_bending_cells import YOUNG, made_of, matrix_at, moved_by, of_edges
from tests.forces.test_elements import SPAN
from tissuec.core.arrays import rigid_motions
from tissuec.forces.solids.elements import SolidElements, SolidMaterial
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.meshes.generators.sphere import divide, icosahedron


def triangles(counts, sides, kind, seed=3):
    """Return places of a rectangle, shape (place, 2), and its triangles.

    Args:
        counts: Of cells along each side.
        sides: Of the rectangle [m].
        kind: "even", with all diagonals alike; "turned", with diagonals in turn; "uneven", with
            places moved by up to 0.3 of a cell.
    """
    steps = [np.linspace(0.0, side, n + 1) for side, n in zip(sides, counts, strict=True)]
    places = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(places)).reshape([n + 1 for n in counts])
    found = []
    for i, j in product(*(range(n) for n in counts)):
        a, b, c, d = (number[i + p, j + q] for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
        other = kind == "turned" and (i + j) % 2
        found += [(a, b, d), (b, c, d)] if other else [(a, b, c), (a, c, d)]
    if kind != "uneven":
        return places, np.array(found)
    moved = np.random.default_rng(seed).uniform(-0.3, 0.3, places.shape)
    for axis, side in enumerate(sides):
        moved[np.isclose(places[:, axis] % side, 0.0), axis] = 0.0
    cell = np.divide(sides, counts)
    unit = places / cell + moved
    found = Delaunay(unit).simplices
    ends = unit[found[:, 1:]] - unit[found[:, :1]]
    area = ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]
    found[area < 0.0] = found[area < 0.0][:, ::-1]
    return unit * cell, found[np.abs(area) > 1e-9]


def layered(flat, corners, thickness, layers):
    """Return places and nodes of layers of wedges on triangles, from z = 0 on."""
    heights = np.linspace(0.0, thickness, layers + 1)
    places = np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in heights])
    each = [corners + k * len(flat) for k in range(layers + 1)]
    return places, np.concatenate([np.hstack(two) for two in pairwise(each)])


# --- bending ----------------------------------------------------------------------------------


def bent_by_moments(ratio, layers, poisson, kind, across=1):
    """Return the work of moments at the ends of a strip over that of the theory of beams.

    The moment is that of σ = z in a section with the thickness 1 m.
    """
    cell, wide = ratio / layers, ratio / layers * across
    flat, corners = triangles((8, across), (8.0 * cell, wide), kind)
    places, nodes = layered(flat, corners, 1.0, layers)
    elements = made_of("wedge", places, nodes, poisson)
    load = np.zeros_like(places)
    steps = np.linspace(0.0, 1.0, layers + 1)
    up = of_edges(steps) @ (steps - 0.5)
    for x, sign in ((0.0, -1.0), (8.0 * cell, 1.0)):
        end = np.flatnonzero(np.isclose(flat[:, 0], x))
        end = end[np.argsort(flat[end, 1])]
        share = of_edges(flat[end, 1]).sum(axis=1)
        for k, one in enumerate(up):
            load[end + k * len(flat), 0] = sign * one * share
    return load.ravel() @ moved_by(elements, places, load) / (8.0 * cell * wide / 12.0 / YOUNG)


RATIOS = (0.1, 0.5, 1.0, 4.0, 20.0)  # edges along the layers over their thickness


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45, 0.49])
@pytest.mark.parametrize("kind", ["even", "turned", "uneven"])
def test_layers_bend_as_beams_at_any_ratio_of_edges(poisson, kind):
    found = {
        each: bent_by_moments(*each[:2], poisson, kind, each[2])
        for each in product(RATIOS, (1, 2), (1, 3))
    }
    # Curvature is uniform, so that wedges have the strain of a plate in plane stress: exact.
    # Rounding grows with the square of the ratio.
    wrong = {each: value for each, value in found.items() if abs(value - 1.0) > 1e-7}
    assert not wrong


def deflected(cells, slender, poisson, kind):
    """Return the deflection of a clamped square plate under an even load over Kirchhoff's.

    (S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, 1959, table 35.) It is
    a quarter of the plate.

    Args:
        slender: Side over thickness.
    """
    half, thickness = 0.5, 1.0 / slender
    flat, corners = triangles((cells, cells), (half, half), kind)
    places, nodes = layered(flat, corners, thickness, 1)
    elements = made_of("wedge", places, nodes, poisson)
    held = np.zeros(places.shape, dtype=bool)
    for axis in (0, 1):
        held[np.isclose(places[:, axis], half), axis] = True
        held[np.isclose(places[:, axis], 0.0)] = True
    area = np.linalg.det(
        np.stack([flat[corners[:, k]] - flat[corners[:, 0]] for k in (1, 2)], axis=1)
    )
    load = np.zeros_like(places)
    for k in (0, len(flat)):
        np.add.at(load[:, 2], corners.ravel() + k, np.repeat(area / 12.0, 3))
    free = ~held.ravel()
    stiff = elements.matrix(0.0, places, np.arange(len(places)), len(places)).tocsc()
    moved = spsolve(csc_matrix(stiff[free][:, free]), load.ravel()[free])
    found = np.zeros(load.size)
    found[free] = moved
    middle = np.flatnonzero(np.isclose(places[:, :2], half).all(axis=1))
    rigidity = YOUNG * thickness**3 / 12.0 / (1.0 - poisson**2)
    return found.reshape(-1, 3)[middle, 2].mean() / (0.00126532 / rigidity)


@pytest.mark.parametrize("kind", ["even", "turned", "uneven"])
@pytest.mark.parametrize(("cells", "slender"), [(16, 100.0), (16, 320.0)])
def test_a_clamped_plate_gives_way_as_kirchhoffs(cells, slender, kind):
    """Wedges are three and ten times as long as thick."""
    assert deflected(cells, slender, 0.3, kind) == pytest.approx(1.0, abs=0.03)


def test_a_strip_one_wedge_thick_bends_as_the_elastica():
    """p = 10; wedges are twice as long as thick, and sections 1/100 of the length."""
    flat, corners = triangles((50, 1), (100.0, 2.0), "turned")
    places, nodes = layered(flat, corners, 1.0, 1)
    elements = made_of("wedge", places, nodes, 0.0)
    far, free = places[:, 0] > 99.9, places[:, 0] > 1e-9
    load = np.zeros_like(places)
    load[far, 2] = 10.0 * YOUNG * 2.0 / 12.0 / 100.0**2 / far.sum()
    position, chosen = places.copy(), np.repeat(free, 3)
    for part in np.linspace(0.1, 1.0, 10):
        for _ in range(30):
            left = (forces(elements, position) + part * load).ravel()[chosen]
            number = np.arange(len(places))
            stiff = elements.matrix(0.0, position, number, len(places)).tocsc()
            step = spsolve(csc_matrix(stiff[chosen][:, chosen]), left)
            position[free] += step.reshape(-1, 3)
            if np.abs(step).max() < 1e-8:
                break
        else:
            raise AssertionError("no equilibrium")
    moved = (position - places)[far].mean(axis=0)
    # A hundredth of the length lets it shear and stretch by some 1e-4.
    assert moved[[0, 2]] == pytest.approx(100.0 * np.array(elastica(10.0)), rel=5e-3)


def test_in_the_plane_of_their_triangles_wedges_stay_stiff():
    """As triangles of uniform strain are: four times, with one cell across and ν = 0."""
    flat, corners = triangles((10, 1), (10.0, 1.0), "turned")
    places, nodes = layered(flat, corners, 1.0, 1)
    places = places[:, [0, 2, 1]] * [
        1.0,
        -1.0,
        1.0,
    ]  # the sides of triangles are across the bar
    stiff = matrix_at(made_of("wedge", places, nodes, 0.0), places)
    held, moved = np.zeros(places.shape, dtype=bool), np.zeros(places.shape)
    at_end = np.isclose(places[:, 0] % 10.0, 0.0)
    held[at_end, 0] = True
    held[0] = held[:1, 1] = True
    held[np.isclose(places, [0.0, -1.0, 0.0]).all(axis=1), 2] = True
    moved[:, 0] = np.where(places[:, 0] > 5.0, places[:, 2] - 0.5, 0.0) * at_end
    fixed, way = held.ravel(), moved.ravel()
    rest = stiff[np.ix_(~fixed, fixed)] @ way[fixed]
    way[~fixed] = solve(stiff[np.ix_(~fixed, ~fixed)], -rest, assume_a="pos")
    assert way @ stiff @ way / (YOUNG / 12.0 / 10.0) == pytest.approx(4.0, rel=1e-3)


# --- patches ----------------------------------------------------------------------------------


def patch(twisted):
    """Return what forces uniform strain leaves within a block of irregular wedges, over others.

    Args:
        twisted: Whether sides are; otherwise they are flat, and wedges taper and lean, and are
            of uneven heights.
    """
    random = np.random.default_rng(5)
    flat, corners = triangles((3, 3), (3.0, 3.0), "uneven")
    places, nodes = layered(flat, corners, 3.0, 3)
    inside = (np.abs(places - 1.5) < 1.4).all(axis=1)
    places[:, 2] += random.uniform(-0.2, 0.2, len(places)) * inside
    places[:, :2] = 1.5 + (places[:, :2] - 1.5) * (1.0 + 0.1 * places[:, 2:])
    places[:, 0] += 0.3 * places[:, 2]
    if twisted:
        places[inside] += random.uniform(-twisted, twisted, (inside.sum(), 3))
    stretch = np.array([[1.2, 0.1, -0.05], [0.0, 0.9, 0.15], [0.1, -0.1, 1.05]])
    elements = made_of("wedge", places, nodes, 0.3)
    start = places @ stretch.T
    pushed = forces(elements, start)
    free = np.repeat(inside, 3)
    stiff = matrix_at(elements, start)[np.ix_(free, free)]
    moved = np.linalg.solve(stiff, pushed[inside].ravel())
    return np.abs(pushed[inside]).max() / np.abs(pushed).max(), np.abs(moved).max() / 3.0


def test_wedges_with_flat_sides_pass_the_patch_test():
    pushed, _ = patch(0.0)
    assert pushed < 1e-12


def test_twisted_sides_leave_little_of_uniform_strain():
    """Places move by less than 1e-3 of what the strain of 0.2 moves them, and as the twist."""
    moved = [patch(twisted)[1] for twisted in (0.15, 0.015)]
    assert moved[0] < 1e-3 * 0.2
    assert moved[1] < 0.2 * moved[0]


# --- steps, and large strains -----------------------------------------------------------------


def straight(places, nodes, poisson):
    """Return wedges that do not bend: six points of their own strain, and a mean pressure."""
    count = len(nodes)
    shear, bulk = YOUNG / 2.0 / (1.0 + poisson), YOUNG / 3.0 / (1.0 - 2.0 * poisson)
    material = SolidMaterial(
        np.full(count, shear), np.full(count, bulk), np.zeros(count), np.zeros(count, int),
        (NeoHookean(),),
    )  # fmt: skip
    return SolidElements.of("bar", SHAPES["wedge"], nodes, places, material, 0, SPAN)


def largest(places, nodes, poisson):
    """Return the largest eigenvalues of the matrices of wedges, and of straight ones."""
    both = made_of("wedge", places, nodes, poisson), straight(places, nodes, poisson)
    return [eigvalsh(matrix_at(each, places))[-1] for each in both]


@pytest.mark.parametrize(
    ("poisson", "bound"), [(0.0, 1.3), (0.2, 1.0), (0.3, 1.0), (0.45, 1.0), (0.4999, 1.0)]
)
def test_steps_are_as_long_as_those_of_wedges_that_do_not_bend(poisson, bound):
    """All nodes have the same mass, so that steps follow from the largest eigenvalue.

    Without lateral strain, what shears wedges that are some three times as long as thick may be
    stiffer than what lengthens them.
    """
    shapes = [(0.0, 1.0), (0.5, 0.75**0.5), (0.0, 0.6)]
    for corner, ratio in product(shapes, (*RATIOS, 2.0, 3.0)):
        flat = ratio * np.array([(0.0, 0.0), (1.0, 0.0), corner])
        found, straight = largest(*layered(flat, np.array([[0, 1, 2]]), 1.0, 1), poisson)
        assert found <= straight * bound * (1.0 + 1e-9), (corner, ratio)


def equilibrium(elements, position, free, steps=60):
    """Return where free coordinates have no force, by Newton's method with ever less energy."""
    chosen, number = free.ravel(), np.arange(len(position))
    for _ in range(steps):
        pushed = forces(elements, position)
        if np.abs(pushed[free]).max() < 1e-9 * YOUNG:
            return position
        stiff = elements.matrix(0.0, position, number, len(number)).toarray()
        values, ways = np.linalg.eigh(stiff[np.ix_(chosen, chosen)])
        values = np.maximum(np.abs(values), 1e-6 * np.abs(values).max())
        step = np.zeros(position.shape)
        step[free] = ways @ ((ways.T @ pushed[free]) / values)
        energy, part = elements.energies(position).sum(), 1.0
        while part > 1e-6 and elements.energies(position + part * step).sum() > energy:
            part *= 0.5
        position = position + part * step
    return position


@pytest.mark.parametrize("poisson", [0.3, 0.45, 0.49])
@pytest.mark.parametrize("axis", [1, 2], ids=["across", "along"])
@pytest.mark.parametrize("is_glued", [False, True], ids=["free", "glued"])
def test_blocks_are_stable_when_pressed_to_half(poisson, axis, is_glued):
    flat, corners = triangles((2, 2), (1.0, 1.0), "turned")
    drawn, nodes = layered(flat, corners, 1.0, 2)
    elements = made_of("wedge", drawn, nodes, poisson)
    low, high = np.isclose(drawn[:, axis], 0.0), np.isclose(drawn[:, axis], 1.0)
    free = np.ones(drawn.shape, dtype=bool)
    if is_glued:
        free[low] = free[high] = False
    else:
        free = drawn > 1e-9  # three planes of symmetry
        free[high, axis] = False
    position, found = drawn.copy(), []
    for height in np.linspace(0.95, 0.5, 10):
        position[:, axis] *= height / position[high, axis].mean()
        position = equilibrium(elements, position, free)
        found.append(-forces(elements, position)[high, axis].sum())
        chosen = free.ravel()
        assert np.linalg.eigvalsh(matrix_at(elements, position)[np.ix_(chosen, chosen)])[0] > 0
    assert (np.diff(found) < 0.0).all()


@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_a_wedge_that_is_turned_inside_out_stores_ever_more(poisson):
    places, nodes = layered(*triangles((1, 1), (1.0, 1.0), "even"), 1.0, 1)
    elements = made_of("wedge", places, nodes, poisson)
    for way in np.eye(3):
        heights = np.linspace(1.0, -1.5, 51)
        states = [places * (1.0 + (height - 1.0) * way) for height in heights]
        assert (np.diff([elements.energy(0.0, each) for each in states]) > 0.0).all()
    random = np.random.default_rng(0)
    for size in (0.3, 1.0, 1.5):
        states = random.uniform(-size, size, (20, *places.shape))
        assert min(elements.energy(0.0, each) for each in states) > 0.0


@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_two_wedges_recover_from_random_places_as_straight_ones_do(poisson):
    """Some starts end at rest in another equilibrium, turned inside out, with both.

    Which ones do is chaotic, and depends on the rounding of the machine: of 20 starts, numbers
    with the same probability of 0.85 differ by 5 or more in 2 % of all cases.
    """
    drawn, nodes = layered(*triangles((1, 1), (1.0, 1.0), "even"), 1.0, 1)
    free = np.repeat(drawn[:, 2:] > 0.5, 3, axis=1)

    def recovered(elements):
        random, found = np.random.default_rng(3), 0
        for _ in range(20):
            start = np.where(free, random.uniform(-0.5, 1.5, drawn.shape), drawn)
            ended = equilibrium(elements, start, free, steps=200)
            found += np.abs(ended - drawn).max() < 1e-5
        return found

    bent = recovered(made_of("wedge", drawn, nodes, poisson))
    as_straight = recovered(straight(drawn, nodes, poisson))
    assert bent > as_straight - 5
    assert as_straight > 10


# --- shells -----------------------------------------------------------------------------------


@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_a_sphere_of_wedges_widens_under_pressure_as_lames(poisson):
    """The inner radius is 9 m, the outer one 10 m; wedges are 1.5 times as long as thick."""
    unit, corners = icosahedron()
    for _ in range(3):
        unit, corners = divide(unit, corners)
    places = np.concatenate([9.0 * unit, 10.0 * unit])
    nodes = np.hstack([corners, corners + len(unit)])
    elements = made_of("wedge", places, nodes, poisson)
    pressure, load = 1.0, np.zeros_like(places)
    a, b, c = (places[corners[:, k]] for k in range(3))
    np.add.at(
        load, corners.ravel(), np.repeat(pressure * np.cross(b - a, c - a) / 6.0, 3, axis=0)
    )
    number = np.arange(len(places))
    stiff = elements.matrix(0.0, places, number, len(places)).tocsc()
    rigid = rigid_motions(places - places.mean(axis=0)).reshape(-1, 6)
    # Rigid motions bear no load: bordered by them, the matrix has one solution.
    bordered = block_array(
        [[stiff, coo_array(rigid)], [coo_array(rigid.T), None]], format="csc"
    )
    moved = spsolve(bordered, np.append(load.ravel(), np.zeros(6)))[: places.size]
    inner = (moved.reshape(-1, 3)[: len(unit)] * unit).sum(axis=1).mean()
    ratio = (10.0 / 9.0) ** 3
    due = pressure * 9.0 / YOUNG / (ratio - 1.0)
    due *= (1.0 - 2.0 * poisson) + (1.0 + poisson) * ratio / 2.0
    assert inner == pytest.approx(due, rel=0.02)
