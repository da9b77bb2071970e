"""Virtual tests of a solid net: it is drawn by a uniform stress, and what it gives is compared.

A uniform stress σ acts on the nodes of the boundary with forces σ N (see ``solid``). A body of
volume V, Young's modulus E and Poisson's ratio ν = 1/4 stores

    ½ V σ²/E  in tension,     ½ V σ²/G  in shear,     G = E / (2 (1 + ν)).
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.matter.solid import Solid
from tissuec.network import Floats

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

POISSON = 0.25  # of a solid of central springs
_FLOPPY = 1e3  # times as soft as asked: a net that gives way


class Stiffness(NamedTuple):
    """How stiff a net is, beside the body that it stands for.

    Attributes:
        tension: In x, y and z, shape (3,).
        shear: In yz, zx and xy, shape (3,).
    """

    tension: Floats
    shear: Floats


def measured(
    position: Floats, ends: NDArray[np.int32], constant: Floats, solid: Solid
) -> Stiffness:
    """Return how stiff springs make a body whose Young's modulus should be 1 Pa.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        constant: Of each spring per Young's modulus [m], shape (spring,).
        solid: What the nodes stand for.

    Raises:
        ValueError: Nothing resists one of the stresses.
    """
    matrix = _matrix(position, ends, constant)
    volume = float(solid.volume.sum())
    found = []
    for one, other in ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)):
        force = np.zeros_like(position)
        force[:, one] += solid.outward[:, other]
        if one != other:
            force[:, other] += solid.outward[:, one]
        stored = 0.5 * float(force.ravel() @ _solution(matrix, force.ravel()))
        asked = 0.5 * volume * (1.0 if one == other else 2.0 * (1.0 + POISSON))
        if not 0.0 < stored < _FLOPPY * asked:
            raise ValueError("nothing resists " + ("tension" if one == other else "shear"))
        found.append(asked / stored)
    return Stiffness(np.array(found[:3]), np.array(found[3:]))


def _matrix(position: Floats, ends: NDArray[np.int32], constant: Floats) -> "csc_matrix":
    """Return the stiffness matrix at rest, shape (3 node, 3 node)."""
    from scipy.sparse import csc_matrix, diags

    along = position[ends[:, 1]] - position[ends[:, 0]]
    n = along / np.linalg.norm(along, axis=1, keepdims=True)
    column = (3 * ends.astype(np.int64)[:, :, None] + np.arange(3)).reshape(len(ends), 6)
    row = np.repeat(np.arange(len(ends)), 6)
    values = np.concatenate([-n, n], axis=1).ravel()
    strain = csc_matrix((values, (row, column.ravel())), shape=(len(ends), position.size))
    return (strain.T @ diags(constant) @ strain).tocsc()


def _solution(matrix: "csc_matrix", force: Floats) -> Floats:
    """Return displacements under forces in balance; rigid motions stay out of them."""
    from scipy.sparse.linalg import LinearOperator, cg

    diagonal = matrix.diagonal()
    diagonal = np.where(diagonal > 0.0, diagonal, 1.0)
    inverse = LinearOperator(matrix.shape, matvec=lambda y: y / diagonal)
    found, _ = cg(matrix, force, rtol=1e-6, maxiter=20 * round(len(force) ** 0.5), M=inverse)
    return np.asarray(found)
