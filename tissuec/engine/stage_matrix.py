"""The matrix of an implicit step: the part of springs, and that of fields.

    S = M + q (D + drag) + q² K + W Wᵀ,        q = h γ

K is the exact stiffness of springs and fields where S is positive definite with it, and
otherwise that without the parts that may make it indefinite; D is the viscosity. W has a column
for each large enclosed volume (``mechanics.stiffness``). Internal variables of springs and
elements are eliminated (``forces.memory``), and nodes on planes of symmetry stay there. S is
factorised as a sparse matrix; where its factor would be too large, conjugate gradients are used
instead.

The compiled loop over steps calls ``assemble`` and ``solve`` in place of those for springs.

Of a spring of direction n, length L and tension T, K takes f' n nᵀ + T/L (1 - n nᵀ), and D the
slope ∂g/∂w of its dashpot along n. Branches and flow have equations of their own (``memory``).
"""

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix, diags_array

from tissuec.core.arrays import dot, norm
from tissuec.core.signals import give_way
from tissuec.engine.layout import Layout
from tissuec.engine.unknowns import Fill, SolvingCost
from tissuec.forces.matrices import assembled, summed
from tissuec.forces.memory import ELIMINATION_SECONDS, Condensed, MemoryTangents
from tissuec.forces.springs.springs import SpringForce, flat, pulled, reach
from tissuec.kernels.records import Net, Solver
from tissuec.mechanics.guiding import free_projection
from tissuec.mechanics.state import State
from tissuec.mechanics.stiffness import ConjugateGradients, Factorization, Stiffness
from tissuec.model.network import Floats

# Time of making the matrix, of each field in it besides, and of springs, per spring; of a
# factor per multiplication; of a solution, and of one per number of the factor; of some rounds
# of conjugate gradients, per node [s].
MAKING, FIELD, SPRING = 1.3e-3, 1.5e-3, 2e-6
MULTIPLICATION, CALL, NUMBER = 4e-10, 6e-5, 1e-9
ROUNDS, PRODUCT = 50, 5e-7


