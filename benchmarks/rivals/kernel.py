"""The engine's compiled forces as y' = f(t, y), for solvers that are not ours.

The unknowns are displacements from the drawing and velocities of the free nodes, each
coordinate beside its own velocity, in the order of nodes that keeps matrices narrow.
"""

from collections.abc import Callable
from ctypes import CFUNCTYPE, c_double, c_void_p
from functools import cache

import numpy as np
from scipy import sparse

from tissuec.analysis.bench_solvers import Deadline
from tissuec.compiled.loading import address
from tissuec.compiled.record_tables import RecordTable
from tissuec.core.structs import replace
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.operations import operations
from tissuec.engine.rate import Unknowns
from tissuec.kernels.records import Floats, Integers
from tissuec.mechanics.state import State

Rate = Callable[[float, int, int], None]
OPERATIONS = ("force", "place")


class Kernel:
    """The equations of motion of a net until the next event or knot.

    Args:
        layout: Of the network; it is updated to the state.
        state: Where the stretch begins.
        until: The next event [s].

    Attributes:
        start, stop: The stretch [s].
        evaluations: How often the forces were asked for.
    """

    def __init__(self, layout: KernelInputs, state: State, until: float):
        layout.update(state)
        self.start, self.stop = state.time, layout.next_knot(state.time, until)
        layout.start, layout.until = self.start, self.stop
        self._layout, self.evaluations = layout, 0
        slot = layout.solver().slot
        self.nodes = np.flatnonzero(slot >= 0)[np.argsort(slot[slot >= 0])]
        self._origin = layout.inwards(state.network.position)
        still = np.where((~layout.free & ~layout.moved)[:, None], 0.0, state.velocity)
        self._x, self._v = layout.inwards(state.position), layout.inwards(still)
        needed = replace(layout.features, watched=False, crushed=False, ledger=False)
        called = operations(frozenset(OPERATIONS), needed)
        net = layout.net(INTEGRATORS["dop853"])
        self._net = RecordTable(net._replace(operations=called))
        y = np.zeros(6 * len(self.nodes))
        scratch = self._x, self._v, np.zeros_like(self._x), np.zeros(2)
        self._unknowns = Unknowns(y, np.zeros_like(y), self._origin, self.nodes, *scratch)
        self._table = RecordTable(self._unknowns)

    @property
    def initial(self) -> Floats:
        """Return the unknowns at the start [m], [m/s], shape (6 free,)."""
        moved, speed = self._x - self._origin, self._v
        pairs = np.stack([moved.reshape(-1, 3)[self.nodes], speed.reshape(-1, 3)[self.nodes]])
        return pairs.transpose(1, 2, 0).ravel()

    def fill(self, time: float, y: Floats, out: Floats) -> None:
        """Set ``out`` to y' at a time."""
        self.evaluations += 1
        self._unknowns.y[:] = y
        compiled_rate()(time, self._table.address, self._net.address)
        out[:] = self._unknowns.rate

    def function(self, deadline: Deadline) -> Callable[[float, Floats], Floats]:
        """Return f(t, y); it raises OutOfTime behind a deadline."""

        def f(time: float, y: Floats) -> Floats:
            deadline.check()
            out = np.empty_like(y)
            self.fill(time, y, out)
            return out

        return f

    def leave(self, state: State, y: Floats) -> None:
        """Set a state to the unknowns at the stop."""
        free = self._layout.layout.order[self.nodes]
        pairs = y.reshape(-1, 3, 2)
        state.time = self.stop
        state.position[free] = state.network.position[free] + pairs[..., 0]
        state.velocity[free] = pairs[..., 1]
        state.place_held()

    def positions(self, rows: Floats, position: Floats) -> None:
        """Set the free nodes of positions [m] to those of unknowns.

        Args:
            rows: Unknowns, shape (row, 6 free).
            position: Shape (row, node, 3); only free nodes are written.
        """
        free = self._layout.layout.order[self.nodes]
        drawn = self._layout.state.network.position[free]
        position[:, free] = drawn + rows.reshape(len(rows), -1, 3, 2)[..., 0]

    @property
    def half_band(self) -> int:
        """How far from its diagonal the Jacobian reaches, within the matrix."""
        low, high = self._coupled
        return min(6 * int(np.abs(low - high).max(initial=0)) + 5, len(self.initial) - 1)

    @property
    def sparsity(self) -> sparse.csr_matrix:
        """Return the pattern of the Jacobian, shape (6 free, 6 free)."""
        low, high = self._coupled
        own = np.arange(len(self.nodes))
        rows, columns = np.concatenate([[low, high], [high, low], [own, own]], axis=1)
        shape = (len(own), len(own))
        blocks = sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=shape)
        return sparse.csr_matrix(sparse.kron(blocks, np.ones((6, 6))))

    @property
    def _coupled(self) -> tuple[Integers, Integers]:
        """Return the free ends of springs between free nodes, as numbers of unknown nodes."""
        slot, (low, high) = self._layout.solver().slot, self._layout.springs.ends.T
        both = (slot[low] >= 0) & (slot[high] >= 0)
        return slot[low[both]], slot[high[both]]


@cache
def compiled_rate() -> Rate:
    """Return ``rate``, of a time [s] and the addresses of ``Unknowns`` and a net."""
    return CFUNCTYPE(None, c_double, c_void_p, c_void_p)(address("rate", "rate"))
