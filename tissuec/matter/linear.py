"""Small displacements of a net: elongations of springs, and responses to forces."""

from typing import TYPE_CHECKING, Any

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


def with_cells(
    rows: "csr_matrix", constant: Floats, cells: "csr_matrix | None"
) -> tuple["csr_matrix", Floats]:
    """Return rows and constants of springs with those of cells, which resist like springs.

    Args:
        rows: From displacements to elongations, shape (spring, 3 node).
        constant: Of the springs [N/m], shape (spring,).
        cells: √(K/V) ∂V/∂x of cells that keep their volume [(N/m)^½], shape (3 node, cell).
    """
    if cells is None:
        return rows, constant
    from scipy.sparse import csr_matrix, vstack

    many = cells.shape[1]  # pyright: ignore[reportOptionalSubscript]  # inferred wrongly from SciPy's code
    return csr_matrix(vstack([rows, cells.T])), np.concatenate([constant, np.ones(many)])


def stiffness(rows: "csr_matrix", constant: Floats) -> "csr_matrix":
    """Return the stiffness matrix of springs, shape (unknown, unknown).

    Args:
        rows: From unknowns to elongations, shape (spring, unknown).
        constant: Of the springs [N/m], shape (spring,).
    """
    from scipy.sparse import csr_matrix, diags

    return csr_matrix(rows.T @ diags(constant) @ rows)


def solution(matrix: "csr_matrix", force: Floats) -> Floats:
    """Return displacements under forces in balance, without rigid motions [m].

    Args:
        matrix: Stiffness [N/m], shape (unknown, unknown).
        force: Of each case [N], shape (unknown, case).
    """
    diagonal = matrix.diagonal()
    diagonal = np.where(diagonal > 0.0, diagonal, 1.0)
    most = 20 * round(len(force) ** 0.5)
    start = np.zeros(len(force))
    found = [
        conjugate_gradients(matrix, diagonal, one, start, _PRECISE, most) for one in force.T
    ]
    return np.stack(found, axis=1)


def conjugate_gradients(
    matrix: Any, diagonal: Floats, right: Floats, start: Floats, precise: float, most: int
) -> Floats:
    """Solve equations, in any units, preconditioned by the diagonal of their matrix.

    Args:
        matrix: Symmetric, sparse or a linear operator, shape (n, n).
        diagonal: Positive, shape (n,).
        right: Right-hand side, shape (n,).
        start: A guess, shape (n,).
        precise: Residual, relative to the right-hand side.
        most: Iterations, at most.
    """
    from scipy.sparse.linalg import LinearOperator, cg

    def divided(y: Floats) -> Floats:
        return y / diagonal

    # SciPy's class makes an instance of another one, of which pyright does not know.
    inverse = LinearOperator(matrix.shape, matvec=divided)  # pyright: ignore[reportCallIssue]
    found, _ = cg(matrix, right, x0=start, rtol=precise, maxiter=most, M=inverse)
    return np.asarray(found)
