"""Solutions of S + L Rᵀ with a sparse S and few columns in L and R (M. A. Woodbury, 1950)."""

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from tissuec.model.network import Floats


class LowRankFactor:
    """S + L Rᵀ, factorised.

    Args:
        matrix: S in any unit, shape (n, n).
        left, right: L and R, shape (n, column); without columns, S alone is solved.
        options: Of ``scipy.sparse.linalg.splu``.

    Raises:
        RuntimeError: S is singular.
    """

    def __init__(self, matrix: sparse.csc_matrix, left: Floats, right: Floats, **options: Any):
        self._factor, self._right = splu(matrix, **options), right
        self._is_wide = right.shape[1] > 0
        self._spread = self._factor.solve(left) if self._is_wide else left
        self._schur = np.eye(right.shape[1]) + right.T @ self._spread

    @property
    def soundness(self) -> float:
        """Return the smallest pivot of S as a part of the largest."""
        pivots = np.abs(self._factor.U.diagonal())
        return float(pivots.min() / pivots.max())

    def solve(self, vectors: Floats) -> Floats:
        """Return the inverse times vectors in any unit, shape (n,) or (n, vector)."""
        found = self._factor.solve(vectors)
        if not self._is_wide:
            return found
        return found - self._spread @ np.linalg.solve(self._schur, self._right.T @ found)

    def solve_transposed(self, vector: Floats) -> Floats:
        """Return the transposed inverse times a vector in any unit, shape (n,)."""
        if self._is_wide:
            # Sᵀ y + R z = b with z = Lᵀ y, so that z = Lᵀ S⁻ᵀ (b - R z).
            z = np.linalg.solve(self._schur.T, self._spread.T @ vector)
            vector = vector - self._right @ z
        return np.asarray(self._factor.solve(vector, "T"), dtype=float)  # pyright: ignore[reportCallIssue]  # the stub knows "N" only
