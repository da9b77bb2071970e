"""The matrix of small motions of a net about its state, and its lowest eigenvalues.

Motions u(t) = φ cos ωt of the free nodes obey K φ = ω² M φ. With y = M^½ φ this is A y = ω² y,

    A = M^-½ K M^-½ = S + W Wᵀ.

S is sparse; W has one column for each enclosed volume with a large surface, whose pressure acts
between all of its nodes. (R. W. Clough, J. Penzien, Dynamics of Structures, 2003.)

Unknowns are eliminated in the order of ``mechanics.dissection``.

Small nets are solved by a dense solver, larger ones by Lanczos's method with (A - σ)⁻¹, σ being
just below all eigenvalues, or at the limit that they are to lie above. As the method may pass
over copies of a multiple eigenvalue, it is repeated without what was found as long as there are
fewer than Sylvester's law of inertia counts. (R. B. Lehoucq, D. C. Sorensen, C. Yang, ARPACK
Users' Guide, 1998; B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, chapters 3 and 13.)
"""

from functools import cached_property
from math import ceil, log
from typing import Any, NamedTuple, cast

import numpy as np
from msgspec import Struct
from scipy.linalg import eigh
from scipy.sparse import csc_matrix, diags_array, eye_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from tissuec.core.arrays import irregular
from tissuec.forces.springs.resting_springs import Bars
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.dissection import EliminationOrder
from tissuec.mechanics.stiffness import LowRankFactor, SparseFactor
from tissuec.model.network import Floats, Indices

SOUND = 1e-6  # of the right-hand side: what a solution may leave of it
TRUSTED = 1e-2  # what it may leave before it is refined, so that the signs of pivots are right


class Unsound(Exception):
    """A factorisation without exchanges of rows has lost its digits."""


class Operator(Struct, frozen=True, eq=False, dict=True):
    """A = S + W Wᵀ.

    Attributes:
        sparse: S [1/s²], shape (n, n).
        wide: W [1/s], shape (n, volume).
        places: Of the free nodes [m], shape (n / 3, 3).
    """

    sparse: csc_matrix
    wide: Floats
    places: Floats

    def __call__(self, y: Floats) -> Floats:
        """Return A y, shape (n,) or (n, vector)."""
        return self.sparse @ y + self.wide @ (self.wide.T @ y)

    @property
    def size(self) -> int:
        return 3 * len(self.places)

    @cached_property
    def top(self) -> float:
        """Return a bound of the size of all eigenvalues [1/s²], by Gershgorin's theorem."""
        rows = np.asarray(abs(self.sparse).sum(axis=1))
        return float(rows.max()) + float((self.wide**2).sum())

    def dense(self) -> Floats:
        """Return A as an array [1/s²], shape (n, n)."""
        return self.sparse.toarray() + self.wide @ self.wide.T

    @cached_property
    def order(self) -> Indices:
        """Return the order in which unknowns are eliminated, shape (n,)."""
        return EliminationOrder(self.places).of(self.sparse)


class Shifted:
    """(A - σ)⁻¹, and how many eigenvalues of A are below σ.

    By Sylvester's law of inertia the pivots of S - σ have the signs of its eigenvalues, and
    those of A follow from the Schur complement I + Wᵀ (S - σ)⁻¹ W. The factors are those of a
    matrix nearby, S - σ + E. Solutions that leave less than a hundredth of the right-hand side
    show that E (A - σ)⁻¹ is small: no eigenvalue of A - σ + t E passes 0 for t in [0, 1].

    Args:
        shift: σ [1/s²].

    Attributes:
        shift: σ.
        below: How many eigenvalues are below σ.

    Raises:
        Unsound: σ is too close to an eigenvalue.
    """

    def __init__(self, operator: Operator, shift: float):
        moved = operator.sparse - shift * eye_array(operator.size, format="csc")
        symmetric = {"SymmetricMode": True, "DiagPivotThresh": 0.0}
        try:
            factor = SparseFactor(csc_matrix(moved), operator.order, options=symmetric)
        except RuntimeError as error:  # singular
            raise Unsound from error
        if factor.exchanges_rows:
            raise Unsound
        self.shift = shift
        self._operator = operator
        self._factor = LowRankFactor(factor, operator.wide, operator.wide)
        signs = factor.pivots, np.linalg.eigvalsh(self._factor.schur)
        self.below = int((signs[0] < 0.0).sum() - (signs[1] < 0.0).sum())
        probe = irregular(operator.size)
        left = self._left(probe, self._factor.solve(probe))
        lost = float(np.linalg.norm(left) / max(np.linalg.norm(probe), 1e-300))
        if not lost <= TRUSTED:
            raise Unsound
        self._refinements = ceil(log(SOUND) / log(max(lost, SOUND))) - 1

    def solve(self, right: Floats) -> Floats:
        """Return (A - σ)⁻¹ b in the unit of b times [s²], both of shape (n,)."""
        found = self._factor.solve(right)
        for _ in range(self._refinements):
            found = found + self._factor.solve(self._left(right, found))
        return found

    def _left(self, right: Floats, found: Floats) -> Floats:
        """Return the residual of a solution."""
        return right - self._operator(found) + self.shift * found


