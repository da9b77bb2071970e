"""Pieces against SciPy, and floppy modes against ranks and counts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tests.every import every
from tests.growth import grows_in_proportion
from tissuec.meshes.generators import MESHES
from tissuec.model.topology import (
    LARGEST_CHECK,
    FloppyModes,
    extents,
    floppy_modes,
    pieces,
)


@st.composite
def nets(draw):
    node_count = draw(st.integers(1, 30))
    node = st.integers(0, node_count - 1)
    pairs = draw(st.lists(st.tuples(node, node), max_size=40))
    ends = sorted({(min(p), max(p)) for p in pairs if p[0] != p[1]})
    alive = draw(st.lists(st.booleans(), min_size=len(ends), max_size=len(ends)))
    return (
        node_count,
        np.array(ends, dtype=np.int32).reshape(-1, 2),
        np.array(alive, dtype=bool),
    )


@given(nets())
def test_pieces_are_the_connected_components(net):
    node_count, ends, alive = net
    labels = pieces(node_count, ends, alive)
    one, other = ends[alive].T
    graph = coo_array((np.ones(len(one)), (one, other)), shape=(node_count, node_count))
    # SciPy, too, numbers components by their lowest node.
    assert np.array_equal(labels, connected_components(graph, directed=False)[1])


def orders(count):
    numbers = np.arange(count)
    zigzag = np.empty(count, dtype=int)
    zigzag[::2], zigzag[1::2] = numbers[: (count + 1) // 2], numbers[(count + 1) // 2 :]
    shuffled = np.random.default_rng(7).permutation(count)
    return {
        "ascending": numbers,
        "descending": numbers[::-1],
        "zigzag": zigzag,
        "any": shuffled,
    }


@pytest.mark.parametrize("order", ["ascending", "descending", "zigzag", "any"])
def test_a_chain_of_any_order_takes_few_rounds(order):
    def work(count):
        chain = orders(count)[order]
        ends = np.stack((chain[:-1], chain[1:]), axis=1).astype(np.int32)
        alive = np.ones(len(ends), dtype=bool)
        alive[3 * count // 5] = False
        return chain, lambda: pieces(len(chain), ends, alive)

    # Some 20 rounds; a round for each node would be the square.
    assert grows_in_proportion(lambda count: work(count)[1], 100_000)
    chain, parted = work(100_000)
    labels = parted()
    assert len(np.unique(labels[chain[:60_001]])) == len(np.unique(labels[chain[60_001:]])) == 1
    assert labels.max() == 1


def test_extents_hold_every_node():
    box = extents(np.array([[0.0, 5.0, -1.0], [3.0, 1.0, -1.0]]))
    assert box.low.tolist() == [0.0, 1.0, -1.0] and box.high.tolist() == [3.0, 5.0, -1.0]
    assert box.diagonal == 5.0


# --- floppy modes -----------------------------------------------------------------------------


def net(kind, *values, **entries):
    mesh = MESHES[kind](*values, **entries).build()
    return mesh.position, mesh.ends


def table(position, ends):
    return np.array(position, dtype=float), np.array(ends, dtype=np.int32).reshape(-1, 2)


def lengths(position, ends):
    return np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)


def modes(position, ends, *, prestress=0.0, held=(), stiffness=None):
    rest = (1.0 - prestress) * lengths(position, ends)
    fixed = np.zeros(len(position), dtype=bool)
    fixed[list(held)] = True
    constants = np.ones(len(ends)) if stiffness is None else stiffness
    return floppy_modes(position, ends, constants, rest, fixed)


def lattice(kind, size, reach="nearest neighbours"):
    return net("lattice", kind, 1.0, (np.zeros(3), np.full(3, float(size))), reach)


def tube(**options):
    axis = (np.zeros(3), np.array([0.064, 0.0, 0.0]))
    return net("tube", axis, 0.003, **{"rings": 6, "sides": 10} | options)


SQUARE = table([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1], [1, 2], [2, 3], [0, 3]])
TRIANGLE = table([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1], [1, 2], [0, 2]])
CHAIN = table([[i, 0, 0] for i in range(6)], [[i, i + 1] for i in range(5)])
TWO_SQUARES = table(
    np.concatenate((SQUARE[0], SQUARE[0][:, [2, 0, 1]] + 5.0)),
    np.concatenate((SQUARE[1], SQUARE[1] + 4)),
)


@every(
    ("drawn", "options", "expected"),
    [
        (TRIANGLE, {}, (0, 0, 6)),
        (SQUARE, {}, (1, 1, 6)),  # shears within its plane, folds out of it
        (SQUARE, {"prestress": 0.1}, (0, 0, 6)),
        (SQUARE, {"prestress": -0.1}, (1, 1, 6)),  # compression holds nothing
        (SQUARE, {"held": [0]}, (1, 1, 3)),
        (SQUARE, {"held": [0, 1]}, (1, 1, 1)),  # the rigid one swings about the held edge
        (SQUARE, {"held": [0, 1, 2]}, (0, 0, 1)),  # node 3 swings about its two neighbours
        (SQUARE, {"held": [0, 1, 2, 3]}, (0, 0, 0)),
        (SQUARE, {"stiffness": np.array([1.0, 1.0, 1.0, 0.0])}, (2, 1, 6)),
        (TWO_SQUARES, {}, (2, 2, 12)),  # two pieces in two planes
        (CHAIN, {}, (0, 8, 5)),
        (CHAIN, {"held": [0]}, (0, 8, 2)),
        (CHAIN, {"held": [0, 5]}, (0, 8, 0)),
        (CHAIN, {"held": [0, 5], "prestress": 0.1}, (0, 0, 0)),
        (CHAIN, {"held": [2]}, (0, 6, 4)),  # both arms swing about the held node
        (table([[1, 2, 3]], []), {}, (0, 0, 3)),
        (table([[0, 0, 0], [1, 0, 0]], [[0, 1]]), {}, (0, 0, 5)),
        (table([[0, 0, 0], [0, 0, 0]], [[0, 1]]), {}, (0, 0, 6)),  # zero length joins nothing
    ],
)
def test_small_nets_have_the_modes_counted_by_hand(drawn, options, expected):
    count, across, rigid = expected
    assert modes(*drawn, **options) == FloppyModes(count, across, rigid, checked=True)


SOLIDS = {
    "cubic": lattice("sodium chloride", 3),
    "cubic, face diagonals": lattice("sodium chloride", 3, "second neighbours"),
    "body-centred": lattice("caesium chloride", 3),
    "body-centred, edges": lattice("caesium chloride", 3, "second neighbours"),
    "braced": lattice("braced cubes", 3),
    "diamond": lattice("diamond", 2),
    "diamond, second": lattice("diamond", 2, "second neighbours"),
    "tube": tube(),
    "tube, diagonals": tube(diagonals="both"),
    "tube, crossed": tube(interior="crossed"),
    "tube, spokes": tube(interior="spokes", sides=7),
    "sphere": net("sphere", np.zeros(3), 1.0, 1),
}


@every("name", SOLIDS)
def test_unstressed_counts_follow_from_the_rank_of_the_rigidity_matrix(name):
    position, ends = SOLIDS[name]
    rows = np.zeros((len(ends), len(position), 3))
    spring, reach = np.arange(len(ends)), position[ends[:, 1]] - position[ends[:, 0]]
    rows[spring, ends[:, 0]], rows[spring, ends[:, 1]] = -reach, reach
    rank = np.linalg.matrix_rank(rows.reshape(len(ends), -1), tol=1e-9 * np.abs(reach).max())
    expected = 3 * len(position) - int(rank) - 6
    assert modes(position, ends) == FloppyModes(expected, 0, 6, checked=True)


@pytest.mark.parametrize(
    "kind", ["sodium chloride", "caesium chloride", "diamond", "braced cubes"]
)
def test_lattices_are_floppy_until_second_neighbours_or_prestress_hold_them(kind):
    assert modes(*lattice(kind, 2)).count > 6
    assert modes(*lattice(kind, 2, "second neighbours")).count == 0
    assert modes(*lattice(kind, 2), prestress=0.02).count == 0


def test_a_closed_triangulated_convex_surface_is_rigid():
    """Cauchy's theorem, in Dehn's form for infinitesimal motions."""
    for subdivisions in (0, 1, 2):
        drawn = net("sphere", np.zeros(3), 1.0, subdivisions)
        assert modes(*drawn) == FloppyModes(0, 0, 6, checked=True)


def test_the_softest_bending_of_a_long_truss_is_not_taken_for_a_floppy_mode():
    axis = (np.zeros(3), np.array([132.0, 0.0, 0.0]))
    mast = net("tube", axis, 0.1, 133, 3, diagonals="one")
    assert modes(*mast) == FloppyModes(0, 0, 6, checked=True)


def test_a_triangulated_sheet_bends_but_does_not_shear():
    edges = (np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    assert modes(*net("sheet", *edges, 6, 5, "one")) == FloppyModes(0, 27, 6, checked=True)
    # Without diagonals, each row and each column but one may slide.
    assert modes(*net("sheet", *edges, 6, 5, "none")).count == 5 + 4 - 1


def random_turn(seed):
    matrix, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return matrix * np.sign(np.linalg.det(matrix))


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize("drawn", [*SOLIDS.values(), SQUARE, CHAIN, TWO_SQUARES])
def test_counts_do_not_depend_on_place_direction_and_scale(drawn, scale):
    position, ends = drawn
    for seed in range(3):
        moved = scale * (position @ random_turn(seed).T + [3.0, -5.0, 7.0])
        assert modes(moved, ends) == modes(position, ends)
        assert modes(moved, ends, held=[0, 1]) == modes(position, ends, held=[0, 1])


@every("drawn", [SQUARE, TRIANGLE, CHAIN, *SOLIDS.values()])
def test_counts_do_not_depend_on_coordinates_in_single_precision(drawn):
    position, ends = drawn
    turned = position @ random_turn(5).T
    assert modes(turned.astype(np.float32).astype(float), ends) == modes(position, ends)


@every("name", SOLIDS)
def test_counts_do_not_depend_on_stiffness_ratios(name):
    position, ends = SOLIDS[name]
    stiffness = 10.0 ** np.random.default_rng(3).uniform(-6, 6, len(ends))
    assert modes(position, ends, stiffness=stiffness) == modes(position, ends)


def test_a_prestressed_net_is_held_exactly_where_its_stiffness_matrix_says():
    """Some springs taut, some compressed: count zero eigenvalues of the matrix itself."""
    position, ends = SOLIDS["cubic"]
    generator = np.random.default_rng(11)
    for share in (0.0, 0.05, 0.1, 0.2, 0.4):
        length = lengths(position, ends)
        rest = length * np.where(generator.random(len(ends)) < share, 0.9, 1.05)
        matrix = np.zeros((len(position), 3, len(position), 3))
        for (a, b), full, relaxed in zip(ends, length, rest, strict=True):
            unit = (position[b] - position[a]) / full
            along = np.outer(unit, unit)
            block = along + max(full - relaxed, 0.0) / full * (np.eye(3) - along)
            for one, other, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                matrix[one, :, other, :] += sign * block
        turn = np.cross(np.eye(3), position[:, None, :])
        motions = np.concatenate((np.tile(np.eye(3), (len(position), 1, 1)), turn), axis=1)
        rigid = motions.transpose(0, 2, 1).reshape(-1, 6)
        size = 3 * len(position)
        values = np.linalg.eigvalsh(matrix.reshape(size, size) + rigid @ rigid.T)
        expected = int((values < 1e-9).sum())
        fixed = np.zeros(len(position), dtype=bool)
        found = floppy_modes(position, ends, np.ones(len(ends)), rest, fixed)
        assert found == FloppyModes(expected, 0, 6, checked=True)


def test_large_nets_are_not_checked_unless_enough_is_held():
    position, ends = lattice("sodium chloride", 7)
    assert 3 * len(position) > LARGEST_CHECK
    assert modes(position, ends) == FloppyModes(0, 0, 0, checked=False)
    held = range(len(position) - 100)
    assert modes(position, ends, held=held).checked
