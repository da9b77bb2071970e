"""The lattice: counts, faces, tied surface nodes, elastic moduli, boxes that do not fit."""

import numpy as np
import pytest

from tests.every import every
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice

REACH = ("nearest neighbours", "second neighbours", "third neighbours")


def block(kind, cells, reach=REACH[0], cell=1.0):
    size = cell * np.array(cells, dtype=float)
    return Lattice(kind, cell, (np.zeros(3), size), reach)


@pytest.mark.parametrize(
    ("kind", "nodes", "springs"),
    [
        # grid nodes and edges of 2 x 3 x 4 cells
        ("sodium chloride", 60, 2 * 4 * 5 + 3 * 3 * 5 + 4 * 3 * 4),
        # and centres, 8 springs each; 8 corners with one spring are tied by 3 edges each
        ("caesium chloride", 84, 8 * 24 + 24),
        # 8 in each cell and more on the faces; 4 springs for each of the 96 in fourth
        # positions, and ties: 3 at each of 8 corners, 5 at each of 4 * (1 + 2 + 3) nodes along
        # the edges
        # edges as in sodium chloride, and 4 diagonals in 12 of 24 cells
        ("braced cubes", 60, 133 + 4 * 12),
        ("diamond", 60 + 3 * 3 * 4 + 4 * 2 * 4 + 5 * 2 * 3 + 96, 4 * 96 + 24 + 120),
    ],
)
def test_counts_of_small_blocks(kind, nodes, springs):
    mesh = block(kind, (2, 3, 4)).build()
    assert (len(mesh.position), len(mesh.ends)) == (nodes, springs)


@pytest.mark.parametrize("kind", CRYSTALS)
@pytest.mark.parametrize("shell", range(3))
def test_inner_nodes_have_the_neighbours_of_the_crystal(kind, shell):
    mesh = block(kind, (4, 4, 4), REACH[shell]).build()
    degree = np.bincount(mesh.ends.ravel())
    inner = ((mesh.position > 0.99) & (mesh.position < 3.01)).all(axis=1)
    assert inner.sum() > 20
    assert (degree[inner] == sum(CRYSTALS[kind].neighbours[: shell + 1])).all()


