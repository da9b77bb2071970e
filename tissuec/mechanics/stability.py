"""Stability of an equilibrium: the motion about it that resists least.

The energy is at a minimum where the smallest eigenvalue of K, rigid motions that cost nothing
aside, is positive. Where it is negative, the least disturbance grows: a pressed column buckles.
(S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 1961, chapter 2.)
"""

from typing import Any, cast

import numpy as np
from msgspec import Struct
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from tissuec.core.arrays import irregular
from tissuec.core.signals import give_way
from tissuec.forces.springs.resting_springs import Bars
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.inverses import Indefinite, Iterations
from tissuec.mechanics.rest import LOOSE
from tissuec.mechanics.rigid import NeutralMotions
from tissuec.mechanics.state import State
from tissuec.mechanics.stiffness import Factorization, Stiffness
from tissuec.model.network import Floats

# Rounds of Lanczos's method, of some twenty solutions each: five times what was needed at most.
SEARCHES = 30
LARGEST = 6000  # unknowns up to which a net at rest is examined: about a second


class SoftestMotion(Struct, frozen=True, eq=False):
    """The motion about an equilibrium that the net resists least.

    Attributes:
        resists: Its stiffness over the largest there is; negative where the net would buckle.
        shape: How the free nodes move in it, shape (free, 3).
    """

    resists: float
    shape: Floats

    def node(self, balance: Balance) -> int:
        """Return the node that moves most."""
        return int(balance.free[np.argmax((self.shape**2).sum(axis=1))])


def firm_inverse(balance: Balance, x: Floats, bars: Bars) -> Factorization | Iterations | None:
    """Return K⁻¹ at x [m], shape (free, 3), if every motion that is not neutral resists.

    That is so if K without ``LOOSE`` of the stiffest, which is inverted, has positive pivots
    alone. Of n neutral motions, each is held at one unknown. If K is positive then, it is so
    where these do not move, and has no more than n eigenvalues that are not (R. Courant's
    principle): those of the neutral motions.
    """
    neutral = NeutralMotions.of(balance, x, np.ones(len(x)))
    matrix, top = _resistance(balance, bars)
    try:
        found = balance.inverses.of(matrix.shift(neutral.supports(top) - LOOSE * top))
    except RuntimeError:  # singular
        return None
    return found if found.is_definite else None


def is_firm(balance: Balance, x: Floats) -> bool:
    """Return whether every motion at x [m], shape (free, 3), that is not neutral resists."""
    return firm_inverse(balance, x, balance.bars(x)) is not None


def _resistance(balance: Balance, bars: Bars) -> tuple[Stiffness, float]:
    """Return K, and the largest stiffness of a node without negative parts [N/m]."""
    matrix = balance.matrix(bars, exact=True)
    # Clamped matrices of elements cost more than all else here, and are as stiff.
    clamped = matrix if balance.has_elements else balance.matrix(bars, exact=False)
    return matrix, float(clamped.diagonal().max(initial=0.0))


def softest(balance: Balance, x: Floats, count: int = 1) -> tuple[SoftestMotion, ...]:
    """Return the softest motions at x [m], shape (free, 3), that are not neutral, in order.

    Nothing where there are none, or where they were not found.
    """
    bars, size = balance.bars(x), 3 * len(x)
    matrix, top = _resistance(balance, bars)
    neutral = NeutralMotions.of(balance, x, np.ones(len(x)))
    if neutral.count >= size:
        return ()
    below = -balance.weakening(bars) - 1e-3 * top
    start = irregular(3 * len(balance.free))

    def project(vector: Floats) -> Floats:
        return neutral.without(vector.reshape(-1, 3)).ravel()

    try:
        solve = balance.inverses.of(matrix.plus(np.full(size, -below))).solve

        def inverted(b: Floats) -> Floats:
            give_way()
            return project(solve(project(b)))

        inverse = LinearOperator((size, size), inverted)
        whole = LinearOperator((size, size), matrix)
        more = {"v0": project(start), "OPinv": inverse, "maxiter": SEARCHES}
        most = min(count, size - 1)
        values, shapes = cast(Any, eigsh)(whole, k=most, sigma=below, **more)
    except (ArpackError, Indefinite, RuntimeError):
        return ()
    return tuple(
        SoftestMotion(float(values[one]) / top, _forwards(shapes[:, one]).reshape(-1, 3))
        for one in np.argsort(values)
    )


def _forwards(shape: Floats) -> Floats:
    """Return a motion or its opposite: the first that moves much, moves forwards.

    This rule says to which side a net buckles.
    """
    size = np.abs(shape)
    return shape * np.sign(shape[int(np.argmax(size > 0.9 * size.max()))])


def unstable_node(state: State) -> int | None:
    """Return the node that moves most as the net buckles; None where its rest is stable.

    None as well for nets of more than ``LARGEST`` unknowns, which are not examined.

    Args:
        state: At rest, with held nodes where they belong; not changed.
    """
    balance = Balance(state, np.ones(state.network.node_count, dtype=bool))
    if not 0 < 3 * len(balance.free) <= LARGEST:
        return None
    balance.freeze(balance.bars(balance.start))
    if is_firm(balance, balance.start):
        return None
    found = softest(balance, balance.start)
    return found[0].node(balance) if found and found[0].resists <= -LOOSE else None
