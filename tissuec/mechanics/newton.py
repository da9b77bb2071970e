"""Newton's method for the minimum of the energy, with a line search.

Far from the equilibrium K is taken with its clamped part, which makes every step one downhill;
near it the exact K, where it is positive definite, converges quadratically. For elements, whose
clamped K costs most, the exact one is also tried far from equilibrium, until it is first
indefinite. Steps are cut to a tenth of the net or half a spring, because a net that is not yet
under tension resists hardly at all across its springs, and halved until the energy falls. Rigid
motions that cost no energy are left out of steps. (J. Nocedal, S. J. Wright, Numerical
Optimization, 2006, chapter 3.)

Shared arguments:
    balance: The free nodes and what acts on them.
    x: Positions of the free nodes [m], shape (free, 3).
    bars: The springs at these positions.
    force: Force on each free node [N], shape (free, 3).
"""

import numpy as np

from tissuec.forces.resting_springs import Bars
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.rigid import NeutralMotions
from tissuec.mechanics.stiffness import Factorization, Stiffness
from tissuec.model.network import Floats

PRECISE = 1e-12  # of the largest force: what may be left of one that balances
NEAR = 1e-2  # of the largest force: from here on K is exact
SHIFT = 1e-9  # of the largest entry of K, where K may be singular
ROUNDS = 200
HALVINGS = 30
LEAVES = 2  # rounds in succession after which forces have grown: x leaves what was near
SLOPE = 1e-4  # of what the slope foretells: by this the energy has to fall


def descend(
    balance: Balance,
    x: Floats,
    rounds: int = ROUNDS,
    far: float = np.inf,
    worse: int = ROUNDS,
) -> tuple[Floats, bool]:
    """Return the result of Newton's method [m], shape (free, 3), and whether it balances.

    Args:
        rounds: Steps at most.
        far: Way of a node from the start at which the search ends [m].
        worse: How often in succession the largest force may grow.
    """
    hopes, grown, before = balance.has_elements, 0, np.inf
    for _ in range(rounds):
        bars = balance.bars(x)
        force = balance.force(bars)
        if is_balanced(balance, bars, force):
            return polished(balance, x, bars, force), True
        grown, before = grown + 1 if greatest(force) > before else 0, greatest(force)
        if grown > worse:
            break
        balance.freeze(bars)
        near = greatest(force) <= NEAR * balance.largest(bars)
        neutral = NeutralMotions.of(balance, x)
        step = None
        if hopes and not near:
            step = direction(balance, bars, neutral, force, matrices=(True,))
            hopes = step is not None
        if step is None:
            matrices = (True, False) if near else (False,)
            step = direction(balance, bars, neutral, force, matrices=matrices)
        if step is None:
            return x, False
        found = downhill(balance, x, bars, force, step, expands=grown > LEAVES)
        if found is None:
            return x, False
        x = found
        if not greatest(x - balance.start) <= far:
            break
    return x, False


def polished(balance: Balance, x: Floats, bars: Bars, force: Floats) -> Floats:
    """Return the positions after one more exact step, if forces are smaller there.

    Soft motions may still be far from their equilibrium when forces are already small.
    """
    neutral = NeutralMotions.of(balance, x)
    step = direction(balance, bars, neutral, force, matrices=(True, False))
    if step is None:
        return x
    after = balance.force(balance.bars(x + step))
    return x + step if greatest(after) < greatest(force) else x


def is_balanced(balance: Balance, bars: Bars, force: Floats) -> bool:
    """Return whether the force on every node is zero within tolerance and rounding."""
    allowed = PRECISE * balance.largest(bars) + balance.noise(bars)
    return greatest(force) <= allowed


def greatest(force: Floats) -> float:
    """Return the largest magnitude of some forces [N]."""
    return float(np.sqrt((force * force).sum(axis=1).max(initial=0.0)))


def direction(
    balance: Balance,
    bars: Bars,
    neutral: NeutralMotions,
    force: Floats,
    *,
    matrices: tuple[bool, ...],
) -> Floats | None:
    """Return a step downhill without neutral motions [m], shape (free, 3).

    Args:
        neutral: Rigid motions that cost no energy.
        matrices: Whether K is exact, for each that is tried.

    Returns:
        The step, None if no matrix gives one.
    """
    force = neutral.balanced(force)
    for matrix in matrices:
        stiffness = balance.matrix(bars, exact=matrix)
        top = float(stiffness.diagonal().max(initial=0.0))
        shift = 0.0 if matrix else SHIFT * top
        step = _solved(stiffness.plus(neutral.supports(top) + shift), force)
        if step is not None:
            return neutral.without(step)
    return None


def _solved(matrix: Stiffness, force: Floats) -> Floats | None:
    """Return K⁻¹ F, shape (free, 3); None if K is not positive definite."""
    try:
        factor = Factorization(matrix)
    except RuntimeError:  # singular
        return None
    step = factor.solve(force.ravel()).reshape(-1, 3)
    return step if factor.is_definite and np.vdot(step, force) > 0.0 else None


def downhill(
    balance: Balance,
    x: Floats,
    bars: Bars,
    force: Floats,
    step: Floats,
    *,
    expands: bool = False,
) -> Floats | None:
    """Return the positions along a step at which the energy is lower [m], shape (free, 3).

    Args:
        step: Displacement of each free node [m], shape (free, 3).
        expands: Whether the step is doubled while the energy falls on.

    Returns:
        The positions, None if the energy falls nowhere along the step.
    """
    spring = float(np.maximum(bars.length, balance.springs.rest).max(initial=0.0))
    reach = max(0.5 * spring, 0.1 * float(np.ptp(x, axis=0).max()))
    size = greatest(step)
    part = 1.0 if size <= reach else reach / size
    energy, _ = balance.energy(x, bars)
    slope = float(np.vdot(force, step))
    for _ in range(HALVINGS):
        there = x + part * step
        after, rounding = balance.energy(there, balance.bars(there))
        if after - energy <= -SLOPE * part * slope + rounding:
            break
        part *= 0.5
    else:
        return None
    while expands and 2.0 * part * size <= reach:
        further = x + 2.0 * part * step
        energy, _ = balance.energy(further, balance.bars(further))
        if not energy < after:
            break
        there, after, part = further, energy, 2.0 * part
    return there
