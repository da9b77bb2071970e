"""Stiffness matrices K = S + W Wᵀ: S is sparse, W has a column for each large enclosed volume.

The pressure of a volume acts between all nodes of its surface and would fill a sparse matrix.
Solutions follow from those of S (M. A. Woodbury, 1950), and so do signs of eigenvalues: by the
inertia of [[S, W], [Wᵀ, -1]], K has as many negative ones as S, less those of the Schur
complement 1 + Wᵀ S⁻¹ W (E. V. Haynsworth, Linear Algebra Appl. 1:73, 1968).
"""

import numpy as np
from msgspec import Struct
from scipy.sparse import csc_matrix, diags_array

from tissuec.mechanics.low_rank import LowRankFactor
from tissuec.model.network import Floats


class Stiffness(Struct, frozen=True, eq=False):
    """K = S + W Wᵀ.

    Attributes:
        sparse: S [N/m], shape (n, n).
        wide: W [(N/m)^½], shape (n, column).
    """

    sparse: csc_matrix
    wide: Floats

    def __call__(self, vector: Floats) -> Floats:
        """Return K u, shape of u: (n,) or (n, vector)."""
        return self.sparse @ vector + self.wide @ (self.wide.T @ vector)

    def diagonal(self) -> Floats:
        """Return the diagonal of K [N/m], shape (n,)."""
        return self.sparse.diagonal() + (self.wide * self.wide).sum(axis=1)

    def toarray(self) -> Floats:
        """Return K [N/m], shape (n, n)."""
        return self.sparse.toarray() + self.wide @ self.wide.T

    def plus(self, added: Floats) -> "Stiffness":
        """Return this with more on its diagonal.

        Args:
            added: [N/m], shape (n,).
        """
        return Stiffness(csc_matrix(self.sparse + diags_array(added, format="csc")), self.wide)


class Factorization(LowRankFactor):
    """K⁻¹, by a factorisation of S in which no rows are exchanged.

    Raises:
        RuntimeError: S is singular.
    """

    def __init__(self, matrix: Stiffness):
        symmetric = {"SymmetricMode": True, "DiagPivotThresh": 0.0}
        wide = matrix.wide
        order = {"permc_spec": "MMD_AT_PLUS_A", "options": symmetric}
        super().__init__(matrix.sparse, wide, wide, **order)

    @property
    def is_definite(self) -> bool:
        """Return whether K is positive definite, by the signs of pivots."""
        factor = self._factor
        if not np.array_equal(factor.perm_r, factor.perm_c):
            return False  # rows were exchanged, so that signs say nothing
        negative = int((factor.U.diagonal() <= 0.0).sum())
        return negative == int((np.linalg.eigvalsh(self._schur) < 0.0).sum())