class StageMatrix:
    """S of a state until its next event.

    Args:
        state: Read whenever S is made.
        layout: Places of the nodes.
    """

    def __init__(self, state: State, layout: Layout):
        self._state, self._layout, free = state, layout, state.free
        self._free, self._embedding = np.flatnonzero(free), state.coupling
        self._number = number = np.where(free, np.cumsum(free) - 1, -1)
        self._reduction = None  # T with x = T x_free of free and embedded nodes that move
        if self._embedding is not None:
            self._number, self._reduction = self._embedding.reduction(free)
        self._mass = state.inertia[self._free]
        self._drag = state.lumped(state.braking)[self._free]
        self._fields = state.fields
        self._acting, guides = state.acting, state.guides
        within = guides and free_projection(guides, number, len(self._free))
        self._within = within
        self._made: tuple[float, float, bytes, bytes] | None = None
        self._factor: Factorization | ConjugateGradients | None = None
        self._memories: tuple[Condensed, ...] = ()

    @cached_property
    def fill(self) -> Fill:
        """Return the size of the factor."""
        return Fill.of(self._state.free, self._acting.springs.ends, self._fields)

    @cached_property
    def cost(self) -> SolvingCost:
        """Return the predicted times."""
        making = MAKING + SPRING * len(self._acting.springs.ends)
        making += sum(FIELD + field.matrix_seconds for field in self._fields)
        solution = CALL + sum(ELIMINATION_SECONDS * len(f.internal_rows) for f in self._fields)
        if self.fill.is_small:
            making += MULTIPLICATION * self.fill.multiplications
            return SolvingCost(making, solution + NUMBER * self.fill.numbers)
        return SolvingCost(making, solution + ROUNDS * PRODUCT * len(self._free))

    def assemble(self, q: float, x: Floats, v: Floats, net: Net, solver: Solver) -> bool:
        """Make S at a state; return False if there is none that is positive definite.

        Args:
            q: Step size times the coefficient of the method [s].
            x, v: Of all nodes [m], [m/s], in the order of the loop, flat, shape (3 node,).
            net: What acts on the nodes.
            solver: Its time is read.

        Raises:
            Halted: A signal ends the run, and the step has taken long.
        """
        give_way()
        time = float(solver.made[3])
        made = q, time, x.tobytes(), v.tobytes()
        if made == self._made:
            return True
        self._made = None
        position, velocity = self._layout.of_nodes(x), self._layout.outwards(v)
        if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
            return False
        try:
            with np.errstate(all="ignore"):  # of nodes that went far away
                self._memories = tuple(
                    Condensed(each, q) for each in self._memory(time, position, velocity)
                )
                found = self._is_made(q, time, position, velocity)
        except np.linalg.LinAlgError:  # of what are no numbers
            return False
        self._made = made if found else None
        return found

    def _is_made(self, q: float, time: float, position: Floats, velocity: Floats) -> bool:
        """Make S, and return whether it is positive definite; arguments as of ``assemble``."""
        # Relaxation within the step may make S indefinite where K is not exact.
        for exact, relaxes in ((True, True), (False, True), (False, False)):
            if not exact and relaxes and not self._memories:
                continue
            matrix = self._matrix(q, time, position, velocity, exact=exact, relaxes=relaxes)
            if not np.isfinite(matrix.sparse.data).all():
                return False
            if self._is_factorised(matrix):
                return True
        return False

    def solve(self, vector: Floats, net: Net, solver: Solver) -> bool:
        """Replace residuals of accelerations by their corrections, solved with S.

        Args:
            vector: [m/s²], in the order of the loop, flat, shape (3 node,); changed in place.
            net: What acts on the nodes.
            solver: Without effect.

        Raises:
            Halted: As ``assemble``.
        """
        give_way()
        assert self._factor is not None
        residual, free = self._layout.outwards(vector), self._free
        force = np.zeros_like(residual)
        force[free] = self._mass[:, None] * residual[free]
        found = [each.enter(residual.reshape(-1), force) for each in self._memories]
        if self._embedding is not None:
            force = self._embedding.shared(force)
        right = force[free].ravel()
        if self._within is not None:
            right = self._within @ right
        change = np.zeros_like(residual)
        moved = self._factor.solve(right)
        change[free] = moved.reshape(-1, 3)
        if self._embedding is not None:
            self._embedding.follow(change)
        for each, own in zip(self._memories, found, strict=True):
            each.leave(own, change.reshape(-1))
        vector[:] = self._layout.inwards(change)
        return bool(np.isfinite(moved).all())

    def _is_factorised(self, matrix: Stiffness) -> bool:
        """Make the factor of a matrix; return whether it is positive definite."""
        if not self.fill.is_small:
            self._factor = ConjugateGradients(matrix)
            return self._factor.is_definite
        try:
            self._factor = Factorization(matrix)
        except RuntimeError:  # singular
            return False
        return self._factor.is_definite

    def _memory(
        self, time: float, position: Floats, velocity: Floats
    ) -> Iterator[MemoryTangents]:
        """Yield the derivatives of the internal variables of springs and fields."""
        # Springs between held nodes relax, too.
        springs = self._state.at(time).spring_force(np.flatnonzero(self._state.alive_springs))
        own = memory_of_springs(springs, position, velocity)
        every = (field.memory_tangents(position, velocity) for field in self._fields)
        yield from (each for each in (own, *every) if each is not None)

    def _springs(self, time: float) -> SpringForce:
        """Return the springs that act, with the rest lengths of a time [s]."""
        if not self._state.reelings:
            return self._acting
        return self._state.at(time).acting

    def _matrix(
        self,
        q: float,
        time: float,
        position: Floats,
        velocity: Floats,
        *,
        exact: bool,
        relaxes: bool,
    ) -> Stiffness:
        """Return S [kg].

        Args:
            q, time, position, velocity: As those of ``assemble``, in the order of the network.
            exact: Whether K is exact, and positive semidefinite otherwise.
            relaxes: Whether internal variables change within the step.
        """
        number, size = self._number, int(self._number.max(initial=-1)) + 1
        springs = self._springs(time)
        blocks = stage_blocks(springs, q, position, velocity, exact=exact)
        parts = [assembled(blocks, number[springs.springs.ends], size)]
        wide = [np.zeros((3 * size, 0))]
        for field in self._fields:
            acting = field.recalling(velocity)
            sparse, beside = acting.split(time, position, number, size, exact=exact)
            parts.append(q * q * sparse)
            wide.append(q * beside)
            slow = field.damping_matrices(position, velocity, number, size)
            if slow is not None:
                parts.append(q * slow[1])
        if relaxes:
            parts += [memory.matrix(number, size) for memory in self._memories]
        total, every = summed(parts, size), np.hstack(wide)
        if self._reduction is not None:
            total = self._reduction.T @ total @ self._reduction
            every = np.asarray(self._reduction.T @ every)
        if self._within is not None:
            total, every = self._within @ total @ self._within, self._within @ every
        mass = np.repeat(self._mass + q * self._drag, 3)
        return Stiffness(csc_matrix(total + diags_array(mass, format="csc")), every)


