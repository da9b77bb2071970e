"""Triangles are found by their corners in any order."""

import numpy as np

from tissuec.geometry.edges import TriangleIndex


def test_triangles_are_found_in_any_order():
    triangles = np.array([[4, 1, 7], [0, 2, 1], [7, 4, 2]])
    wanted = np.array([[1, 0, 2], [2, 4, 7], [0, 1, 7], [7, 1, 4]])
    assert TriangleIndex(triangles).find(wanted).tolist() == [1, 2, -1, 0]


def test_nothing_is_found_among_no_triangles():
    none = np.zeros((0, 3), dtype=int)
    assert TriangleIndex(none).find(np.array([[0, 1, 2]])).tolist() == [-1]
    assert TriangleIndex(np.array([[0, 1, 2]])).find(none).tolist() == []
