"""Spring constants that make a net an isotropic elastic solid, whatever its mesh.

Central springs of constants k, from node to node along unit vectors n, lengths L apart, stand
for a solid with Poisson's ratio 1/4, as the tensor of their stiffness is symmetric in all four
indices (Cauchy):

    C_ijkl = μ (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk).

Stretched evenly by ε, they pull at a node with Σ k L n_i n_j n_k ε_jk. A solid that is
stretched evenly rests under the traction C_ijkl ε_jk N_l of its boundary, N being the outward
area that a node represents there, and without any inside. So a net passes the patch test of
finite elements (B. M. Irons and A. Razzaque, 1972) for every ε if

    Σ k L n_i n_j n_k = - μ (δ_ij N_k + δ_ik N_j + δ_jk N_i)    at every node.

Fibres along f that add β f f f f to C add -β f_i f_j f_k f_l N_l to the right-hand side. These
linear equations are solved for k ≥ 0 in the sense of least squares, drawn towards springs that
share the volume around their ends evenly.
"""

from itertools import combinations_with_replacement, permutations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.matter.fibres import Fibres
from tissuec.matter.linear import conjugate_gradients
from tissuec.matter.solid import Solid
from tissuec.matter.traction import POISSON
from tissuec.model.network import Floats

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Pairs = NDArray[np.int32]

YOUNG = 2.0 * (1.0 + POISSON)  # of a solid of springs whose shear modulus is 1
#: Weight of the even share, beside the equations: of crystals, which nearly fulfil these, and
#: those to choose from elsewhere. With a small one, nets that are far from it keep too few
#: springs inside, and give way.
CRYSTAL, IRREGULAR = 1e-3, (0.03, 0.3, 1.0)
ROUNDS = 20  # of choosing the springs that are left out
ROUGH, FINE = 1e-4, 1e-9  # residuals of equations, first and at last
MOST = 5000  # iterations of solving them
#: The entries of a symmetric tensor of three indices, and how often each occurs in it.
TRIPLES = np.array(list(combinations_with_replacement(range(3), 3)))
TIMES = np.array([len(set(permutations(triple))) for triple in TRIPLES.tolist()])


def fitted(
    position: Floats,
    ends: Pairs,
    solid: Solid,
    fibres: Fibres | None = None,
    weight: float = CRYSTAL,
) -> Floats:
    """Return the constants of springs per shear modulus [m], shape (spring,).

    They pass the patch test as nearly as they can.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        solid: The solid that the nodes represent.
        fibres: In it, if there are any.
        weight: Of the even share.
    """
    along = position[ends[:, 1]] - position[ends[:, 0]]
    start = _even(along, ends, solid)
    matrix, wanted = _equations(along, ends, solid, start, fibres)
    return start * _not_negative(matrix, wanted, weight)


def _even(along: Floats, ends: Pairs, solid: Solid) -> Floats:
    """Return constants of springs that share the volume of their nodes evenly, (spring,).

    Of springs that have a volume V, Σ k L² / V is C_iijj = 15 μ.
    """
    degree = np.bincount(ends.ravel(), minlength=len(solid.volume))
    volume = (solid.volume / np.maximum(degree, 1))[ends].sum(axis=1)
    return np.asarray(15.0 * volume / np.einsum("si,si->s", along, along))


def _equations(
    along: Floats, ends: Pairs, solid: Solid, start: Floats, fibres: Fibres | None
) -> tuple["csr_matrix", Floats]:
    """Return the equations of the patch test for multiples of some spring constants.

    They are divided by the area that a node represents, and count by its volume.
    """
    from scipy.sparse import csr_matrix

    length = np.linalg.norm(along, axis=1)
    n = along / length[:, None]
    i, j, k = TRIPLES.T
    triple = (start * length)[:, None] * np.sqrt(TIMES) * n[:, i] * n[:, j] * n[:, k]
    size = solid.volume ** (-1.0 / 6.0)
    count = len(TRIPLES)
    rows = (ends.astype(np.int64)[:, :, None] * count + np.arange(count)).ravel()
    values = np.stack([triple * size[ends[:, :1]], -triple * size[ends[:, 1:]]], axis=1)
    columns = np.repeat(np.arange(len(ends)), 2 * count)
    shape = (len(size) * count, len(ends))
    matrix = csr_matrix((values.ravel(), (rows, columns)), shape=shape)
    unit, outward = np.eye(3), solid.outward
    traction = (
        unit[i, j] * outward[:, k] + unit[i, k] * outward[:, j] + unit[j, k] * outward[:, i]
    )
    if fibres is not None:  # μ is 1 here
        f = fibres.direction
        traction += YOUNG * fibres.added * (f[i] * f[j] * f[k]) * (outward @ f)[:, None]
    return matrix, (-traction * np.sqrt(TIMES) * size[:, None]).ravel()


def _not_negative(matrix: "csr_matrix", wanted: Floats, weight: float) -> Floats:
    """Return x ≥ 0 for which A x is next to b, drawn to 1, by pivoting in blocks.

    (L. F. Portugal, J. J. Júdice, L. N. Vicente, Math. Comp. 63:625, 1994.)
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import aslinearoperator

    squares = np.asarray(matrix.multiply(matrix).sum(axis=0), dtype=float).ravel()
    pull = weight**2 * squares
    diagonal = squares + pull
    right = matrix.T @ wanted + pull
    used, x = np.ones(len(squares), dtype=bool), np.ones(len(squares))
    # Which ones are left out is nearly clear long before their last digits are.
    for precise in ROUGH, FINE:
        for _ in range(ROUNDS):
            x[~used] = 0.0
            inner, own = aslinearoperator(matrix[:, used]), diags(pull[used])
            normal = inner.T @ inner + aslinearoperator(own)
            x[used] = conjugate_gradients(
                normal, diagonal[used], right[used], x[used], precise, MOST
            )
            slope = matrix.T @ (matrix @ x) + pull * x - right
            wrong = (used & (x < 0.0)) | (~used & (slope < -FINE * diagonal))
            if not wrong.any():
                break
            used ^= wrong
    return np.maximum(x, 0.0)
