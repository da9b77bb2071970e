"""The matrix of an implicit step of nets that contain more than springs.

    S = M + q (D + drag) + q² K + W Wᵀ,        q = h γ

K is the exact stiffness of springs and fields where S is positive definite with it, and
otherwise that without the parts that may make it indefinite; D is the viscosity. W has a column
for each large enclosed volume (``mechanics.stiffness``). Internal variables of springs and
elements are eliminated (``forces.memory``), and nodes on planes of symmetry stay there. S is
factorised as a sparse matrix; where its factor would be too large, conjugate gradients are used
instead.

The compiled loop over steps calls ``assemble`` and ``solve`` in place of those for springs.
"""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, diags_array

from tissuec.engine.layout import Layout
from tissuec.engine.unknowns import Fill, SolvingCost
from tissuec.forces.matrices import assembled
from tissuec.forces.memory import ELIMINATION_SECONDS, Condensed, MemoryTangents
from tissuec.forces.spring_matrices import memory_of_springs, stage_blocks
from tissuec.forces.springs import SpringForce
from tissuec.kernels.records import Net, Solver
from tissuec.mechanics.conjugate_gradients import ConjugateGradients
from tissuec.mechanics.state import State
from tissuec.mechanics.stiffness import Factorization, Stiffness
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
        held: Which nodes are held or driven, shape (node,).
        layout: Places of the nodes.
    """

    def __init__(self, state: State, held: NDArray[np.bool_], layout: Layout):
        self._state, self._layout, self._held = state, layout, held
        self._free = np.flatnonzero(~held)
        self._number = np.where(held, -1, np.cumsum(~held) - 1)
        self._mass, self._drag = state.mass[self._free], state.braking[self._free]
        self._fields = state.fields
        self._acting, planes = state.acting, state.symmetry
        within = planes and planes.projection(self._number, len(self._free))
        self._within = within
        self._made: tuple[float, float, bytes, bytes] | None = None
        self._factor: Factorization | ConjugateGradients | None = None
        self._memories: tuple[Condensed, ...] = ()

    @cached_property
    def fill(self) -> Fill:
        """Return the size of the factor."""
        return Fill.of(~self._held, self._acting.springs.ends, self._fields)

    @cached_property
    def cost(self) -> SolvingCost:
        """Return the predicted times."""
        making = MAKING + SPRING * len(self._acting.springs.ends)
        making += sum(FIELD + field.matrix_seconds for field in self._fields)
        solution = CALL + sum(ELIMINATION_SECONDS * len(f.hidden) for f in self._fields)
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
        """
        time = float(solver.made[3])
        made = q, time, x.tobytes(), v.tobytes()
        if made == self._made:
            return True
        self._made = None
        position, velocity = self._layout.outwards(x), self._layout.outwards(v)
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
        """
        assert self._factor is not None
        residual, free = self._layout.outwards(vector), self._free
        force = np.zeros_like(residual)
        force[free] = self._mass[:, None] * residual[free]
        found = [each.enter(residual.reshape(-1), force) for each in self._memories]
        right = force[free].ravel()
        if self._within is not None:
            right = self._within @ right
        change = np.zeros_like(residual)
        moved = self._factor.solve(right)
        change[free] = moved.reshape(-1, 3)
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
        springs = self._state.at(time).spring_force(np.flatnonzero(self._state.alive))
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
        number, size = self._number, len(self._free)
        springs = self._springs(time)
        blocks = stage_blocks(springs, q, position, velocity, exact=exact)
        total = csc_matrix(assembled(blocks, number[springs.springs.ends], size))
        wide = [np.zeros((3 * size, 0))]
        for field in self._fields:
            acting = field.recalling(velocity)
            sparse, beside = acting.split(time, position, number, size, exact=exact)
            total = total + q * q * csc_matrix(sparse)
            wide.append(q * beside)
            slow = field.damping_matrices(position, velocity, number, size)
            if slow is not None:
                total = total + q * csc_matrix(slow[1])
        for memory in self._memories if relaxes else ():
            total = total + csc_matrix(memory.matrix(number, size))
        every = np.hstack(wide)
        if self._within is not None:
            total, every = self._within @ total @ self._within, self._within @ every
        mass = np.repeat(self._mass + q * self._drag, 3)
        return Stiffness(csc_matrix(total + diags_array(mass, format="csc")), every)