def operator_of(balance: Balance, bars: Bars) -> Operator:
    """Return the matrix of small motions of the free nodes of a balance.

    Args:
        bars: With the free nodes where they are.
    """
    stiffness = balance.matrix(bars, exact=True)
    root = diags_array(1.0 / np.sqrt(np.repeat(balance.mass, 3)))
    return Operator(
        csc_matrix(root @ stiffness.sparse @ root),
        np.asarray(root @ stiffness.wide, dtype=float),
        bars.position[balance.free],
    )


DENSE = 900  # unknowns up to which all eigenvalues are computed: about a second
ZERO = 1e-12  # of the largest eigenvalue: rounding leaves a ten thousandth of that
BELOW = 1e-10  # of the largest: how far σ is below zero where nothing is unstable
APART = 1e-4  # of an eigenvalue: a gap to the next one between which is counted
AWAY = 1.7  # times the shift, where it meets an eigenvalue
STRIDE = 100.0  # times the shift, as long as no eigenvalue is in between
TRIES = 12


class NotFound(Exception):
    """The method did not converge."""


class EigenPairs(NamedTuple):
    """Eigenvalues in ascending order and orthonormal eigenvectors.

    Attributes:
        values: [1/s²], shape (pair,).
        vectors: Shape (n, pair).
    """

    values: Floats
    vectors: Floats


def lowest(
    operator: Operator, known: csc_matrix, count: int, above: float | None = None
) -> EigenPairs:
    """Return the lowest eigenvalues, or the lowest ones above a limit.

    Args:
        operator: The matrix.
        known: Orthonormal eigenvectors of eigenvalue 0 that are left out, shape (n, known).
        count: Number of eigenvalues, if there are as many.
        above: The limit [1/s²]; above 0.

    Raises:
        NotFound: The method did not converge.
    """
    count = min(count, operator.size - known.shape[1])  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
    if count <= 0:
        return EigenPairs(np.zeros(0), np.zeros((operator.size, 0)))
    if operator.size <= max(DENSE, 3 * count):
        return _chosen(_all(operator, known), count, above)
    shifted = _beneath(operator) if above is None else _near(operator, above)
    return _chosen(_lanczos(operator, shifted, known, count), count, above)


def count_below(operator: Operator, known: csc_matrix, limit: float) -> int | None:
    """Return how many eigenvalues are below a positive limit, known ones included.

    Args:
        operator: The matrix.
        known: Orthonormal eigenvectors of eigenvalue 0, shape (n, known).
        limit: The limit [1/s²].

    Returns:
        The number; None if it is uncertain because of rounding.
    """
    if operator.size == known.shape[1]:  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
        return operator.size
    if operator.size <= DENSE:
        return int((_all(operator, known).values < limit).sum()) + known.shape[1]  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
    try:
        return Shifted(operator, limit).below
    except Unsound:
        return None


def _all(operator: Operator, known: csc_matrix) -> EigenPairs:
    """Return all eigenvalues but the known ones, which are moved above all others."""
    basis, matrix = known.toarray(), operator.dense()
    matrix += 4.0 * max(operator.top, 1e-300) * (basis @ basis.T)
    values, vectors = eigh(matrix)
    stay = operator.size - basis.shape[1]
    return EigenPairs(values[:stay], vectors[:, :stay])


