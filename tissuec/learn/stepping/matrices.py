"""The matrices of implicit steps: how accelerations change with places and velocities."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import sparse

from tissuec.laws import Law
from tissuec.laws.formula import Formula
from tissuec.laws.partial import constant_name
from tissuec.learn.stepping import Act
from tissuec.network import Floats


class Matrices:
    """Makes matrices for a net with some laws, the first of which is linear."""

    def __init__(self, laws: Sequence[Law]):
        self.laws = laws

    def solver(self, act: Act, x: Floats, v: Floats, own: float) -> sparse.csc_matrix:
        """Return 1 - own² ∂a/∂x - own ∂a/∂v, shape (3 node, 3 node)."""
        by_x, by_v = self.derivatives(act, x, v)
        one = sparse.identity(len(x), format="csc")
        return sparse.csc_matrix(one - own * own * by_x - own * by_v)

    def derivatives(
        self, act: Act, x: Floats, v: Floats
    ) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return ∂a/∂x [1/s²] and ∂a/∂v [1/s], shape (3 node, 3 node)."""
        links, values = act.links, act.values
        place, speed = x.reshape(-1, 3), v.reshape(-1, 3)
        reach, closing = (part[links.high] - part[links.low] for part in (place, speed))
        length = np.sqrt(np.einsum("sk,sk->s", reach, reach))
        inverse = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
        n = reach * inverse[:, None]
        w = np.einsum("sk,sk->s", n, closing)
        tension, steep, brisk = self._springs(act, length, w)
        across = tension * inverse
        whole = (length == 0.0) & (values.rest[links.spring] == 0.0)
        across[whole] = steep[whole]
        line = steep[:, None] * n + (brisk * inverse)[:, None] * (closing - w[:, None] * n)
        outer = n[:, :, None] * n[:, None, :]
        by_place = n[:, :, None] * line[:, None, :]
        by_place += across[:, None, None] * (np.eye(3) - outer)
        by_speed = brisk[:, None, None] * outer
        drag = sparse.diags(np.repeat(links.drag * links.inverse, 3))
        return self._between(act, by_place), self._between(act, by_speed) - drag

    def _springs(self, act: Act, length: Floats, w: Floats) -> tuple[Floats, Floats, Floats]:
        """Return tension [N], stiffness [N/m] and viscosity [N s/m] of the springs that act."""
        links, values = act.links, act.values
        c, d, rest = (
            part[links.spring] for part in (values.stiffness, values.damping, values.rest)
        )
        e = length - rest
        tension, steep, brisk = c * e + d * w, c.copy(), d.copy()
        for number, law in enumerate(self.laws[1:], start=1):
            chosen = links.law == number
            known = {constant_name(i): value for i, value in enumerate(values.constants)}
            known |= {"c": c[chosen], "d": d[chosen], "rest": rest[chosen]}
            known |= {"e": e[chosen], "w": w[chosen]}
            tension[chosen] = _at(law.elastic, known) + _at(law.viscous, known)
            steep[chosen] = _at(law.elastic.slope("e") + law.viscous.slope("e"), known)
            brisk[chosen] = _at(law.viscous.slope("w"), known)
        return tension, steep, brisk

    @staticmethod
    def _between(act: Act, blocks: Floats) -> sparse.csr_matrix:
        """Return the matrix of what blocks between two nodes do to accelerations."""
        low, high, inverse = act.links.low, act.links.high, act.links.inverse
        axes = np.arange(3)
        rows, columns, entries = [], [], []
        for at, by, sign in (
            (low, low, -1.0),
            (low, high, 1.0),
            (high, low, 1.0),
            (high, high, -1.0),
        ):
            shape = blocks.shape
            rows.append(np.broadcast_to(3 * at[:, None, None] + axes[:, None], shape).ravel())
            columns.append(np.broadcast_to(3 * by[:, None, None] + axes, shape).ravel())
            entries.append((sign * inverse[at][:, None, None] * blocks).ravel())
        size = 3 * len(inverse)
        parts = np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_matrix(sparse.coo_matrix(parts, shape=(size, size)))


def _at(formula: Formula, known: Mapping[str, Floats]) -> Floats:
    """Return the values of a formula of some springs, shape (spring,)."""
    return np.asarray(formula.at(known), dtype=float)