@pytest.mark.parametrize("kind", CRYSTALS)
def test_only_nodes_on_edges_of_the_block_are_tied(kind):
    """Longer springs than the nearest start where fewer than two nearest ones were left."""
    mesh = block(kind, (3, 3, 3)).build()
    ends = mesh.position[mesh.ends]
    squared = ((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)
    is_brace = CRYSTALS[kind].braced & (squared > 2.9)
    is_tie = ~is_brace & (squared > 1.01 * squared.min())
    faces = ((mesh.position == 0.0) | (mesh.position == 3.0)).sum(axis=1)
    assert (faces[mesh.ends[is_tie]].max(axis=1) >= 2).all()
    nearest = np.bincount(mesh.ends[~is_tie].ravel(), minlength=len(mesh.position))
    tied = np.bincount(mesh.ends[is_tie].ravel(), minlength=len(mesh.position))
    assert (tied[nearest < 2] >= 3).all()
    if kind in ("sodium chloride", "braced cubes"):
        assert not is_tie.any()


@pytest.mark.parametrize("kind", CRYSTALS)
def test_nodes_lie_exactly_on_every_face_and_corner(kind):
    low, high = np.array([0.1, -0.3, 0.7]), np.array([0.1 + 0.7, -0.3 + 1.1, 0.7 + 0.3])
    position = Lattice(kind, 0.1, (high, low)).build().position
    assert np.array_equal(position.min(axis=0), low)
    assert np.array_equal(position.max(axis=0), high)
    corners = ((position == low) | (position == high)).all(axis=1)
    assert corners.sum() == 8
    for axis in range(3):
        for face in (low, high):
            on_face = position[:, axis] == face[axis]
            inside = on_face & ((position > low) & (position < high)).sum(axis=1).astype(bool)
            assert inside.sum() > 4


def moduli(kind, reach, second_stiffness=1.0):
    """Return C11, C12, C44 of the bulk in units of k/a, from homogeneous strain of a period.

    C_ijkl = (1/V) sum k r_i r_j r_k r_l / r^2 over the springs whose middle is in the cell,
    less what the second sublattice gains by shifting against the first.
    """
    mesh = block(kind, (4, 4, 4), reach).build()
    first, second = mesh.position[mesh.ends].transpose(1, 0, 2)
    middle = (first + second) / 2.0  # multiples of 1/8: exact, so each spring is in one cell
    period = CRYSTALS[kind].period
    in_cell = ((middle >= 1.0) & (middle < 1.0 + period)).all(axis=1)
    first, reach_vector = first[in_cell], (second - first)[in_cell]
    squared = (reach_vector**2).sum(axis=1)
    stiffness = np.where(squared > 1.01 * squared.min(), second_stiffness, 1.0)
    unit = reach_vector / np.sqrt(squared)[:, None]
    strained = np.einsum("s,si,sj->sij", np.sqrt(squared), unit, unit)
    bulk = np.einsum("s,sij,skl->ijkl", stiffness, strained, strained)
    steps = CRYSTALS[kind].divisions

    def sublattice(site):
        """0 at cell corners and, in diamond, face centres; of braced cubes, every other one."""
        fine = np.rint(steps * site).astype(int)
        if period > 1:
            return fine.sum(axis=1) % 2
        return fine[:, 0] % 2 if steps > 1 else 0 * fine[:, 0]

    shift = sublattice(first + reach_vector) - sublattice(first)
    inner = np.einsum("s,s,si,sj->ij", stiffness, shift**2.0, unit, unit)
    coupling = np.einsum("s,s,si,sjk->ijk", stiffness, shift, unit, strained)
    relaxed = bulk - np.einsum("aij,ab,bkl->ijkl", coupling, np.linalg.pinv(inner), coupling)
    return tuple(relaxed[i] / period**3 for i in ((0, 0, 0, 0), (0, 0, 1, 1), (0, 1, 0, 1)))


@every(
    ("kind", "reach", "expected"),
    [
        ("sodium chloride", REACH[0], (1, 0, 0)),
        ("sodium chloride", REACH[1], (3, 1, 1)),
        ("sodium chloride", REACH[2], (13 / 3, 7 / 3, 7 / 3)),
        ("caesium chloride", REACH[0], (2 / 3, 2 / 3, 2 / 3)),
        ("caesium chloride", REACH[1], (8 / 3, 2 / 3, 2 / 3)),
        ("diamond", REACH[0], (1 / 3, 1 / 3, 0)),
        ("braced cubes", REACH[0], (5 / 3, 2 / 3, 2 / 5)),
        ("braced cubes", REACH[2], (13 / 3, 7 / 3, 7 / 3)),
    ],
)
def test_elastic_moduli_are_those_of_the_crystal(kind, reach, expected):
    assert moduli(kind, reach) == pytest.approx(expected, abs=1e-12)


def test_caesium_chloride_is_isotropic_when_edges_have_two_thirds_of_the_stiffness():
    c11, c12, c44 = moduli("caesium chloride", REACH[1], second_stiffness=2 / 3)
    assert c11 - c12 == pytest.approx(2 * c44, rel=1e-12)


def test_braced_cubes_are_isotropic_when_diagonals_have_half_as_much_again():
    c11, c12, c44 = moduli("braced cubes", REACH[0], second_stiffness=3 / 2)
    assert (c11, c12, c44) == pytest.approx((2, 1, 1 / 2), rel=1e-12)


def test_diagonals_of_braced_cubes_lead_to_the_corners_of_a_tetrahedron():
    mesh = block("braced cubes", (4, 4, 4)).build()
    node = int(np.flatnonzero((mesh.position == 2.0).all(axis=1))[0])
    at = mesh.ends[(mesh.ends == node).any(axis=1)]
    ways = mesh.position[at].sum(axis=1) - 2.0 * mesh.position[node]
    diagonals = ways[np.abs(ways).sum(axis=1) == 3.0]
    assert len(at) == 10 and len(diagonals) == 4
    # Those of the four cells with an even sum that meet there: (2, 2, 2), (1, 1, 2) and so on.
    assert np.array_equal(np.unique(np.prod(diagonals, axis=1)), [1.0])
    assert np.array_equal(diagonals.sum(axis=0), np.zeros(3))


def test_braced_cubes_have_the_cells_and_the_surface_of_cubes():
    braced, plain = (block(kind, (3, 2, 2)) for kind in ("braced cubes", "sodium chloride"))
    for one, other in zip(braced.cell_nodes(), plain.cell_nodes(), strict=True):
        assert np.array_equal(one, other)
    assert np.array_equal(braced.build().skin, plain.build().skin)


@pytest.mark.parametrize(
    ("cell", "size", "message"),
    [
        (0.003, (0.04, 0.04, 0.02), r'"box" is 40 mm long in x.*39 mm or 42 mm would fit'),
        (
            0.0025,
            (0.04, 0.0401, 0.02),
            r'"box" is 40.1 mm long in y.*40 mm or 42.5 mm would fit',
        ),
        (0.0025, (0.04, 0.04, 0.001), r'"box" is 1 mm long in z.*\); 2.5 mm would fit'),
        (0.0025, (0.04, 0.04, 0.0), r'"box" is 0 m long in z.*\); 2.5 mm would fit'),
    ],
)
def test_a_box_that_holds_no_whole_number_of_cells_is_refused_with_sizes_that_fit(
    cell, size, message
):
    with pytest.raises(ValueError, match=message):
        Lattice("diamond", cell, (np.zeros(3), np.array(size)))


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_rounding_of_coordinates_does_not_unfit_a_box(unit, offset):
    low = np.array([0.1, 0.2, 0.3]) * unit + offset * unit
    high = low + np.array([0.7, 0.9, 1.1]) * unit
    assert Lattice("sodium chloride", 0.1 * unit, (low, high)).cells() == (7, 9, 11)


def test_size_does_not_build():
    nodes, springs = block("diamond", (100_000, 100_000, 100_000)).size()
    assert nodes > 8e15 and springs > 16e15