def _chosen(pairs: EigenPairs, count: int, above: float | None) -> EigenPairs:
    """Return the first ones above a limit."""
    chosen = np.flatnonzero(pairs.values > (-np.inf if above is None else above))[:count]
    return EigenPairs(pairs.values[chosen], pairs.vectors[:, chosen])


def _beneath(operator: Operator) -> Shifted:
    """Return (A - σ)⁻¹ with σ a little below all eigenvalues."""
    shift = -BELOW * operator.top
    for _ in range(TRIES):
        try:
            shifted = Shifted(operator, shift)
            if not shifted.below:
                return shifted
        except Unsound:
            pass
        shift *= 10.0
    raise NotFound


def _near(operator: Operator, shift: float) -> Shifted:
    """Return (A - σ)⁻¹ with σ above a limit, or a little below where it meets an eigenvalue.

    No eigenvalue is between the limit and σ, which is as far up as that allows. Otherwise
    eigenvalues of 0 just below the limit become so large in (A - σ)⁻¹ that their rounding
    errors drown those above.
    """
    for _ in range(TRIES):
        try:
            shifted = Shifted(operator, shift)
            break
        except Unsound:
            shift /= AWAY
    else:
        raise NotFound
    while shifted.shift * STRIDE < operator.top:
        try:
            further = Shifted(operator, shifted.shift * STRIDE)
        except Unsound:
            break
        if further.below != shifted.below:
            break
        shifted = further
    return shifted


def _lanczos(operator: Operator, shifted: Shifted, known: csc_matrix, count: int) -> EigenPairs:
    """Return the eigenvalues next above the shift, at least ``count`` if there are as many."""
    found, last = EigenPairs(np.zeros(0), np.zeros((operator.size, 0))), np.inf
    # Known ones are at 0, above the shift or below it.
    others = shifted.below + (known.shape[1] if shifted.shift < 0.0 else 0)  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
    while True:
        more = _next(operator, shifted, known, found.vectors, count)
        found = _refined(operator, np.hstack((found.vectors, more.vectors)))
        came = (more.values < last - ZERO * operator.top).any()
        if not came or _is_complete(operator, found.values[:count], others):
            return found
        last = found.values[count - 1] if len(found.values) >= count else np.inf


def _is_complete(operator: Operator, values: Floats, others: int) -> bool:
    """Return whether no eigenvalue is missing below the last gap between some.

    Args:
        others: How many further ones are below that gap.
    """
    zero = ZERO * operator.top
    gaps = np.flatnonzero(np.diff(values) > APART * np.abs(values[1:]) + zero)
    if not len(gaps):
        return True
    last = int(gaps[-1])
    try:
        below = Shifted(operator, 0.5 * float(values[last] + values[last + 1])).below
    except Unsound:
        return False
    return below == last + 1 + others


def _next(
    operator: Operator, shifted: Shifted, known: csc_matrix, found: Floats, count: int
) -> EigenPairs:
    """Return the eigenvalues next above the shift beside what is known and what was found."""

    def project(y: Floats) -> Floats:
        y = y - known @ (known.T @ y)
        return y - found @ (found.T @ y)

    def apply(y: Floats) -> Floats:
        return project(shifted.solve(project(y.ravel())))

    size = operator.size
    start = project(np.cos(1.0 + found.shape[1] + np.arange(size, dtype=float) ** 2))
    inverse = cast(Any, LinearOperator)((size, size), matvec=apply, dtype=float)
    try:
        values, vectors = cast(Any, eigsh)(inverse, k=count, which="LA", v0=start)
    except (ArpackError, RuntimeError) as error:
        raise NotFound from error
    # Of what lies above the shift; what was projected out comes as zero.
    is_above = values > 0.5 / (operator.top - shifted.shift)
    return _refined(operator, np.asarray(vectors)[:, is_above])


def _refined(operator: Operator, vectors: Floats) -> EigenPairs:
    """Return the best eigenvalues and eigenvectors in the span of some vectors.

    By Rayleigh and Ritz; their errors are the squares of those of the vectors.
    """
    basis, _ = np.linalg.qr(vectors)
    values, turn = np.linalg.eigh(basis.T @ operator(basis))
    return EigenPairs(values, basis @ turn)
