"""The matrix of an implicit step on NumPy and SciPy, for the interpreted tier.

What it is stands in ``banded``. Nets of wide band are solved by SciPy's sparse factor, since
the interpreted tier steps small nets only.
"""

from typing import Any

import numpy as np

from tissuec.kernels.records import Floats, Solver
from tissuec.kernels.scalar import STIFFEST, TINY
from tissuec.kernels.vector import VectorNet


def assemble(q: float, x: Floats, v: Floats, net: VectorNet, solver: Solver) -> bool:
    """Make S and its factor at a state; return False if S is not positive definite."""
    from scipy.linalg.lapack import dpbtrf  # pyright: ignore[reportAttributeAccessIssue]

    if net.matrix is None:
        net.matrix = Matrix(net, solver)
    values = net.matrix.values(q, x, v, net)
    if not np.isfinite(values).all():
        return False
    if not net.matrix.size:
        return True
    if solver.scratch.size:
        return net.matrix.factorise(values)
    solver.band[:] = values.reshape(solver.band.shape)
    factor, failure = dpbtrf(solver.band.T, lower=1, overwrite_ab=1)
    solver.band[:] = factor.T
    return failure == 0


def solve(vector: Floats, net: VectorNet, solver: Solver) -> bool:
    """Replace residuals of accelerations r by S⁻¹ M r; held nodes get zero."""
    from scipy.linalg.lapack import dpbtrs  # pyright: ignore[reportAttributeAccessIssue]

    matrix = net.matrix
    if not matrix.size:
        vector[:] = 0.0
        return True
    right = vector[matrix.free] / net.inverse_mass[matrix.free]
    if not solver.scratch.size:
        right[matrix.order] = dpbtrs(solver.band.T, right[matrix.order], lower=1)[0]
    else:
        right = matrix.factor.solve(right)
    vector[:] = 0.0
    vector[matrix.free] = right
    return True


class Matrix:
    """Where the entries of S go.

    Args:
        net: What acts.
        solver: Whose band, if any, is to be filled.
    """

    factor: Any  # of SciPy, where there is no band

    def __init__(self, net: VectorNet, solver: Solver):
        slot = solver.slot
        self.free = np.flatnonzero(np.repeat(slot >= 0, 3))
        self.order = np.argsort((3 * slot[slot >= 0][:, None] + np.arange(3)).ravel())
        self.size = len(self.free)
        self.low, self.high = net.low[0] // 3, net.high[0] // 3
        here, there = slot[self.low], slot[self.high]
        self.banded = not solver.scratch.size
        if self.banded:
            rows, columns = self._blocks(here, there)
        else:
            # In the order of the nodes: SciPy finds an order of its own.
            number = np.where(slot >= 0, np.cumsum(slot >= 0) - 1, -1)
            rows, columns = self._blocks(number[self.low], number[self.high])
        diagonal = np.arange(self.size)
        rows, columns = np.append(rows, diagonal), np.append(columns, diagonal)
        self.kept = (columns >= 0) & (rows >= columns if self.banded else rows >= 0)
        self.rows, self.columns = rows[self.kept], columns[self.kept]
        if self.banded:
            self.place = self.columns * solver.band.shape[1] + self.rows - self.columns
            self.length = solver.band.size

    @staticmethod
    def _blocks(here: Any, there: Any) -> tuple[Any, Any]:
        """Return rows and columns of four blocks per spring; negative for held nodes."""
        a, b = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
        pairs = ((here, here), (there, there), (here, there), (there, here))
        unheld = [(one >= 0) & (two >= 0) for one, two in pairs]
        rows = [
            np.where(both, 3 * one, -9)[None, None] + a[..., None]
            for both, (one, _) in zip(unheld, pairs, strict=True)
        ]
        columns = [
            np.where(both, 3 * two, -9)[None, None] + b[..., None]
            for both, (_, two) in zip(unheld, pairs, strict=True)
        ]
        return np.concatenate([part.ravel() for part in rows]), np.concatenate(
            [part.ravel() for part in columns]
        )

    def values(self, q: float, x: Floats, v: Floats, net: VectorNet) -> Floats:
        """Return the entries of S: of the whole band, or of the sparse matrix."""
        r = x[net.high] - x[net.low]
        length = np.sqrt(np.einsum("ij,ij->j", r, r))
        inverse = 1.0 / (length + TINY)
        n = r * inverse
        along = q * net.damping + q * q * net.stiffness
        across = q * q * net.stiffness * np.maximum(1.0 - net.rest * inverse, 0.0)
        if not net.behaviour.is_linear:
            closing = np.einsum("ij,ij->j", n, v[net.high] - v[net.low])
            e = length - net.rest
            viscous = np.clip(net.behaviour.brake_slope(e, closing), 0.0, STIFFEST)
            steep = net.behaviour.slope(e) + net.behaviour.brake_by_e(e, closing)
            steep = np.maximum(steep, 0.0)
            along = q * viscous + q * q * steep
            pull = net.behaviour.pull(e)
            across = q * q * np.maximum(pull * inverse, 0.0)
            across = np.where(length + net.rest == 0.0, q * q * steep, across)
        block = (along - across) * n[:, None] * n[None, :] + across * np.eye(3)[..., None]
        mass = 1.0 / net.inverse_mass[self.free] + q * net.drag[self.free]
        if self.banded:
            # The order of the diagonal does not matter: all three places of a node are equal.
            mass = mass[self.order]
        parts = [block.ravel(), block.ravel(), -block.ravel(), -block.ravel(), mass]
        values = np.concatenate(parts)[self.kept]
        if self.banded:
            return np.bincount(self.place, values, self.length).astype(float, copy=False)
        return values

    def factorise(self, values: Floats) -> bool:
        """Factorise the sparse matrix; return False if it is singular."""
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        shape = (self.size, self.size)
        try:
            self.factor = splu(csc_matrix((values, (self.rows, self.columns)), shape=shape))
        except RuntimeError:
            return False
        return True
