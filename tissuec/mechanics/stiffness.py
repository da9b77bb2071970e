"""Stiffness matrices K = S + W Wᵀ, and solutions with them, by factors or without.

The pressure of a volume acts between all nodes of its surface and would fill a sparse matrix.
Solutions follow from those of S (M. A. Woodbury, 1950), and so do signs of eigenvalues: by the
inertia of [[S, W], [Wᵀ, -1]], K has as many negative ones as S, less those of the Schur
complement 1 + Wᵀ S⁻¹ W (E. V. Haynsworth, Linear Algebra Appl. 1:73, 1968).

Large systems are solved without a factor, by conjugate gradients (M. R. Hestenes, E. Stiefel,
J. Res. Nat. Bur. Stand. 49:409, 1952). Their preconditioner consists of the inverses of the
diagonal blocks of nodes.
"""

from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from msgspec import Struct
from scipy.sparse import csc_matrix, diags_array
from scipy.sparse.linalg import splu

from tissuec.core.signals import waiting_for
from tissuec.core.structs import replace
from tissuec.mechanics.dissection import EliminationOrder
from tissuec.mechanics.fronts import CholeskyFactor
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


LONG = 3000  # unknowns of factors during which signals are handled
DISSECTED = 1000  # unknowns from which nested dissection makes smaller factors
# Of SuperLU: the given order, and the widths of columns that it treats together, which are
# those of leaves of the dissection.
ORDERED: dict[str, Any] = {"permc_spec": "NATURAL", "relax": 20, "panel_size": 20}


class SparseFactor:
    """A factor of a sparse matrix, by SuperLU.

    Args:
        matrix: S in any unit, shape (n, n).
        order: In which unknowns are eliminated, shape (n,); None where SuperLU chooses it.
        options: Of ``scipy.sparse.linalg.splu``.

    Raises:
        RuntimeError: S is singular.
        Halted: A signal ended the run meanwhile.
    """

    def __init__(self, matrix: csc_matrix, order: Indices | None = None, **options: Any):
        if order is not None:
            matrix, options = csc_matrix(matrix[order][:, order]), {**options, **ORDERED}
        factor = partial(splu, matrix, **options)
        self._factor = waiting_for(factor) if matrix.shape[0] >= LONG else factor()
        self._order = order

    @cached_property
    def pivots(self) -> Floats:
        """Return the pivots in the unit of S, shape (n,)."""
        return self._factor.U.diagonal()

    @property
    def soundness(self) -> float:
        """Return the smallest pivot as a part of the largest."""
        size = np.abs(self.pivots)
        return float(size.min() / size.max())

    @property
    def exchanges_rows(self) -> bool:
        """Return whether rows were exchanged, so that signs of pivots say nothing."""
        return not np.array_equal(self._factor.perm_r, self._factor.perm_c)

    def solve(self, vectors: Floats, way: Literal["N", "T"] = "N") -> Floats:
        """Return S⁻¹, or with "T" its transpose, times vectors in any unit, shape of these."""
        solve = cast(Any, self._factor.solve)  # the stub knows "N" only
        if self._order is None:
            return np.asarray(solve(vectors, way), dtype=float)
        found = np.empty(vectors.shape)
        found[self._order] = solve(vectors[self._order], way)
        return found


class LowRankFactor:
    """S + L Rᵀ, factorised.

    Args:
        factor: Of S in any unit, shape (n, n).
        left, right: L and R, shape (n, column); without columns, S alone is solved.

    Attributes:
        schur: 1 + Rᵀ S⁻¹ L, shape (column, column).
    """

    def __init__(self, factor: "SparseFactor | CholeskyFactor", left: Floats, right: Floats):
        self._factor, self._right = factor, right
        self._is_wide = right.shape[1] > 0
        self._spread = factor.solve(left) if self._is_wide else left
        self.schur = np.eye(right.shape[1]) + right.T @ self._spread

    def solve(self, vectors: Floats) -> Floats:
        """Return the inverse times vectors in any unit, shape (n,) or (n, vector)."""
        found = self._factor.solve(vectors)
        if not self._is_wide:
            return found
        return found - self._spread @ np.linalg.solve(self.schur, self._right.T @ found)

    def solve_transposed(self, vector: Floats) -> Floats:
        """Return the transposed inverse times a vector in any unit, shape (n,)."""
        if self._is_wide:
            # Sᵀ y + R z = b with z = Lᵀ y, so that z = Lᵀ S⁻ᵀ (b - R z).
            z = np.linalg.solve(self.schur.T, self._spread.T @ vector)
            vector = vector - self._right @ z
        return self._factor.solve(vector, "T")


