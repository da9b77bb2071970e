"""The matrix of small motions of a net about its state.

Motions u(t) = φ cos ωt of the free nodes obey K φ = ω² M φ. With y = M^½ φ this is A y = ω² y,

    A = M^-½ K M^-½ = S + W Wᵀ.

S is sparse; W has one column for each enclosed volume with a large surface, whose pressure acts
between all of its nodes. (R. W. Clough, J. Penzien, Dynamics of Structures, 2003.)

Nodes are ordered so that the factor of S has few entries, by nested dissection of places: the
net is halved across its longest side, and the nodes of one half that springs join to the other
come last; both halves likewise. For meshes of the plane the factor has O(n log n) entries, and
for solids O(n^(4/3)). (A. George, SIAM J. Numer. Anal. 10:345, 1973; G. L. Miller et al., J.
ACM 44:1, 1997.)
"""

from functools import cached_property
from math import ceil, log

import numpy as np
from msgspec import Struct
from scipy.sparse import csc_matrix, csr_matrix, diags_array, eye_array
from scipy.sparse.linalg import splu

from tissuec.forces.resting_springs import Bars
from tissuec.mechanics.balance import Balance
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
        pattern = self.sparse.tocoo()
        nodes = np.ones(pattern.nnz, dtype=np.int8), (pattern.row // 3, pattern.col // 3)
        joined = csr_matrix(nodes, shape=(self.size // 3, self.size // 3))
        return (3 * dissected(self.places, joined)[:, None] + np.arange(3)).ravel()


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
        order, size = operator.order, operator.size
        moved = operator.sparse - shift * eye_array(size, format="csc")
        symmetric = {"SymmetricMode": True, "DiagPivotThresh": 0.0}
        try:
            self._factor = splu(
                csc_matrix(moved[order][:, order]), permc_spec="NATURAL", options=symmetric
            )
        except RuntimeError as error:  # singular
            raise Unsound from error
        if not np.array_equal(self._factor.perm_r, self._factor.perm_c):
            raise Unsound  # rows were exchanged, so that signs of pivots say nothing
        self.shift = shift
        self._operator = operator
        self._order, self._wide = order, operator.wide
        self._spread = self._within(operator.wide)
        self._schur = np.eye(operator.wide.shape[1]) + operator.wide.T @ self._spread
        signs = self._factor.U.diagonal(), np.linalg.eigvalsh(self._schur)
        self.below = int((signs[0] < 0.0).sum() - (signs[1] < 0.0).sum())
        probe = np.sin(1.0 + np.arange(size, dtype=float) ** 2)
        left = self._left(probe, self._solved(probe))
        lost = float(np.linalg.norm(left) / max(np.linalg.norm(probe), 1e-300))
        if not lost <= TRUSTED:
            raise Unsound
        self._refinements = ceil(log(SOUND) / log(max(lost, SOUND))) - 1

    def solve(self, right: Floats) -> Floats:
        """Return (A - σ)⁻¹ b in the unit of b times [s²], both of shape (n,)."""
        found = self._solved(right)
        for _ in range(self._refinements):
            found = found + self._solved(self._left(right, found))
        return found

    def _left(self, right: Floats, found: Floats) -> Floats:
        """Return the residual of a solution."""
        return right - self._operator(found) + self.shift * found

    def _solved(self, right: Floats) -> Floats:
        found = self._within(right)
        if not self._wide.shape[1]:
            return found
        return found - self._spread @ np.linalg.solve(self._schur, self._wide.T @ found)

    def _within(self, right: Floats) -> Floats:
        """Return (S - σ)⁻¹ b, shape of b."""
        found = np.empty_like(right, dtype=float)
        if found.size:
            found[self._order] = self._factor.solve(right[self._order])
        return found


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


LEAF = 32  # nodes that are not divided further


def dissected(position: Floats, joined: csr_matrix) -> Indices:
    """Return the numbers of nodes in the order of elimination, shape (node,).

    Args:
        position: Of the nodes [m], shape (node, 3).
        joined: Which nodes act on one another, symmetric, shape (node, node).
    """
    order = np.empty(len(position), dtype=np.int64)
    is_there = np.zeros(len(position), dtype=bool)
    waiting = [(0, np.arange(len(position)))]
    while waiting:
        first, nodes = waiting.pop()
        if len(nodes) <= LEAF:
            order[first : first + len(nodes)] = nodes
            continue
        low, high = _halves(position, nodes)
        is_there[high] = True
        rows = joined[low]
        touches = np.bincount(
            np.repeat(np.arange(len(low)), np.diff(rows.indptr)),
            is_there[rows.indices], len(low),
        ) > 0.0  # fmt: skip
        is_there[high] = False
        last = first + len(nodes) - np.count_nonzero(touches)
        order[last : first + len(nodes)] = low[touches]
        inner = low[~touches]
        waiting += [(first, inner), (first + len(inner), high)]
    return order


def _halves(position: Floats, nodes: Indices) -> tuple[Indices, Indices]:
    """Return the nodes on either side of the middle of the longest side."""
    places = position[nodes]
    along = places[:, np.argmax(np.ptp(places, axis=0))]
    ranked = nodes[np.argsort(along, kind="stable")]
    return ranked[: len(ranked) // 2], ranked[len(ranked) // 2 :]
