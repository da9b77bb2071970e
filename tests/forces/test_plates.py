"""Walls of triangles that bend: energies, closed forms of plates, and the reference."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from tests.derivatives import agree, follow_from_the_energy, forces
from tissuec.core.source import Source, Span
from tissuec.forces.surfaces.plates import Plates
from tissuec.matter.plate import patches
from tissuec.meshes.elements import wall_of_triangles
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.sheet import Sheet
from tissuec.meshes.generators.sphere import Sphere
from tissuec.meshes.generators.tube import Tube
from tissuec.validate.forces.bending import PlateBending

SPAN = Span(Source("scene", ""), 0, 0)
RIGIDITY = 2e-6  # [N m]
RATIOS = (0.0, 0.3, 0.45)
TUBE = Tube(axis=((0, 0, 0), (0.02, 0, 0)), radius=0.005, rings=4, sides=7)
SPHERE = Sphere(centre=(0, 0, 0), radius=0.01, subdivisions=1)


def sheet(columns, rows, *, length=0.02, width=0.01):
    return Sheet(corner=(0, 0, 0), first_edge=(length, 0, 0), second_edge=(0, width, 0),
                 columns=columns + 1, rows=rows + 1)  # fmt: skip


WALLS = {"sheet": sheet(3, 2), "tube": TUBE, "sphere": SPHERE}


def plates(generator, ratio=0.3, *, delay=0.0):
    """Return the bending of a wall, and where its nodes are drawn."""
    mesh = wall_of_triangles(generator.build())
    found = patches(mesh)
    even = np.ones(len(found.area))
    matrix = found.stiffness(RIGIDITY * even, ratio * even)
    x, count = mesh.position, delay * even
    return Plates.of("wall", found.nodes, x, matrix, count, mesh.ends, 0, SPAN), x


@pytest.mark.parametrize(
    "generator", [sheet(3, 2), TUBE, SPHERE], ids=["sheet", "tube", "sphere"]
)
@pytest.mark.parametrize("size", [3e-4, 6e-3], ids=["bent", "crumpled"])
def test_forces_and_matrices_follow_from_the_energy(generator, size):
    made, drawn = plates(generator)
    assert made.energy(0.0, drawn) == pytest.approx(0.0, abs=1e-25)
    position = drawn + size * np.random.default_rng(3).uniform(-1.0, 1.0, drawn.shape)
    follow_from_the_energy(made, position, every=7, force=1e-5, matrix=3e-5, rounding=1e-12)
    assert made.energy(0.0, position) > 0.0


@pytest.mark.parametrize(
    "generator", [sheet(3, 2), TUBE, SPHERE], ids=["sheet", "tube", "sphere"]
)
@pytest.mark.parametrize("size", [3e-4, 6e-3], ids=["bent", "crumpled"])
def test_the_reference_agrees_by_formulas_of_its_own(generator, size):
    made, drawn = plates(generator, delay=0.02)
    reference, random = PlateBending(made), np.random.default_rng(3)
    position = drawn + size * random.uniform(-1.0, 1.0, drawn.shape)
    velocity, count = random.normal(size=drawn.shape), len(drawn)
    agree(
        made, reference, position, velocity, force=1e-11, matrix=1e-10, energy=1e-11, lost=1e-11
    )
    assert made.powers(0.0, position, velocity)[1] > 0.0
    _, slow = made.damping_matrices(position, velocity, np.arange(count), count)
    braking = forces(made, position, velocity) - forces(made, position)
    np.testing.assert_allclose(
        braking.ravel(), -slow @ velocity.ravel(), atol=1e-11 * np.abs(braking).max()
    )


def test_a_plate_that_moves_as_one_is_at_rest():
    made, drawn = plates(TUBE, delay=0.02)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    position = drawn @ turn.T + [0.1, 0.2, 0.3]
    flow = np.cross([3.0, 1.0, 2.0], position)
    bent = np.abs(forces(made, 1.05 * drawn + 1e-3 * np.sin(900.0 * drawn[:, ::-1]))).max()
    assert np.abs(forces(made, position, flow)).max() < 1e-10 * bent
    assert made.powers(0.0, position, flow)[1] < 1e-20


# --- closed forms of plates -----------------------------------------------------------------


def linear(made, drawn):
    """Return the matrix of small deflections z [N/m], shape (node, node)."""
    count = len(drawn)
    return made.matrix(0.0, drawn, np.arange(count), count).toarray()[2::3, 2::3]


#: Deflections, and their energy per area and D, of curvatures of 1/m.
CURVED = {
    "along": (lambda x, y: 0.5 * x * x, lambda ratio: 0.5),
    "across": (lambda x, y: 0.5 * y * y, lambda ratio: 0.5),
    "dome": (lambda x, y: 0.5 * (x * x + y * y), lambda ratio: 1.0 + ratio),
    "twisted": (lambda x, y: x * y, lambda ratio: 1.0 - ratio),
}


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("way", CURVED)
@pytest.mark.parametrize("cells", [(8, 4), (4, 8), (12, 3)])
def test_triangles_inside_store_what_a_plate_does(cells, way, ratio):
    made, x = plates(sheet(*cells), ratio)
    shape, energy = CURVED[way]
    z = shape(x[:, 0], x[:, 1])
    whole = made.is_hinge.all(axis=1)
    inner = made.only(np.flatnonzero(whole))
    area = 0.02 * 0.01 / (cells[0] * cells[1]) / 2.0 * whole.sum()
    stored = 0.5 * z @ linear(inner, x) @ z
    assert stored == pytest.approx(RIGIDITY * energy(ratio) * area, rel=1e-9)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("way", ["along", "across"])
def test_rolled_sheets_of_any_size_store_what_a_plate_does(way, ratio):
    # A radius of 20 mm: 7 degrees to a hinge.
    made, x = plates(sheet(24, 12), ratio)
    axis, radius = (0, 0.02) if way == "along" else (1, 0.02)
    rolled = x.copy()
    rolled[:, axis] = radius * np.sin(x[:, axis] / radius)
    rolled[:, 2] = radius * (1.0 - np.cos(x[:, axis] / radius))
    inner = made.only(np.flatnonzero(made.is_hinge.all(axis=1)))
    area = 0.02 * 0.01 * inner.item_count / made.item_count
    assert inner.energy(0.0, rolled) == pytest.approx(
        0.5 * RIGIDITY / radius**2 * area, rel=3e-3
    )


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(("cells", "error"), [((40, 4), 0.03), ((20, 8), 0.04)])
def test_a_strip_with_free_borders_bends_as_a_beam(cells, error, ratio):
    # F l³ / 3 E I with E I = D (1 - ν²) b, from the middle between the held rows, which
    # also hold the strip flat across, the more so the larger ν is.
    length, width = 0.1, 0.01
    made, x = plates(sheet(*cells, length=length, width=width), ratio)
    step = length / cells[0]
    free, end = x[:, 0] > 1.01 * step, np.isclose(x[:, 0], length)
    load = np.where(end, 1.0, 0.0)
    load[end & (np.isclose(x[:, 1], 0.0) | np.isclose(x[:, 1], width))] = 0.5
    load /= load.sum()
    matrix = linear(made, x)[np.ix_(free, free)]
    sag = load[free] @ np.linalg.solve(matrix, load[free])
    beam = (length - 0.5 * step) ** 3 / (3.0 * RIGIDITY * (1.0 - ratio**2) * width)
    assert sag == pytest.approx(beam, rel=error)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(("cells", "error"), [(12, 0.025), (24, 0.007)])
def test_a_plate_on_its_borders_sags_by_its_closed_form(cells, error, ratio):
    # 0.00406235 q a⁴/D (S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates, 1959).
    side = 0.02
    made, x = plates(sheet(cells, cells, length=side, width=side), ratio)
    border = (np.isclose(x[:, :2], 0.0) | np.isclose(x[:, :2], side)).any(axis=1)
    load = np.where(border, 0.0, (side / cells) ** 2)
    z = np.zeros(len(x))
    z[~border] = np.linalg.solve(linear(made, x)[np.ix_(~border, ~border)], load[~border])
    assert z.max() == pytest.approx(0.00406235 * side**4 / RIGIDITY, rel=error)


def plate_of(position, triangles, ratio):
    """Return plates of given triangles in a plane, their places, and their mesh."""
    side, other = (position[triangles[:, k]] - position[triangles[:, 0]] for k in (1, 2))
    turned = side[:, 0] * other[:, 1] < side[:, 1] * other[:, 0]
    triangles = np.where(turned[:, None], triangles[:, ::-1], triangles).astype(np.int32)
    x = np.column_stack([position, np.zeros(len(position))])
    mesh = wall_of_triangles(Mesh(x, np.zeros((0, 2), np.int32), triangles))
    found, even = patches(mesh), np.ones(len(triangles))
    matrix = found.stiffness(RIGIDITY * even, ratio * even)
    return Plates.of("wall", found.nodes, x, matrix, 0.0 * even, mesh.ends, 0, SPAN), x, found


def nets(cells):
    """Return irregular nets of a square of 1 m: places and triangles."""
    steps, random = np.linspace(0.0, 1.0, cells + 1), np.random.default_rng(1)
    square = np.array([(a, b) for a in steps for b in steps])
    inside = ((square > 0.0) & (square < 1.0)).all(axis=1)[:, None]
    moved = random.uniform(-1.0, 1.0, square.shape) / cells * inside
    number = np.arange(len(square)).reshape(cells + 1, cells + 1)
    a, b, c, d = (number[i:cells + i, j:cells + j].ravel()
                  for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))  # fmt: skip
    one = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    swapped = (np.add.outer(np.arange(cells), np.arange(cells)) % 2 == 1).ravel()
    first = np.where(swapped[:, None], np.stack([a, b, d], 1), np.stack([a, b, c], 1))
    second = np.where(swapped[:, None], np.stack([b, c, d], 1), np.stack([a, c, d], 1))
    loose = square + 0.3 * moved
    return {
        "displaced": (square + 0.25 * moved, one),
        "delaunay": (loose, Delaunay(loose).simplices),
        "alternating": (square, np.concatenate([first, second])),
    }


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(
    ("net", "low", "high"),
    [("displaced", 0.95, 1.05), ("delaunay", 0.9, 1.12), ("alternating", 1.0, 1.25)],
)
@pytest.mark.parametrize("cells", [10, 20])
def test_plates_of_irregular_nets_sag_nearly_as_they_should(cells, net, low, high, ratio):
    made, x, found = plate_of(*nets(cells)[net], ratio)
    border = (np.isclose(x[:, :2], 0.0) | np.isclose(x[:, :2], 1.0)).any(axis=1)
    load = np.bincount(found.nodes[:, :3].ravel(), np.repeat(found.area / 3.0, 3), len(x))
    z = np.zeros(len(x))
    z[~border] = np.linalg.solve(linear(made, x)[np.ix_(~border, ~border)], load[~border])
    assert low < z.max() * RIGIDITY / 0.00406235 < high


STATES = (
    np.array([[1.0, 1.0, 0.0]]),
    np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 2.0]]),
)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("net", ["displaced", "delaunay", "alternating"])
def test_bounds_contain_the_energy_of_even_curvature_of_which_nodes_inside_are_free(net, ratio):
    made, x, found = plate_of(*nets(12)[net], ratio)
    even = np.ones(made.item_count)
    bounds = found.bounds(3.0 * even, ratio * even)
    inner = found.is_hinge.all(axis=1)
    is_held = np.zeros(len(x), dtype=bool)
    is_held[made.nodes[~inner]] = True
    matrix = linear(made.only(np.flatnonzero(inner)), x)
    area = found.area[inner].sum()
    plate = RIGIDITY * np.array([[1, ratio, 0], [ratio, 1, 0], [0, 0, 0.5 * (1 - ratio)]])
    for states, (low, high) in zip(STATES, bounds, strict=True):
        exact = area * np.einsum("si,ij,sj->", states, plate, states)
        most = least = 0.0
        for one, other, twist in states:
            z = 0.5 * (one * x[:, 0] ** 2 + other * x[:, 1] ** 2 + twist * x[:, 0] * x[:, 1])
            most += z @ matrix @ z
            free = np.ix_(~is_held, ~is_held)
            z[~is_held] = -np.linalg.lstsq(
                matrix[free], matrix[np.ix_(~is_held, is_held)] @ z[is_held], rcond=None
            )[0]
            least += z @ matrix @ z
        assert most / exact == pytest.approx(high, rel=1e-9)
        assert low - 1e-9 < least / exact < high + 1e-9


def test_bounds_of_grids_are_1():
    for generator in (sheet(5, 4), Tube(axis=((0, 0, 0), (0.04, 0, 0)), radius=0.01, rings=5,
                                        sides=12)):  # fmt: skip
        found = patches(wall_of_triangles(generator.build()))
        even = np.ones(len(found.area))
        np.testing.assert_allclose(found.bounds(even, 0.3 * even), 1.0, rtol=2e-4)
    lonely = patches(wall_of_triangles(sheet(1, 1).build()))
    assert (lonely.bounds(np.ones(2), np.zeros(2)) == 1.0).all()


def test_edges_without_a_neighbour_bear_no_moment():
    made, _ = plates(sheet(1, 1))
    assert made.is_hinge.sum() == 2  # of both triangles, the diagonal
    own = made.stiffness
    np.testing.assert_allclose(np.sort(own.ravel())[:-2], np.zeros(16), atol=1e-20)
    # A single fold about the diagonal has no moment along it: D (1 - ν²) κ²/2 per area.
    beam = RIGIDITY * (1.0 - 0.3**2)
    found = patches(wall_of_triangles(sheet(1, 1).build()))
    ((row, edge),) = np.argwhere(found.is_hinge)[:1]
    fold = found.folds[0, row, edge]
    soft = np.array([[1.0, -0.3, 0.0], [-0.3, 1.0, 0.0], [0.0, 0.0, 2.6]]) / beam
    assert own[row, edge, edge] == pytest.approx(found.area[row] / (fold @ soft @ fold))


def test_a_cut_edge_takes_the_patches_around_it():
    made, _ = plates(sheet(4, 4))
    alive = np.ones(int(made.walls.max()) + 1, dtype=bool)
    alive[made.walls[0]] = False
    left = made.intact(alive)
    assert 0 < left.item_count < made.item_count
    assert made.items(np.arange(100)).first[-1] == 3 * 32 + made.is_hinge.sum()
