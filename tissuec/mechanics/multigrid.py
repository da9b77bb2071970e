"""An approximate inverse of the stiffness of solids by multigrid, of smoothed aggregation.

Nodes that act strongly on each other form aggregates, the nodes of the next, coarser level.
Each moves as a rigid body there, in three shifts and three turns; these motions, smoothed by a
step of Jacobi's method, make the coarser matrix Pᵀ K P. On each level, Chebyshev's polynomials
of K scaled by the blocks of nodes remove what is short, and the coarser level what is long. (P.
Vaněk, J. Mandel, M. Brezina, Computing 56:179, 1996; M. Adams et al., J. Comput. Phys. 188:593,
2003.)

Rounds of conjugate gradients with it hardly depend on the number of nodes.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import bsr_matrix, csc_matrix, diags_array

from tissuec.core.arrays import irregular, rigid_motions
from tissuec.core.signals import give_way
from tissuec.mechanics.dissection import blocks_of
from tissuec.model.network import Floats, Indices

COARSEST = 900  # unknowns of which the dense factor is cheap
STRONG = 0.03  # of the blocks of two nodes: coupling that joins them
RANGE = 30.0  # part of the spectrum, as a ratio, that smoothing removes
DEGREE = 2  # of the polynomials
ROUNDS = 12  # of the power method, for the largest eigenvalue
MARGIN = 1.1  # which it finds too low by less than this
DEPENDENT = 1e-8  # of the largest: motions of an aggregate that are none, as of a single node
SHIFT = 1e-12  # of the largest entry, on the diagonal of the coarsest matrix


class Level(NamedTuple):
    """A level, from which a coarser one is made.

    Attributes:
        matrix: K, by blocks of nodes.
        inverse: Of the diagonal blocks, shape (node, n, n).
        top: Largest eigenvalue of K scaled by these.
        spread: P, from motions of aggregates to those of nodes.
        gather: Pᵀ.
    """

    matrix: bsr_matrix
    inverse: Floats
    top: float
    spread: bsr_matrix
    gather: bsr_matrix

    def scaled(self, vector: Floats) -> Floats:
        """Return a vector in any unit times inverses of diagonal blocks, shape (unknown,)."""
        nodes, width, _ = self.inverse.shape
        return (self.inverse @ vector.reshape(nodes, width, 1)).ravel()

    def smoothed(self, residual: Floats) -> Floats:
        """Return the solution within the upper part of the spectrum, shape (unknown,).

        By Chebyshev's iteration (Y. Saad, Iterative Methods for Sparse Linear Systems, 2003,
        algorithm 12.1).

        Args:
            residual: In any unit, shape (unknown,).
        """
        high, low = self.top, self.top / RANGE
        middle, half = 0.5 * (high + low), 0.5 * (high - low)
        ratio = half / middle
        step = self.scaled(residual) / middle
        found = step.copy()
        for _ in range(DEGREE - 1):
            residual = residual - self.matrix @ step
            after = 1.0 / (2.0 * middle / half - ratio)
            step = after * ratio * step + 2.0 * after / half * self.scaled(residual)
            found += step
            ratio = after
        return found


class Multigrid:
    """An approximation of K⁻¹ that is symmetric and positive definite.

    Args:
        matrix: K in any unit, symmetric, with three rows for each node, shape (3 node, 3 node).
        position: Of the nodes [m], shape (node, 3).

    Raises:
        LinAlgError: K is not positive definite.
    """

    def __init__(self, matrix: csc_matrix, position: Floats):
        fine = blocks_of(matrix)
        motions = rigid_motions(position)
        self.levels: list[Level] = []
        while fine.shape[0] > COARSEST:
            give_way()
            level, coarse, position, motions = _coarsened(fine, position, motions)
            if coarse.shape[0] > 0.7 * fine.shape[0]:
                break
            self.levels.append(level)
            fine = coarse
        dense = fine.toarray()
        dense[np.diag_indices_from(dense)] += SHIFT * float(np.abs(dense).max())
        self._factor = cho_factor(dense, lower=True, overwrite_a=True)

    def __call__(self, residual: Floats) -> Floats:
        """Return the approximate solution for a residual, shape (unknown,)."""
        return self._cycle(0, residual)

    def _cycle(self, number: int, residual: Floats) -> Floats:
        """Return the solution on a level and below, as in a cycle of V."""
        if number == len(self.levels):
            return np.asarray(cho_solve(self._factor, residual))
        level = self.levels[number]
        found = level.smoothed(residual)
        left = level.gather @ (residual - level.matrix @ found)
        found = found + level.spread @ self._cycle(number + 1, left)
        return found + level.smoothed(residual - level.matrix @ found)


def _coarsened(
    fine: bsr_matrix, position: Floats, motions: Floats
) -> tuple[Level, bsr_matrix, Floats, Floats]:
    """Return a level, and of the next one the matrix, places and rigid motions of nodes.

    Args:
        fine: K of this level.
        position: Of its nodes [m], shape (node, 3).
        motions: Their rigid motions, shape (node, n, 6).
    """
    labels = aggregates(fine)
    count = int(labels.max()) + 1
    share = np.bincount(labels, minlength=count)[:, None]
    middle = np.stack([np.bincount(labels, each) for each in position.T], axis=1) / share
    tentative, coarse = _tentative(labels, position, middle, motions)
    blocks = _diagonal_blocks(fine)
    np.linalg.cholesky(blocks)  # raises if one is not positive definite
    inverse: Floats = np.linalg.inv(blocks).astype(float)
    top = _largest(fine, inverse)
    moved = _scaled_rows(bsr_matrix(fine @ tentative), inverse)
    smoothed = bsr_matrix(tentative - (4.0 / (3.0 * top)) * moved)
    del moved
    gather = bsr_matrix(smoothed.T)
    below = bsr_matrix(gather @ bsr_matrix(fine @ smoothed))
    # Motions that an aggregate does not have are held.
    missing = _diagonal_blocks(below)
    none = np.einsum("nii->ni", missing) <= 0.0
    if none.any():
        held = diags_array(none.ravel().astype(float))
        below = bsr_matrix((below + held).tobsr((6, 6)))
    level = Level(fine, inverse, top, smoothed, gather)
    return level, below, middle, coarse


def _tentative(
    labels: Indices, position: Floats, middle: Floats, motions: Floats
) -> tuple[bsr_matrix, Floats]:
    """Return motions of nodes by those of aggregates, and the rigid motions of these.

    The former are orthonormal, shape (n node, 6 aggregate), the latter have the shape
    (aggregate, 6, 6).
    """
    count, width = len(middle), motions.shape[1]
    away = ((position - middle[labels]) ** 2).sum(axis=1)
    size = np.sqrt(np.bincount(labels, away) / np.bincount(labels))
    size = np.where(size > 0.0, size, 1.0)
    # Twists about the middle of an aggregate, in units of its size.
    turn = np.zeros((count, 6, 6))
    turn[:, :3, :3] = np.eye(3)
    turn[:, 3:, 3:] = np.eye(3) / size[:, None, None]
    turn[:, :3, 3:] = -rigid_motions(middle)[:, :, 3:] / size[:, None, None]
    back: Floats = np.linalg.inv(turn).astype(float)
    own = motions @ turn[labels]
    order = np.argsort(labels, kind="stable")
    first = np.searchsorted(labels[order], np.arange(count))
    gram = np.add.reduceat((own.swapaxes(1, 2) @ own)[order], first, axis=0)
    value, way = np.linalg.eigh(gram)
    there = value > DEPENDENT * value[:, -1:]
    root = np.sqrt(np.where(there, value, 0.0))
    over = np.where(there, 1.0 / np.where(there, root, 1.0), 0.0)
    blocks = own @ (way * over[:, None, :])[labels]
    pointers = np.arange(len(labels) + 1)
    shape = width * len(labels), 6 * count
    tentative = bsr_matrix((blocks, labels, pointers), shape=shape)
    coarse: Floats = (root[:, :, None] * way.swapaxes(1, 2)) @ back
    return tentative, coarse


def aggregates(matrix: bsr_matrix) -> Indices:
    """Return the aggregate of each node, shape (node,).

    Nodes without a strong neighbour in one begin another, with all their strong neighbours; the
    others join that to which they are coupled most.
    """
    count = len(matrix.indptr) - 1
    size = np.sqrt(np.einsum("bij,bij->b", matrix.data, matrix.data))
    row = np.repeat(np.arange(count), np.diff(matrix.indptr))
    column = matrix.indices
    own = np.zeros(count)
    own[row[row == column]] = size[row == column]
    strong = size > STRONG * np.sqrt(own[row] * own[column])
    row, column, size = row[strong], column[strong], size[strong]
    begin = np.searchsorted(row, np.arange(count + 1)).tolist()
    labels = np.full(count, -1)
    found = 0
    for node in range(count):
        if labels[node] < 0:
            beside = column[begin[node] : begin[node + 1]]
            if (labels[beside] < 0).all():
                labels[beside] = found
                labels[node] = found
                found += 1
    while (alone := (labels[row] < 0) & (labels[column] >= 0)).any():
        order = np.lexsort((size[alone], row[alone]))
        ends = row[alone][order]
        last = np.append(np.flatnonzero(np.diff(ends)), len(ends) - 1)
        labels[ends[last]] = labels[column[alone][order][last]]
    return labels


def _diagonal_blocks(matrix: bsr_matrix) -> Floats:
    """Return the diagonal blocks, shape (node, n, n)."""
    count, width = len(matrix.indptr) - 1, matrix.blocksize[0]
    row = np.repeat(np.arange(count), np.diff(matrix.indptr))
    own = row == matrix.indices
    found = np.zeros((count, width, width))
    found[row[own]] = matrix.data[own]
    return found


def _scaled_rows(matrix: bsr_matrix, inverse: Floats) -> bsr_matrix:
    """Return a matrix with its rows of blocks times the inverses of the diagonal ones."""
    row = np.repeat(np.arange(len(inverse)), np.diff(matrix.indptr))
    data = inverse[row] @ matrix.data
    return bsr_matrix((data, matrix.indices, matrix.indptr), shape=matrix.shape)


def _largest(matrix: bsr_matrix, inverse: Floats) -> float:
    """Return a bound of the eigenvalues of a matrix scaled by its diagonal blocks."""
    nodes, width, _ = inverse.shape
    vector = irregular(nodes * width)
    value = 1.0
    for _ in range(ROUNDS):
        vector /= np.linalg.norm(vector)
        image = (inverse @ (matrix @ vector).reshape(nodes, width, 1)).ravel()
        value = float(np.linalg.norm(image))
        vector = image
    return MARGIN * value
