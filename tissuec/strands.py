"""Strands: springs side by side along one edge, which tears when the last of them is gone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tissuec.network import Indices


@dataclass(frozen=True, slots=True, eq=False)
class Strands:
    """The strands of a network, numbered by the node pairs that they join.

    Attributes:
        keys: One number for each pair of nodes that springs join, ascending, shape (strand,).
        of_spring: The strand of each spring, shape (spring,).
    """

    keys: Indices
    of_spring: Indices

    @classmethod
    def of(cls, ends: NDArray[np.integer]) -> "Strands":
        """Return the strands of springs with these ends, shape (spring, 2)."""
        keys, of_spring = np.unique(_edge_keys(ends), return_inverse=True)
        return cls(keys, of_spring.reshape(-1))

    def along(self, edges: NDArray[np.integer]) -> Indices:
        """Return the strand along each edge or -1, shape (…); edges are pairs (…, 2)."""
        wanted = _edge_keys(edges)
        if not len(self.keys):
            return np.full(wanted.shape, -1, dtype=np.int64)
        found = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        return np.where(self.keys[found] == wanted, found, -1)

    def holding(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which strands hold, shape (strand + 1,).

        The entry behind the last, which is that of -1, is true: where no spring ever was,
        nothing tears.

        Args:
            alive: Which springs are there, shape (spring,).
        """
        count = np.bincount(self.of_spring[alive], minlength=len(self.keys) + 1)
        count[-1] = 1
        return count > 0


def _edge_keys(ends: NDArray[np.integer]) -> Indices:
    """Return one number per unordered node pair of the last axis."""
    pairs = np.sort(np.asarray(ends, dtype=np.int64), axis=-1)
    return (pairs[..., 0] << 32) | pairs[..., 1]
