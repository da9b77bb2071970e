"""The sheet: any plane, exact corners, bending springs."""

import numpy as np
import pytest

from tissuec.meshes.generators.sheet import Sheet

CORNER = np.array([1.0, 2.0, 3.0])
FIRST, SECOND = np.array([0.3, 0.0, 0.4]), np.array([0.1, 0.6, 0.0])


def sheet(**entries):
    given = {"corner": CORNER, "first_edge": FIRST, "second_edge": SECOND}
    return Sheet(**given | {"columns": 7, "rows": 4} | entries)


def test_corners_are_where_they_were_drawn():
    position = sheet().build().position.reshape(4, 7, 3)
    assert np.array_equal(position[0, 0], CORNER)
    assert position[0, -1] == pytest.approx(CORNER + FIRST, abs=1e-15)
    assert position[-1, 0] == pytest.approx(CORNER + SECOND, abs=1e-15)
    assert position[-1, -1] == pytest.approx(CORNER + FIRST + SECOND, abs=1e-15)


def test_the_skin_has_the_area_of_the_parallelogram_and_faces_along_the_cross_product():
    mesh = sheet().build()
    a, b, c = mesh.position[mesh.skin].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a) / 2.0
    assert normal.sum(axis=0) == pytest.approx(np.cross(FIRST, SECOND), rel=1e-12)
    assert np.linalg.norm(normal, axis=1).sum() == pytest.approx(
        np.linalg.norm(np.cross(FIRST, SECOND)), rel=1e-12
    )


def test_second_neighbours_span_two_cells_along_rows_and_columns():
    def drawn(option):
        return {tuple(p) for p in sheet(second_neighbours=option).build().ends.tolist()}

    expected = {(7 * row + c, 7 * row + c + 2) for row in range(4) for c in range(5)}
    expected |= {(7 * row + c, 7 * (row + 2) + c) for row in range(2) for c in range(7)}
    assert drawn("yes") - drawn("no") == expected


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"second_edge": 2.0 * FIRST}, "must not be parallel"),
        ({"second_edge": -1e-6 * FIRST}, "must not be parallel"),
        ({"first_edge": np.zeros(3)}, '"first edge" must have a length'),
    ],
)
def test_edges_that_span_no_plane_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        sheet(**options)
