"""Largest angular frequency and damping of a network, from its matrices.

Stiffness and damping act on M^-1/2: the largest eigenvalues of M^-1/2 K M^-1/2 and of
M^-1/2 D M^-1/2, found by the method of Lanczos from a fixed start, without forming a matrix.
Sums over the springs of each node bound them, at the cost of a single round.
"""

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np
from msgspec import Struct

from tissuec.core.arrays import irregular
from tissuec.forces.effects import Resisting
from tissuec.mechanics.observables import lengths
from tissuec.mechanics.state import State
from tissuec.model.network import Floats

MARGIN = 1.05  # an iteration that stops early lies a little low
LEAST_ROUNDS, ROUNDS = 5, 50
CLOSE = 5e-3  # growth of the eigenvalue in a round, as a part of it, that ends the iteration
MOST_DAMPED = 1e100  # damping ratio: above, nothing changes but that squares overflow
NOTHING = 1e-12  # of an image, as a part of the eigenvalue, that is rounding only


def spectral_radius(state: State) -> float:
    """Return ω̂ [1/s], a bound of the angular frequencies of small motions about the state."""
    now, position, velocity = state.time, state.position, state.velocity
    parts = [state.acting.stiffening(position, velocity)]
    effects = (effect.recalling(velocity) for effect in state.effects)
    parts += filter(None, (effect.stiffening(now, position) for effect in effects))
    # Where nothing swings, what only gives way is taken for a motion of damping ratio 1.
    return sqrt(_largest(parts, state)) or 0.5 * _giving(state)


def damping_radius(state: State) -> float:
    """Return λ̂ [1/s], a bound of the rates at which all that brakes does, and springs yield."""
    position, velocity = state.position, state.velocity
    each = [state.acting.braking(position, velocity)]
    each += (effect.braking(position) for effect in state.effects)
    parts = list(filter(None, each))
    # Both together may be as fast as their sum, and are no faster.
    return _giving(state) + (_largest(parts, state) if parts else 0.0)


def _giving(state: State) -> float:
    """Return a bound of the rates at which springs and fields relax and yield [1/s]."""
    springs = state.spring_force(np.flatnonzero(state.alive_springs)).giving(state.position)
    fields = (field.giving(state.position, state.velocity) for field in state.fields)
    return max(springs, *fields, 0.0)


class SumsAtNodes(Struct, frozen=True, eq=False):
    """Sums over the springs of each node, divided by its mass; zero for held nodes.

    Attributes:
        damping: Σ d / m [1/s], shape (node,).
        stiffness: Σ c / m [1/s²], shape (node,).
    """

    damping: Floats
    stiffness: Floats

    @property
    def most_damped(self) -> float:
        """Return the damping ratio of the node of the largest Σ d / m, if it moved alone."""
        if not self.damping.any():
            return 0.0
        worst = int(self.damping.argmax())
        square = float(self.stiffness[worst])
        return float(self.damping[worst]) / (2.0 * sqrt(square)) if square > 0.0 else 0.0

    @property
    def fastest(self) -> float:
        """Return a bound of the angular frequency of linear springs [1/s].

        By Gershgorin's theorem ω² ≤ 2 max Σ c / m; T / L of those under tension is below c.
        """
        return sqrt(2.0 * float(self.stiffness.max(initial=0.0)))

    @property
    def damping_ratio(self) -> float:
        """Return a bound of λ / 2ω of the net, infinite if nothing is stiff.

        By Gershgorin's theorem λ ≤ 2 max Σ d / m; ω² is no less than an eigenvalue of the block
        of any node, the largest of which is a third of its trace Σ c / m or more.
        """
        least = float(self.stiffness.max(initial=0.0)) / 3.0
        most = float(self.damping.max(initial=0.0))
        return (most / sqrt(least) if least > 0.0 else inf) if most else 0.0


def sums_at_nodes(state: State) -> SumsAtNodes:
    """Return the sums for springs of their present lengths, with dashpots at rest."""
    ends, alive = state.springs.ends, state.alive_springs
    behaviour, count = state.springs.behaviour, state.network.node_count
    elongation = lengths(ends, state.position) - behaviour.rest

    coupling, free, divisor = state.coupling, state.free, state.divisor

    def at_nodes(each: Floats) -> Floats:
        each = np.where(alive, each, 0.0)
        if not each.any():
            return np.zeros(count)
        both = np.bincount(ends[:, 0], each, count) + np.bincount(ends[:, 1], each, count)
        if coupling is not None:
            both = coupling.shared(both)
        return np.where(free, both / divisor, 0.0)

    return SumsAtNodes(
        at_nodes(behaviour.sluggishness(elongation, 0.0 * elongation)),
        at_nodes(behaviour.steepness(elongation)),
    )


def may_be_overdamped(state: State, sums: SumsAtNodes, ratio: float) -> bool:
    """Return whether the fastest motion may have more than a damping ratio.

    Args:
        sums: Of the state.
        ratio: λ / 2ω.
    """
    only_springs = all(effect.braking(state.position) is None for effect in state.effects)
    return not (only_springs and not state.network.relaxes and sums.damping_ratio <= ratio)


def damping_ratio(omega: float, damping: float) -> float:
    """Return the damping ratio ζ = λ / 2ω, dimensionless; at most so much that squares exist.

    Args:
        omega: ω [1/s].
        damping: λ [1/s].
    """
    ratio = damping / (2.0 * omega) if omega else 0.0
    return ratio if ratio < MOST_DAMPED else MOST_DAMPED  # which includes what is no number


def _largest(parts: Sequence[Resisting], state: State) -> float:
    """Return a little more than the largest eigenvalue, by the method of Lanczos.

    G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th edition 2013, section 10.1: in the
    space of all images so far the operator is tridiagonal.

    Args:
        parts: Whose sum is scaled by the roots of masses on both sides.
        state: Of the masses; embedded nodes follow their hosts.
    """
    root = np.where(state.free, 1.0 / np.sqrt(state.divisor), 0.0)[:, None]
    count, embedding = len(root), state.coupling
    z = irregular(3 * count).reshape(count, 3)
    z *= root > 0.0
    last, size, value = np.zeros_like(z), sqrt(_inner(z, z)), 0.0
    diagonal: list[float] = []
    beside: list[float] = []
    with np.errstate(all="ignore"):  # of resistances that are infinite
        while size > NOTHING * value and len(diagonal) < ROUNDS:
            z /= size
            moved, image = z * root, np.zeros_like(z)
            if embedding is not None:
                embedding.follow(moved)
            for resist in parts:
                resist(moved, image)
            if embedding is not None:
                image = embedding.shared(image)
            image *= root
            diagonal.append(_inner(z, image))
            image -= diagonal[-1] * z
            if beside:
                image -= beside[-1] * last
            before, value = value, _top(diagonal, beside)
            if len(diagonal) > LEAST_ROUNDS and value - before < CLOSE * value:
                break
            last, z, size = z, image, sqrt(_inner(image, image))
            beside.append(size)
    return MARGIN * value


def _inner(one: Floats, other: Floats) -> float:
    """Return the inner product; BLAS would add in an order that depends on its threads."""
    return float(np.add.reduce((one * other).ravel()))


def _top(diagonal: list[float], beside: list[float]) -> float:
    """Return the largest eigenvalue of a symmetric tridiagonal matrix."""
    matrix = np.diag(diagonal) + np.diag(beside, -1)  # the lower half is enough
    return float(np.linalg.eigvalsh(matrix)[-1])
