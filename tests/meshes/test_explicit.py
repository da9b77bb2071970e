"""Nets typed in as tables: kept as they are, or refused with the row at fault."""

import numpy as np
import pytest

from tissuec.meshes.generators.explicit import ExplicitMesh, TableError

POSITION = np.arange(12.0).reshape(4, 3)


def test_rows_keep_their_order_and_the_lower_node_comes_first():
    mesh = ExplicitMesh(POSITION, np.array([[3, 1], [0, 2], [2, 1]])).build()
    assert mesh.ends.tolist() == [[1, 3], [0, 2], [1, 2]]
    assert np.array_equal(mesh.position, POSITION)
    assert mesh.position is not POSITION


def test_two_springs_may_join_the_same_nodes():
    mesh = ExplicitMesh(POSITION, np.array([[0, 1], [1, 0]])).build()
    assert mesh.ends.tolist() == [[0, 1], [0, 1]]


@pytest.mark.parametrize("nothing", [np.empty((0, 2), dtype=np.int32), np.empty((0, 2))])
def test_a_net_may_have_no_springs(nothing):
    mesh = ExplicitMesh(POSITION, nothing).build()
    assert mesh.ends.shape == (0, 2) and mesh.ends.dtype == np.int32


@pytest.mark.parametrize(
    ("ends", "row", "message"),
    [
        ([[0, 1], [1, 4]], 1, "row 2 of the table of springs names a node outside 0 to 3"),
        ([[0, 1], [-1, 2]], 1, "names a node outside"),
        ([[0, 1], [1, 2], [2, 2]], 2, "row 3 .* joins a node to itself"),
    ],
)
def test_an_impossible_spring_is_refused_with_its_row(ends, row, message):
    with pytest.raises(TableError, match=message) as refused:
        ExplicitMesh(POSITION, np.array(ends))
    found = refused.value
    assert (found.table, found.row) == ("springs", row)


def test_a_coordinate_that_is_not_finite_is_refused_with_its_row():
    position = POSITION.copy()
    position[2, 1] = np.nan
    with pytest.raises(TableError, match="row 3 of the table of nodes") as refused:
        ExplicitMesh(position, np.empty((0, 2), dtype=np.int32))
    assert (refused.value.table, refused.value.row) == ("nodes", 2)


@pytest.mark.parametrize(
    ("position", "ends", "entry"),
    [
        (np.zeros((0, 3)), np.empty((0, 2), dtype=np.int32), "position"),
        (np.zeros((4, 2)), np.array([[0, 1]]), "position"),
        (POSITION, np.array([[0, 1, 2]]), "ends"),
        (POSITION, np.array([[0.0, 1.0]]), "ends"),
    ],
)
def test_arrays_of_another_shape_are_refused(position, ends, entry):
    with pytest.raises(ValueError, match=f'"{entry}" must'):
        ExplicitMesh(position, ends)
