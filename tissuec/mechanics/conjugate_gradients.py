"""Solutions of large symmetric matrices without a factor, by conjugate gradients.

The inverses of the diagonal blocks of nodes are the preconditioner. (M. R. Hestenes, E.
Stiefel, J. Res. Nat. Bur. Stand. 49:409, 1952.)
"""

from typing import TYPE_CHECKING, cast

import numpy as np

from tissuec.mechanics.stiffness import Stiffness
from tissuec.model.network import Floats

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

PRECISION = 1e-3  # of the residual; the caller repeats this for the remainder
ROUNDS = 500


class ConjugateGradients:
    """K⁻¹, for right-hand sides one at a time.

    Args:
        matrix: K in any unit, three rows for each node.
    """

    def __init__(self, matrix: Stiffness):
        self._matrix = Stiffness(cast("csc_matrix", matrix.sparse.tocsr()), matrix.wide)
        count = matrix.sparse.shape[0] // 3
        entries = matrix.sparse.tocoo()
        own = entries.row // 3 == entries.col // 3
        block = np.zeros((count, 3, 3))
        row, column = entries.row[own], entries.col[own]
        np.add.at(block, (row // 3, row % 3, column % 3), entries.data[own])
        self.is_definite = bool((np.linalg.eigvalsh(block) > 0.0).all())
        self._inverse = np.linalg.inv(block) if self.is_definite else block

    def solve(self, vector: Floats) -> Floats:
        """Return K⁻¹ times a vector in any unit, shape (n,); NaN if that fails."""
        found, residual = np.zeros_like(vector), vector.copy()
        refined = self._refined(residual)
        search, product = refined.copy(), _inner(refined, residual)
        enough = PRECISION * PRECISION * product
        for _ in range(ROUNDS):
            if not product > enough:
                return found
            image = self._matrix(search)
            bent = _inner(search, image)
            if not bent > 0.0:
                break
            found += product / bent * search
            residual -= product / bent * image
            refined = self._refined(residual)
            before, product = product, _inner(refined, residual)
            search = refined + product / before * search
        return np.full_like(vector, np.nan)

    def _refined(self, vector: Floats) -> Floats:
        return np.einsum("nij,nj->ni", self._inverse, vector.reshape(-1, 3)).ravel()


def _inner(one: Floats, other: Floats) -> float:
    """Return the inner product; BLAS would add in an order that depends on its threads."""
    return float(np.add.reduce(one * other))
