"""Triangles that are found by their corners."""

import numpy as np
from numpy.typing import NDArray

_Indices = NDArray[np.int64]


class TriangleIndex:
    """Finds triangles by their corners in any order.

    Args:
        triangles: Nodes, fewer than two million, shape (triangle, 3).
    """

    def __init__(self, triangles: NDArray[np.integer]):
        self._keys = _keys(triangles)
        self._order = np.argsort(self._keys)

    def find(self, triangles: NDArray[np.integer]) -> _Indices:
        """Return the index of each triangle, -1 for one that is absent.

        Args:
            triangles: Nodes, shape (n, 3).

        Returns:
            Indices, shape (n,).
        """
        if not len(self._keys):
            return np.full(len(triangles), -1)
        wanted = _keys(triangles)
        place = np.searchsorted(self._keys, wanted, sorter=self._order)
        place = self._order[np.minimum(place, len(self._keys) - 1)]
        return np.where(self._keys[place] == wanted, place, -1)


def _keys(triangles: NDArray[np.integer]) -> _Indices:
    low, middle, high = np.sort(triangles.astype(np.int64), axis=1).T
    return (low << 42) | (middle << 21) | high