class Stiffness(Struct, frozen=True, eq=False):
    """K = S + W Wᵀ.

    Attributes:
        sparse: S [N/m], shape (n, n).
        wide: W [(N/m)^½], shape (n, column).
        elimination: Order for factors; None where SuperLU chooses it.
    """

    sparse: csc_matrix
    wide: Floats
    elimination: EliminationOrder | None = None

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
        if not added.any():
            return self
        total = csc_matrix(self.sparse + diags_array(added, format="csc"))
        return replace(self, sparse=total)

    def shift(self, added: Floats) -> "Stiffness":
        """Add to the diagonal of this matrix itself, which may be large, and return it.

        Args:
            added: [N/m], shape (n,).
        """
        self.sparse.setdiag(self.sparse.diagonal() + added)
        return self


class Factorization:
    """K⁻¹, by a factor of S in which no rows are exchanged.

    Large nets have Cholesky's factor if S is positive definite.

    Raises:
        RuntimeError: S is singular.
        Halted: A signal ended the run meanwhile.
    """

    repeats = True  # another solution costs little

    def __init__(self, matrix: Stiffness):
        self._matrix = matrix
        elimination, is_wide = matrix.elimination, matrix.wide.shape[1] > 0
        self._order = elimination if len(matrix.wide) >= DISSECTED else None
        cholesky = self._order and self._order.cholesky(matrix.sparse)
        self._cholesky: CholeskyFactor | None = cholesky
        if self._order is None or (self._cholesky is None and is_wide):
            _ = self._pivoted  # which may be singular

    @cached_property
    def _pivoted(self) -> SparseFactor:
        options = {"SymmetricMode": True, "DiagPivotThresh": 0.0}
        matrix = self._matrix.sparse
        order = self._order.of(matrix) if self._order is not None else None
        return SparseFactor(matrix, order, permc_spec="MMD_AT_PLUS_A", options=options)

    @cached_property
    def _whole(self) -> LowRankFactor:
        wide = self._matrix.wide
        return LowRankFactor(self._cholesky or self._pivoted, wide, wide)

    def solve(self, vectors: Floats, precision: float = 0.0) -> Floats:
        """Return K⁻¹ times vectors in any unit, shape (n,) or (n, vector), to rounding.

        Raises:
            RuntimeError: K is singular.
        """
        return self._whole.solve(vectors)

    def stationary(self, vector: Floats) -> Floats:
        """Return K⁻¹ times a vector in any unit, shape (n,), where K may be indefinite.

        Raises:
            RuntimeError: K is singular.
        """
        return self.solve(vector)

    def downhill(self, vector: Floats, precision: float = 0.0) -> Floats | None:
        """Return K⁻¹ times a vector in any unit, shape (n,); None if K is not definite."""
        return self.solve(vector) if self.is_definite else None

    @cached_property
    def is_definite(self) -> bool:
        """Return whether K is positive definite."""
        if self._cholesky is not None:
            return True
        if not self._matrix.wide.shape[1] and self._order is not None:
            return False
        if self._pivoted.exchanges_rows:
            return False
        negative = int((self._pivoted.pivots <= 0.0).sum())
        return negative == int((np.linalg.eigvalsh(self._whole.schur) < 0.0).sum())


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
        search, product = refined.copy(), inner(refined, residual)
        enough = PRECISION * PRECISION * product
        for _ in range(ROUNDS):
            if not product > enough:
                return found
            image = self._matrix(search)
            bent = inner(search, image)
            if not bent > 0.0:
                break
            found += product / bent * search
            residual -= product / bent * image
            refined = self._refined(residual)
            before, product = product, inner(refined, residual)
            search = refined + product / before * search
        return np.full_like(vector, np.nan)

    def _refined(self, vector: Floats) -> Floats:
        return np.einsum("nij,nj->ni", self._inverse, vector.reshape(-1, 3)).ravel()


def inner(one: Floats, other: Floats) -> float:
    """Return the inner product of vectors in any unit, shape (n,).

    BLAS would add in an order that depends on its threads.
    """
    return float(np.add.reduce(one * other))
