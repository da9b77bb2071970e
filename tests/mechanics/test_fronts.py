"""Factors by fronts solve as dense factors do, and notice matrices that are not definite."""

import numpy as np
import pytest
from scipy.sparse import block_diag, bsr_matrix, csc_matrix, kron

from tests.every import every
from tissuec.mechanics.dissection import EliminationOrder
from tissuec.mechanics.stiffness import DISSECTED, Factorization, Stiffness

SIDES = (9, 7, 6)


def grid(sides=SIDES):
    """Return the places of nodes of a grid, and which are neighbours, diagonals included."""
    place = np.stack(np.meshgrid(*map(np.arange, sides), indexing="ij"), axis=-1).reshape(-1, 3)
    apart = np.abs(place[:, None] - place[None]).max(axis=2)
    return place + 0.1 * np.sin(np.arange(place.size)).reshape(-1, 3), apart <= 1


def matrix_on(joined, seed=0, shift=1.0):
    """Return a symmetric matrix that couples nodes, with eigenvalues above ``shift``."""
    random = np.random.default_rng(seed)
    first, second = np.nonzero(np.triu(joined, 1))
    root = np.zeros((3 * len(first), 3 * len(joined)))
    for k, (one, other) in enumerate(zip(first, second, strict=True)):
        root[3 * k : 3 * k + 3, 3 * one : 3 * one + 3] = random.normal(size=(3, 3))
        root[3 * k : 3 * k + 3, 3 * other : 3 * other + 3] = random.normal(size=(3, 3))
    return root.T @ root + shift * np.eye(3 * len(joined))


@every(("pieces", "fixed"), [(1, 0), (1, 5), (3, 0)])
def test_solutions_are_those_of_a_dense_factor(pieces, fixed):
    places, joined = grid()
    places, joined = places[fixed:], joined[fixed:, fixed:]
    dense = matrix_on(joined)
    places = np.concatenate([places + np.array([0.0, 0.0, 20.0 * k]) for k in range(pieces)])
    whole = csc_matrix(block_diag([dense] * pieces))
    factor = EliminationOrder(places).cholesky(whole)
    vectors = np.random.default_rng(1).normal(size=(len(places) * 3, 2))
    expected = np.linalg.solve(whole.toarray(), vectors)
    assert factor is not None
    assert factor.solve(vectors) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert factor.solve(vectors[:, 0]) == pytest.approx(expected[:, 0], rel=1e-9, abs=1e-12)
    signs = np.sign(vectors[:, 0]).astype(np.int8)  # as estimates of norms take them
    assert factor.solve(signs) == pytest.approx(factor.solve(signs.astype(float)), rel=1e-12)


def test_a_matrix_with_other_couplings_has_its_own_fronts():
    places, joined = grid()
    order = EliminationOrder(places)
    assert order.cholesky(csc_matrix(matrix_on(joined))) is not None
    joined[0, -1] = joined[-1, 0] = True  # as a contact between distant nodes
    other = matrix_on(joined, seed=1)
    vector = np.sin(np.arange(len(other)))
    found = order.cholesky(csc_matrix(other))
    assert found is not None
    assert found.solve(vector) == pytest.approx(np.linalg.solve(other, vector), rel=1e-9)


def test_entries_that_are_zero_may_be_left_out():
    places, joined = grid()
    diagonal = kron(bsr_matrix(joined.astype(float)), np.eye(3))  # six of nine are 0
    sparse = csc_matrix(diagonal + 30.0 * csc_matrix(np.eye(3 * len(places))))
    sparse.eliminate_zeros()
    vector = np.sin(np.arange(sparse.shape[0]))
    factor = EliminationOrder(places).cholesky(sparse)
    assert factor is not None
    assert sparse @ factor.solve(vector) == pytest.approx(vector, abs=1e-12)


@every("lowered", [False, True])
def test_a_matrix_that_is_not_definite_has_no_factor_but_is_solved(lowered):
    places, joined = grid((9, 8, 6))
    dense = matrix_on(joined)
    least = np.linalg.eigvalsh(dense)[0]
    dense -= (least + 1e-3 * (1.0 if lowered else -1.0)) * np.eye(len(dense))
    assert len(dense) >= DISSECTED
    none = np.zeros((len(dense), 0))
    stiffness = Stiffness(csc_matrix(dense), none, EliminationOrder(places))
    factor, vector = Factorization(stiffness), np.sin(np.arange(len(dense)))
    assert factor.is_definite is not lowered
    assert (factor.downhill(vector) is None) is lowered
    found = factor.stationary(vector)
    assert dense @ found == pytest.approx(vector, abs=1e-6)


def test_what_is_added_by_few_columns_can_make_a_matrix_definite():
    places, joined = grid((9, 8, 6))
    dense = matrix_on(joined)
    value, shape = (each[..., 0] for each in np.linalg.eigh(dense))
    dense -= (value + 1.0) * np.eye(len(dense))
    for size, is_definite in ((2.0, True), (0.5, False)):
        # Only the least eigenvalue is negative, -1: v vᵀ times more than 1 mends that.
        lowest = dense + (np.eye(len(dense)) - np.outer(shape, shape)) * 1.0
        wide = np.sqrt(size) * shape[:, None]
        factor = Factorization(Stiffness(csc_matrix(lowest), wide, EliminationOrder(places)))
        vector = np.sin(np.arange(len(dense)))
        assert factor.is_definite is is_definite
        expected = np.linalg.solve(lowest + wide @ wide.T, vector)
        assert factor.solve(vector) == pytest.approx(expected, rel=1e-6, abs=1e-8)
