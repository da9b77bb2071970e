"""What frames draw, above all after a cut."""

import numpy as np
import pytest

from tests.geometry.surfaces.conftest import across, build, network_of
from tissuec.results.mesh import RecordedMesh


def everything(network):
    return RecordedMesh.of(
        network, np.arange(network.node_count), np.arange(network.line_count)
    )


def test_a_whole_network_is_drawn_whole(example):
    network = example.network
    cells = everything(network).cells(example.alive(0))
    assert np.array_equal(cells.lines, network.springs.ends)
    assert np.array_equal(cells.triangles, network.skin)
    assert np.array_equal(cells.line_numbers, np.arange(network.spring_count))
    assert len(cells.vertices) == 0


def test_a_cut_opens_the_skin_along_the_cut_springs_only(example):
    network = example.network
    cells = everything(network).cells(example.alive(20))
    rings = np.sort(cells.triangles, axis=1) // 4  # ring of each corner
    across = (rings.min(axis=1) == 1) & (rings.max(axis=1) == 2)
    assert not across.any()
    assert len(cells.triangles) == len(network.skin) - 8  # two per side between two rings
    gone = set(range(network.spring_count)) - set(cells.line_numbers.tolist())
    assert gone == set(example.along)


def test_a_triangle_stays_while_a_parallel_spring_lives(example):
    network = example.network
    doubled = np.concatenate([network.springs.ends, network.springs.ends[:1, ::-1]])
    parts = {name: np.append(network.array(name), 1.0) for name in ("rest", "stiffness")}
    twin = network.with_arrays({"ends": doubled, **parts})
    alive = np.ones(len(doubled), dtype=bool)
    alive[0] = False
    mesh = RecordedMesh.of(twin, np.arange(network.node_count), np.arange(len(doubled)))
    assert len(mesh.cells(alive).triangles) == len(network.skin)
    alive[-1] = False
    assert len(mesh.cells(alive).triangles) < len(network.skin)


def test_a_part_is_numbered_by_itself_and_keeps_its_own_skin(example):
    network = example.network
    nodes = np.arange(4, 12)  # rings 1 and 2
    springs = np.flatnonzero(np.isin(network.springs.ends, nodes).all(axis=1))
    cells = RecordedMesh.of(network, nodes, springs).cells(example.alive(0))
    assert np.array_equal(nodes[cells.lines], network.springs.ends[springs])
    assert len(cells.triangles) == 8
    assert cells.triangles.max() < len(nodes)


def test_nodes_without_spring_or_skin_are_drawn_as_vertices(example):
    network = example.network
    alive = example.alive(0)
    alive[-2:] = False
    assert everything(network).cells(alive).vertices.ravel().tolist() == [20, 21, 22]


@pytest.mark.parametrize(
    ("nodes", "springs", "message"),
    [
        ([0, 99], [], "less than 23"),
        ([3, 1], [], "must ascend"),
        ([1, 1], [], "must ascend"),
        ([-1, 1], [], "must ascend"),
        ([0, 1], [0, 5], "not both of its ends"),
    ],
)
def test_recordings_that_do_not_fit_are_refused(example, nodes, springs, message):
    with pytest.raises(ValueError, match=message):
        RecordedMesh.of(example.network, np.array(nodes), np.array(springs, dtype=int))


@pytest.mark.parametrize("kind", ["caesium chloride", "diamond"])
def test_a_skin_whose_edges_are_no_springs_tears_with_the_springs_behind_it(kind):
    box = (np.zeros(3), np.array([0.02, 0.02, 0.05]))
    mesh = build("lattice", kind=kind, cell=0.01, box=box)
    network = network_of(mesh)
    below = mesh.position[:, 2] < 0.0251
    alive = ~across(mesh, below, ~below)
    drawn = everything(network)
    assert len(drawn.cells(np.ones(len(alive), dtype=bool)).triangles) == len(mesh.skin)
    left = drawn.cells(alive).triangles
    assert (below[left] == below[left][:, :1]).all()
    # Only what spanned the cut is gone, and there was some.
    spanning = ~(below[mesh.skin] == below[mesh.skin][:, :1]).all(axis=1)
    assert 0 < spanning.sum() == len(mesh.skin) - len(left)
