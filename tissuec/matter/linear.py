"""Small displacements of a net: elongations of springs, and responses to forces."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

_PRECISE = 1e-4  # residual of forces; energies are off by its square


def elongations(position: Floats, ends: NDArray[np.int32]) -> "csr_matrix":
    """Return the matrix from displacements to elongations, shape (spring, 3 node).

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
    """
    from scipy.sparse import csr_matrix

    along = position[ends[:, 1]] - position[ends[:, 0]]
    n = along / np.linalg.norm(along, axis=1, keepdims=True)
    column = (3 * ends.astype(np.int64)[:, :, None] + np.arange(3)).ravel()
    row = np.repeat(np.arange(len(ends)), 6)
    values = np.concatenate([-n, n], axis=1).ravel()
    return csr_matrix((values, (row, column)), shape=(len(ends), position.size))


def stiffness(rows: "csr_matrix", constant: Floats) -> "csr_matrix":
    """Return the stiffness matrix of springs, shape (unknown, unknown).

    Args:
        rows: From unknowns to elongations, shape (spring, unknown).
        constant: Of the springs [N/m], shape (spring,).
    """
    from scipy.sparse import csr_matrix, diags

    return csr_matrix(rows.T @ diags(constant) @ rows)


def solution(matrix: "csr_matrix", force: Floats, start: Floats | None = None) -> Floats:
    """Return displacements under forces in balance, without rigid motions [m].

    Args:
        matrix: Stiffness [N/m], shape (unknown, unknown).
        force: Of each case [N], shape (unknown, case).
        start: A guess of the result [m], shape (unknown, case).
    """
    from scipy.sparse.linalg import LinearOperator, cg

    diagonal = matrix.diagonal()
    diagonal = np.where(diagonal > 0.0, diagonal, 1.0)
    # SciPy's class makes an instance of another one, of which pyright does not know.
    inverse = LinearOperator(matrix.shape, matvec=lambda y: y / diagonal)  # pyright: ignore[reportCallIssue]
    most = 20 * round(len(force) ** 0.5)
    begun = np.zeros_like(force) if start is None else start
    cases = zip(force.T, begun.T, strict=True)
    found = [
        cg(matrix, pull, x0=guess, rtol=_PRECISE, maxiter=most, M=inverse)[0]
        for pull, guess in cases
    ]
    return np.stack(found, axis=1)
