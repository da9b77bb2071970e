"""Newton's method to where forces on some nodes balance.

Far from the equilibrium K is taken with its clamped part, which makes every step one downhill;
near it the exact K, where it is positive definite, converges quadratically. For elements, whose
clamped K costs most, the exact one is also tried far from equilibrium, until it is first
indefinite. Steps are cut to a tenth of the net or half a spring, because a net that is not yet
under tension resists hardly at all across its springs, and halved until the energy falls. Rigid
motions that cost no energy are left out of steps. (J. Nocedal, S. J. Wright, Numerical
Optimization, 2006, chapter 3.)

Near the equilibrium a factor serves as long as forces fall fast with it (chords; C. T. Kelley,
Iterative Methods for Linear and Nonlinear Equations, 1995, chapter 5). That of the end polishes
the equilibrium and shows its stability.

Shared arguments:
    balance: The free nodes and what acts on them.
    x: Positions of the free nodes [m], shape (free, 3).
    bars: The springs at these positions.
    force: Force on each free node [N], shape (free, 3).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tissuec.core.arrays import norm
from tissuec.core.signals import give_way
from tissuec.forces.springs.resting_springs import Bars
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.inverses import Indefinite, Iterations
from tissuec.mechanics.rigid import NeutralMotions
from tissuec.mechanics.stability import firm_inverse
from tissuec.mechanics.stiffness import Factorization
from tissuec.mechanics.turned_holders import after_turns
from tissuec.model.network import Floats

PRECISE = 1e-12  # of the largest force: what may be left of one that balances
NEAR = 1e-2  # of the largest force: from here on K is exact
SHIFT = 1e-9  # of the largest entry of K, where K may be singular
# The same where K is exact and indefinite: of motions that are a little unstable, its clamped
# part is many times too stiff.
STIFFER = (1e-7, 1e-5, 1e-3)
ROUNDS = 200
HALVINGS = 30
LEAVES = 2  # rounds in succession after which forces have grown: x leaves what was near
ROUGH, FINE = 0.1, 1e-3  # of forces: what a step that is not solved exactly leaves at most
CHORD = 0.3  # of the largest force: what a step with the last K leaves at most
CHORDS = 3  # steps with the last K that polish
STAYS = 1e-6  # of the size of the net: steps that are too short to change K and its stability
# Where loads are lost in rounding: residual forces of a piece over its loads; further rounds.
FAINT, FURTHER = 1e-2, 10
# Plain steps to an unstable equilibrium at most, and in succession without half the force.
PLAIN, STALLS = 12, 3
REACH = 0.1  # of the net: a step at most
SLOPE = 1e-4  # of what the slope foretells: by this the energy has to fall


class Reached(NamedTuple):
    """Where Newton's method ended.

    Attributes:
        x: Positions of the free nodes [m], shape (free, 3).
        is_balanced: Whether forces balance there.
        is_firm: Whether every motion that is not neutral is known to resist there.
    """

    x: Floats
    is_balanced: bool
    is_firm: bool = False


class Tangent(NamedTuple):
    """K⁻¹ at some place, with or without its clamped part, and the neutral motions there."""

    inverse: Factorization | Iterations
    neutral: NeutralMotions
    is_exact: bool

    def step(self, force: Floats, precision: float = 0.0) -> Floats | None:
        """Return the step that forces cause [m], shape (free, 3).

        None if K turns out not to be positive definite.

        Args:
            precision: What may be left of the forces, as a part, where they are not solved for
                exactly.
        """
        force = self.neutral.balanced(force)
        found = self.inverse.downhill(force.ravel(), precision)
        if found is None or not np.vdot(found, force) > 0.0:
            return None
        return self.neutral.without(found.reshape(-1, 3))


def descend(
    balance: Balance,
    x: Floats,
    rounds: int = ROUNDS,
    far: float = np.inf,
    worse: int = ROUNDS,
    *,
    looks: Callable[[Floats], bool] | None = None,
) -> Reached:
    """Return the result of Newton's method.

    Args:
        rounds: Steps at most.
        far: Way of a node from the start at which the search ends [m].
        worse: How often in succession the largest force may grow; see ``_Progress``.
        looks: Whether to end in an unstable equilibrium of elements, at places [m].
    """
    hopes, further, progress = balance.has_elements, FURTHER, _Progress(worse)
    tangent = settled = None
    for _ in range(rounds):
        give_way()
        bars = balance.bars(x)
        force = balance.force(bars)
        neutral = NeutralMotions.of(balance, x) if balance.holds_slides else None
        force = neutral.balanced(force) if neutral else force
        left, enough = greatest(force), allowed(balance, bars)
        if left <= enough:
            if not further or lost_in_rounding(balance, bars, force) is None:
                return polished(balance, x, bars, force)
            further, settled = further - 1, x  # forces may still fall below the bound
        precision = _precision(left, progress.before, enough)
        if not progress.goes_on(left):
            break
        balance.freeze(bars)
        near = left <= NEAR * balance.largest(bars)
        if near and (there := _by_chord(balance, x, force, tangent)) is not None:
            x = there
            continue
        bars = balance.bars(x)
        neutral = neutral or NeutralMotions.of(balance, x)
        tangent = None  # a single large matrix at a time
        made = _newton_step(balance, bars, neutral, force, precision, is_tried=near or hopes)
        if made is None:
            break
        step, is_exact, tangent = made
        progress.is_indefinite = not is_exact
        if looks is not None and hopes and not is_exact:
            there, asked, looks = _unstable(balance, x), looks, None
            if there is not None and asked(there):
                return Reached(there, is_balanced=True)
        hopes = hopes and (near or is_exact)
        found = downhill(balance, x, bars, force, step, expands=progress.expands)
        if found is None:
            break
        x = found
        if not greatest(x - balance.start) <= far:
            break
    if settled is None:
        return Reached(x, is_balanced=False)
    return polished(balance, settled, bars := balance.bars(settled), balance.force(bars))


class _Progress:
    """How the largest force changes from one step to the next.

    Args:
        worse: How often in succession it may grow, and four times as often not fall by half
            where K is indefinite.

    Attributes:
        before: Before the last step [N].
        grown: Steps in succession in which it grew.
        is_indefinite: Whether K was found to be indefinite last.
    """

    is_indefinite = False

    def __init__(self, worse: int):
        self._worse, self.before, self.grown = worse, np.inf, 0
        self._least, self._stays = np.inf, 0

    @property
    def expands(self) -> bool:
        """Return whether steps may be too short: where x leaves what was near."""
        return self.grown > LEAVES or self._stays > LEAVES

    def goes_on(self, left: float) -> bool:
        """Note the force that a step left [N]; return whether another one makes sense."""
        self.grown = self.grown + 1 if left > self.before else 0
        if left <= 0.5 * self._least:
            self._least, self._stays = left, 0
        self._stays += self.is_indefinite
        self.before = left
        return self.grown <= self._worse and self._stays <= 4 * self._worse


def _precision(left: float, before: float, enough: float) -> float:
    """Return the part of the forces that a step may leave, where it is not solved exactly.

    A step is solved as exactly as the last one made forces fall (S. C. Eisenstat, H. F. Walker,
    SIAM J. Sci. Comput. 17:16, 1996, choice 2).

    Args:
        left, before: Largest force here and before the last step [N].
        enough: One that counts as zero [N].
    """
    falls = min(left / before, 1.0) if np.isfinite(before) else 1.0
    return max(min(ROUGH, 0.9 * falls * falls), 0.1 * enough / left)


def _unstable(balance: Balance, x: Floats) -> Floats | None:
    """Return the equilibrium to which plain steps with an indefinite K lead from x.

    Steps downhill would leave it slowly, to whichever side rounding drives them.

    Returns:
        None if forces do not fall soon, or if it is above x or far from it.
    """
    least, stalls, start = np.inf, 0, x
    for _ in range(PLAIN):
        give_way()
        bars = balance.bars(x)
        force, neutral = balance.force(bars), NeutralMotions.of(balance, x)
        left = greatest(force)
        if left <= allowed(balance, bars):
            most, rounding = balance.energy(start, balance.bars(start))
            falls = balance.energy(x, balance.bars(x))[0] <= most + rounding
            is_near = greatest(x - start) <= REACH * float(np.ptp(start, axis=0).max())
            return x if is_near and falls else None
        stalls = 0 if left <= 0.5 * least else stalls + 1
        if stalls > STALLS or not np.isfinite(left):
            return None
        least = min(least, left)
        stiffness = balance.matrix(bars, exact=True)
        top = float(stiffness.diagonal().max(initial=0.0))
        try:
            inverse = balance.inverses.of(stiffness.plus(neutral.supports(top)))
            step = inverse.stationary(neutral.balanced(force).ravel())
        except (RuntimeError, Indefinite):
            return None
        x = x + neutral.without(step.reshape(-1, 3))
    return None


class LostLoads(NamedTuple):
    """A piece whose loads are not more than what rounding leaves of its forces.

    Attributes:
        node: The free node with its largest load.
        load: On this node [N].
        left: Largest residual force on a node of the piece [N].
    """

    node: int
    load: float
    left: float


def lost_in_rounding(balance: Balance, bars: Bars, force: Floats) -> LostLoads | None:
    """Return the piece whose loads rounding hides most; None without one."""
    loads, left = norm(balance.loads(bars)), norm(force)
    acts = loads > 0.0
    if balance.holds_slides or not acts.any():
        return None
    most_left = left.max()
    if most_left <= FAINT * loads[acts].min() or most_left > allowed(balance, bars):
        return None
    most, remains = np.zeros((2, int(balance.labels.max()) + 1))
    np.maximum.at(most, balance.labels, loads)
    np.maximum.at(remains, balance.labels, left)
    share = remains / np.where(most > 0.0, most, np.inf)
    worst = int(share.argmax())
    if share[worst] <= FAINT:
        return None
    own = np.where(balance.labels == worst, loads, -1.0)
    return LostLoads(int(own.argmax()), float(most[worst]), float(remains[worst]))


PROBE = 1e-6  # of the motion of held nodes: the difference by which their K is found


def predicted(balance: Balance, x: Floats, before: Floats) -> Floats:
    """Return where the free nodes come to if forces change as they do at first.

    K Δx = F(before) - K' Δx', where K' Δx' are the forces by the motion of held nodes. (T.
    Belytschko et al., Nonlinear Finite Elements for Continua and Structures, 2014, chapter 6.)
    Where holders have turned far, see ``after_turns``.

    Args:
        x: Where the free nodes are otherwise, which is the result if it has less energy.
        before: Where all nodes of the scene were before held ones moved [m], shape (node, 3).
    """
    bars = balance.bars(x)
    energy, _ = balance.energy(x, bars)
    turned = after_turns(balance, before, bars.position)
    if turned is not None and balance.energy(turned, balance.bars(turned))[0] < energy:
        return turned
    moved = bars.position - before
    moved[balance.free] = across = balance.held_part(moved[balance.free])
    start = before[balance.free]
    there = balance.bars_at(before)
    balance.freeze(there)
    force = balance.force(there)
    nearby = balance.force(balance.bars_at(before + PROBE * moved))
    force = force + (nearby - force) / PROBE
    neutral = NeutralMotions.of(balance, start)
    made = tangent_at(balance, there, neutral, force, ROUGH**2, matrices=(True, False))
    if made is None:
        return x
    found = start + across + made[1]
    return found if balance.energy(found, balance.bars(found))[0] < energy else x


def _newton_step(
    balance: Balance, bars: Bars, neutral: NeutralMotions, force: Floats, precision: float,
    *, is_tried: bool,
) -> tuple[Floats, bool, Tangent | None] | None:  # fmt: skip
    """Return a step downhill [m], whether K is exact, and K⁻¹ if chords can follow.

    Args:
        neutral: Rigid motions that cost no energy.
        precision: As of ``Tangent.step``.
        is_tried: Whether the exact K is tried first.
    """
    matrices = (True, False) if is_tried else (False,)
    made = tangent_at(balance, bars, neutral, force, precision, matrices=matrices)
    if made is None:
        return None
    tangent, step = made
    return step, tangent.is_exact, tangent if tangent.inverse.repeats else None


def _by_chord(
    balance: Balance, x: Floats, force: Floats, tangent: Tangent | None
) -> Floats | None:
    """Return the places after a step with the last K; None if too much force is left there.

    Args:
        tangent: Of the last K; None if another step would cost as much as the first.
    """
    step = tangent.step(force) if tangent is not None else None
    if step is None:
        return None
    there = x + step
    after = balance.force(balance.bars(there))
    if balance.holds_slides:
        after = NeutralMotions.of(balance, there).balanced(after)
    return there if greatest(after) <= CHORD * greatest(force) else None


def polished(balance: Balance, x: Floats, bars: Bars, force: Floats) -> Reached:
    """Return the equilibrium after exact steps, as long as forces [N] become smaller.

    Soft motions may still be far from their equilibrium when forces are already small.
    """
    neutral, inverse = NeutralMotions.of(balance, x), None
    if not balance.holds_slides:
        inverse = firm_inverse(balance, x, bars)
    is_firm = inverse is not None
    if inverse is not None:
        tangent = Tangent(inverse, neutral, is_exact=True)
        step = tangent.step(force, FINE)
    else:
        made = tangent_at(balance, bars, neutral, force, FINE, matrices=(True, False))
        tangent, step = made or (None, None)
    start = x
    for further in reversed(range(CHORDS)):
        if tangent is None or step is None:
            break
        there = x + step
        after = balance.force(balance.bars(there))
        if not greatest(after) < greatest(force):
            break
        x, force = there, after
        if not (further and tangent.inverse.repeats):
            break
        step = tangent.step(force, FINE)
    stays = greatest(x - start) <= STAYS * float(np.ptp(x, axis=0).max(initial=0.0))
    return Reached(x, is_balanced=True, is_firm=is_firm and stays)


def allowed(balance: Balance, bars: Bars) -> float:
    """Return the largest force at a node that counts as zero [N], for rounding above all."""
    return PRECISE * balance.largest(bars) + balance.noise(bars)


def greatest(force: Floats) -> float:
    """Return the largest magnitude of some forces [N]."""
    return float(np.sqrt((force * force).sum(axis=1).max(initial=0.0)))


def tangent_at(
    balance: Balance,
    bars: Bars,
    neutral: NeutralMotions,
    force: Floats,
    precision: float,
    *,
    matrices: tuple[bool, ...],
) -> tuple[Tangent, Floats] | None:
    """Return K⁻¹ at some places of the springs, and the step downhill that it gives [m].

    Args:
        neutral: Rigid motions that cost no energy.
        precision: As of ``Tangent.step``.
        matrices: Whether K is exact, for each that is tried.

    Returns:
        None if no matrix is positive definite.
    """
    for is_exact in matrices:
        give_way()
        stiffness = balance.matrix(bars, exact=is_exact)
        top = float(stiffness.diagonal().max(initial=0.0))
        for shift in (0.0, *STIFFER) if is_exact else (SHIFT,):
            try:
                supports = neutral.supports(top) + shift * top
                inverse = balance.inverses.of(stiffness.plus(supports))
                tangent = Tangent(inverse, neutral, is_exact and not shift)
                step = tangent.step(force, precision)
            except RuntimeError:  # singular
                continue
            if step is not None:
                return tangent, step
    return None


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
    reach = max(0.5 * balance.longest(bars), REACH * float(np.ptp(x, axis=0).max()))
    size = greatest(step)
    part = 1.0 if size <= reach else reach / size
    energy, _ = balance.energy(x, bars)
    slope = float(np.vdot(force, step))
    for _ in range(HALVINGS):
        give_way()
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