class _Motion(NamedTuple):
    """Of springs: directions, lengths, elongations without flow, and rates of lengthening."""

    direction: Floats
    length: Floats
    stretch: Floats
    elongation: Floats
    closing: Floats


def _motion(force: SpringForce, position: Floats, velocity: Floats) -> _Motion:
    springs = force.springs
    gap = reach(springs.ends, position)
    length = norm(gap)
    direction = gap / np.where(length > 0.0, length, 1.0)[:, None]
    closing = dot(direction, reach(springs.ends, velocity))
    stretch = length - springs.rest
    memory = springs.inelastic
    elongation = stretch if memory is None else stretch - memory.flowed(flat(velocity))
    return _Motion(direction, length, stretch, elongation, closing)


def stage_blocks(
    force: SpringForce, q: float, position: Floats, velocity: Floats, *, exact: bool
) -> Floats:
    """Return q D + q² K of each spring between its ends [kg], shape (spring, 2, 3, 2, 3).

    Internal variables are taken as fixed.

    Args:
        force: Of springs that act.
        q: Step size times the coefficient of the method [s].
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        exact: Whether to include the negative stiffness of springs that are compressed or
            soften.
    """
    behaviour, memory = force.springs.behaviour, force.springs.inelastic
    now = _motion(force, position, velocity)
    tension = pulled(behaviour, memory, now.stretch, flat(velocity))
    if behaviour.is_viscous:
        tension = tension + behaviour.brake(now.elongation, now.closing)
    steep = behaviour.slope(now.elongation) + behaviour.brake_by_e(now.elongation, now.closing)
    if memory is not None:
        steep = steep + memory.sudden
    along = q * behaviour.brake_slope(now.elongation, now.closing) + q * q * steep
    has_direction = now.length > 0.0
    across = q * q * tension / np.where(has_direction, now.length, np.inf)
    if not exact:
        along, across = np.maximum(along, 0.0), np.maximum(across, 0.0)
    # What has no direction has no force either.
    along, across = (
        np.where(has_direction & np.isfinite(each), each, 0.0) for each in (along, across)
    )
    block = (along - across)[:, None, None] * (
        now.direction[:, :, None] * now.direction[:, None, :]
    )
    block += across[:, None, None] * np.eye(3)
    signs = np.array([[1.0, -1.0], [-1.0, 1.0]])
    return np.einsum("ab,sxy->saxby", signs, block)


def memory_of_springs(
    force: SpringForce, position: Floats, velocity: Floats
) -> MemoryTangents | None:
    """Return the derivatives of branches and flow, with springs as items; None without any.

    Args:
        force: Of springs that act.
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
    """
    memory, behaviour = force.springs.inelastic, force.springs.behaviour
    if memory is None or not memory.remembers.any():
        return None
    remembers = np.flatnonzero(memory.remembers)
    own = SpringForce(force.springs.some(remembers), force.alive[remembers])
    memory, behaviour = own.springs.inelastic, own.springs.behaviour
    assert memory is not None
    now = _motion(own, position, velocity)
    pull = pulled(behaviour, memory, now.stretch, flat(velocity))
    branches, count = len(memory.constant), len(remembers)
    has = memory.slot >= 0
    steep = behaviour.slope(now.elongation) + memory.sudden
    yields = has[-1] & (np.abs(pull) > memory.limit)
    pace = np.where(has[:-1], 1.0 / memory.time, 0.0)
    flow = np.where(yields, 1.0 / memory.viscosity, 0.0)
    giving = np.zeros((count, branches + 1, branches + 1))
    each = np.arange(branches)
    giving[:, each, each] = pace.T
    giving[:, :-1, -1] = np.where(has[-1], pace, 0.0).T
    giving[:, -1, :-1] = (memory.constant * flow).T
    giving[:, -1, -1] = steep * flow
    by_length = np.concatenate([pace, (steep * flow)[None]]).T
    braked = behaviour.brake_by_e(now.elongation, now.closing)
    of_flow = np.where(has[-1], steep + braked, 0.0)
    # Of the tension by the variables; all of them are then as states keep them.
    by_variable = -np.concatenate([memory.constant, of_flow[None]]).T
    rate = np.where(has, memory.rate, 1.0).T
    ways = np.stack([-now.direction, now.direction], axis=1)
    return MemoryTangents(
        slots=np.ascontiguousarray(memory.slot.T),
        nodes=own.springs.ends.astype(np.int64),
        giving=giving * rate[:, :, None] / rate[:, None, :],
        by_position=(rate * by_length)[:, :, None, None] * ways[:, None],
        pull=-ways[..., None] * (by_variable / rate)[:, None, None, :],
    )
