"""Inverses of stiffness matrices that couple the same nodes: factors, or iterations.

Small and slender nets are factorised. For large solids, whose factors would fill the memory,
conjugate gradients (M. R. Hestenes, E. Stiefel, J. Res. Nat. Bur. Stand. 49:409, 1952) with
multigrid as preconditioner take a time in proportion to the number of nodes. A direction of
negative curvature shows that K is not positive definite: Lanczos's method, which they contain,
finds the extreme eigenvalues first. Where they do not converge soon, K is factorised after all.
"""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.arrays import irregular
from tissuec.core.signals import give_way
from tissuec.mechanics.dissection import EliminationOrder, by_rows
from tissuec.mechanics.multigrid import Multigrid
from tissuec.mechanics.stiffness import Factorization, Stiffness, inner
from tissuec.model.network import Floats

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

LARGE = 6000  # unknowns from which a solid is solved without a factor
WORK = 2e8  # multiplications of a factor: fewer are faster than iterations
ROUNDS = 300
MOST = 2e8  # numbers of the largest factor that is made, of some 8 GB
BYTES = 40.0  # of each number of a factor, with copies
# Residuals at which iterations end, as parts of the right-hand side: of one that contains all
# motions, so that a negative one is noticed; of others; and with a matrix that may be
# indefinite.
GENERIC, PRECISE, STATIONARY = 1e-6, 1e-10, 1e-6
SLOW = 3.0  # times the rounds that a preconditioner took at first: then a new one is made


def is_iterated(unknowns: int, work: float) -> bool:
    """Return whether matrices are solved by iterations.

    Args:
        work: Multiplications of a factor.
    """
    return unknowns >= LARGE and work >= WORK


class Indefinite(Exception):
    """A matrix is not positive definite."""


class _Slow(Exception):
    """Conjugate gradients do not converge."""


class Iterations:
    """K⁻¹ by conjugate gradients.

    Args:
        matrix: K in any unit, three rows for each node.
        owner: Makes and keeps the preconditioner.
    """

    repeats = False  # another solution costs about as much as the first

    def __init__(self, matrix: Stiffness, owner: "Inverses"):
        self._matrix, self._owner = matrix, owner
        self._rows: csr_matrix = by_rows(matrix.sparse)
        self._factor: Factorization | None = None

    @property
    def is_definite(self) -> bool:
        """Return whether K is positive definite, by solving for all motions at once."""
        generic = irregular(self._rows.shape[0])
        try:
            return self.downhill(generic, GENERIC) is not None
        except RuntimeError:  # of the factor: singular
            return False

    def solve(self, vector: Floats, precision: float = PRECISE) -> Floats:
        """Return K⁻¹ times a vector in any unit, shape (n,).

        Args:
            precision: What may be left of it, as a part.

        Raises:
            Indefinite: K is not positive definite.
        """
        found = self.downhill(vector, precision)
        if found is None:
            raise Indefinite
        return found

    def downhill(self, vector: Floats, precision: float = PRECISE) -> Floats | None:
        """Return K⁻¹ times a vector in any unit, shape (n,); None if K is not definite.

        Args:
            precision: As of ``solve``.

        Raises:
            RuntimeError: Neither iterations nor a factor solve it.
        """
        if self._factor is None:
            try:
                return self._iterated(vector, precision)
            except Indefinite:
                return None
            except _Slow:
                self._factor = self._owner.factor(self._matrix)
        return self._factor.downhill(vector)

    def stationary(self, vector: Floats) -> Floats:
        """Return K⁻¹ times a vector in any unit, shape (n,), where K may be indefinite.

        By the method of minimal residuals (C. C. Paige, M. A. Saunders, SIAM J. Numer. Anal.
        12:617, 1975).

        Raises:
            Indefinite: There is no preconditioner.
        """
        from scipy.sparse.linalg import LinearOperator, minres

        multigrid, shape = self._owner.multigrid(self._matrix), self._rows.shape
        whole = LinearOperator(shape, self._matrix, dtype=float)
        rough = LinearOperator(shape, multigrid, dtype=float)
        return minres(whole, vector, M=rough, rtol=STATIONARY, maxiter=ROUNDS)[0]

    def _iterated(self, vector: Floats, precision: float) -> Floats:
        multigrid, wide = self._owner.multigrid(self._matrix), self._matrix.wide
        found, residual = np.zeros_like(vector), vector.astype(float)
        enough = (precision * precision) * inner(residual, residual)
        if not inner(residual, residual) > 0.0:
            return found
        refined = multigrid(residual)
        search, product = refined, inner(refined, residual)
        for number in range(ROUNDS):
            give_way()
            image = self._rows @ search
            if wide.shape[1]:
                image += wide @ (wide.T @ search)
            bent = inner(search, image)
            if not (bent > 0.0 and product > 0.0):
                raise Indefinite
            found += product / bent * search
            residual -= product / bent * image
            if inner(residual, residual) <= enough:
                self._owner.note(number + 1, precision)
                return found
            refined = multigrid(residual)
            before, product = product, inner(refined, residual)
            search = refined + product / before * search
        raise _Slow


class Inverses:
    """Makes inverses, and keeps what serves for all of them.

    Args:
        position: Of the nodes [m], shape (node, 3).
        order: In which unknowns of factors are eliminated.

    Attributes:
        refused: Memory of a factor that was needed and would have taken too much [bytes]; 0.0
            if there was none.
    """

    refused = 0.0

    def __init__(self, position: Floats, order: EliminationOrder):
        self._position, self._order = position, order
        self._multigrid: Multigrid | None = None
        self._pace = 0.0  # rounds for each digit, of the first solution with it

    def of(self, matrix: Stiffness) -> Factorization | Iterations:
        """Return K⁻¹.

        Raises:
            RuntimeError: K is singular.
        """
        unknowns = len(matrix.wide)
        if unknowns >= LARGE and is_iterated(unknowns, self._order.work(matrix.sparse)):
            return Iterations(matrix, self)
        return Factorization(matrix)

    def multigrid(self, matrix: Stiffness) -> Multigrid:
        """Return the preconditioner, made from a matrix if there is none.

        Raises:
            Indefinite: The matrix is not positive definite.
        """
        if self._multigrid is None:
            try:
                self._multigrid = Multigrid(matrix.sparse, self._position)
            except np.linalg.LinAlgError as error:
                raise Indefinite from error
            self._pace = 0.0
        return self._multigrid

    def factor(self, matrix: Stiffness) -> Factorization:
        """Return a factor where iterations do not converge.

        Raises:
            RuntimeError: K is singular, or the memory would not suffice.
        """
        self.forget()
        numbers = self._order.numbers(matrix.sparse)
        if numbers > MOST:
            self.refused = BYTES * numbers
            raise RuntimeError("a factor of this matrix would fill the memory")
        return Factorization(matrix)

    def note(self, rounds: int, precision: float) -> None:
        """Note how long a solution took; forget a preconditioner that has become a bad one."""
        pace = rounds / max(1.0, -float(np.log10(precision)))
        self._pace = self._pace or pace
        if pace > SLOW * self._pace:
            self.forget()

    def forget(self) -> None:
        """Make a new preconditioner next time."""
        self._multigrid = None
