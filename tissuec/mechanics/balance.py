"""Forces, energy and stiffness of a net at rest, as functions of positions of some nodes.

    E(x) = Σ ∫ f(e) de + energy of enclosed volumes - Σ p·x        F = -∂E/∂x        K = ∂²E/∂x²

with p the weight and the external forces of this moment. Jets belong to p as well, though what
they do depends on x: E takes it as it was where ``freeze`` was called last. Dashpots and drag
do not act, because nothing moves; branches have given way, and rest lengths stay as they have
flowed. K has, for each spring of direction u and tension T = f(L - L0),

    f' u uᵀ + T/L (1 - u uᵀ),

both of whose parts are clamped at zero where the exact one would not be positive (J. Teran,
E. Sifakis, G. Irving, R. Fedkiw, Symp. Computer Animation 2005, p. 181).
"""

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.laws.evaluation import Behaviour
from tissuec.mechanics.observables import applied_forces, rest_lengths
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.mechanics.stiffness import Stiffness

ROUNDING = 16.0 * float(np.finfo(float).eps)


class Bars(NamedTuple):
    """State of springs at given positions of the nodes.

    Attributes:
        direction: Unit vectors, shape (spring, 3); zero where the length is.
        length: [m], shape (spring,).
        tension: [N], shape (spring,); zero where the length is.
        position: Of all nodes of the scene [m], shape (node, 3).
    """

    direction: Floats
    length: Floats
    tension: Floats
    position: Floats


class NodeSprings(NamedTuple):
    """Some of the free nodes with the springs at them.

    Attributes:
        nodes: Numbers among the free nodes, shape (n,).
        springs: Places among the springs that act, shape (spring,).
        rows: Place of either end of these among ``nodes``, -1 for others, shape (spring, 2).
        behaviour: Of these springs.
    """

    nodes: Indices
    springs: Indices
    rows: Indices
    behaviour: Behaviour


class Balance:
    """The nodes of a state that may move, and what acts on them now.

    Args:
        state: Read once, now, with its held nodes where they belong.
        chosen: Which nodes may move, unless somebody holds them, shape (node,).

    Attributes:
        free: The nodes that may move, ascending, shape (free,).
        ends: Free node at either end of each spring that acts, -1 for one that stays, shape
            (spring, 2).
        behaviour: Of these springs.
        outer_ends: The same as numbers among all nodes of the scene, shape (spring, 2).
        rest: Their rest lengths with what they flowed [m], shape (spring,).
        mass: Of the free nodes [kg], shape (free,).
        load: Weight and external force on each free node [N], shape (free, 3).
    """

    def __init__(self, state: State, chosen: NDArray[np.bool_]):
        is_free = chosen & ~state.held
        self.free: Indices = np.flatnonzero(is_free)
        ends = state.springs.ends
        resists = (state.springs.stiffness > 0.0) | (state.springs.law > 0)
        acts = state.alive & resists & is_free[ends].any(axis=1)
        self.outer_ends = ends[acts]
        number = np.where(is_free, np.cumsum(is_free) - 1, -1)
        self.ends = number[self.outer_ends]
        self._springs = np.flatnonzero(acts)
        self._every = state.springs
        self.behaviour = state.springs.some(self._springs).behaviour
        self.rest = rest_lengths(state, state.velocity, np.flatnonzero(acts))
        self.mass = state.mass[self.free]
        self.load = applied_forces(state)[self.free]
        self._number, self._time = number, state.time
        self._fields = state.fields
        self._position = state.position.copy()
        self._start = self._position[self.free]
        self._jets = tuple(state.jets.values())
        self._blown = np.zeros_like(self._start)

    @property
    def start(self) -> Floats:
        """Return where the free nodes are in the state [m], shape (free, 3)."""
        return self._start.copy()

    @property
    def present_load(self) -> Floats:
        """Return weight, external forces and jets on the free nodes [N], shape (free, 3)."""
        return self.load + self._blown

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return which free nodes contact or a force ties to something, shape (free,).

        Args:
            position: Of all nodes of the scene [m], shape (node, 3).
        """
        found = np.zeros(len(position), dtype=bool)
        for acting in self._fields:
            found |= acting.touched(position)
        return found[self.free]

    def bars(self, x: Floats) -> Bars:
        """Return the state of the springs with the free nodes at x [m], shape (free, 3)."""
        position = self._position
        position[self.free] = x
        reach = position[self.outer_ends[:, 1]] - position[self.outer_ends[:, 0]]
        length = np.sqrt(np.einsum("sk,sk->s", reach, reach))
        has_direction = length > 0.0
        direction = reach / np.where(has_direction, length, 1.0)[:, None]
        tension = np.where(has_direction, self.behaviour.pull(length - self.rest), 0.0)
        return Bars(direction, length, tension, position.copy())

    def force(self, bars: Bars) -> Floats:
        """Return the sum of all forces on the free nodes [N], shape (free, 3)."""
        total = self.load.copy()
        pull = bars.tension[:, None] * bars.direction
        for end, sign in ((0, 1.0), (1, -1.0)):
            moves = self.ends[:, end] >= 0
            np.add.at(total, self.ends[moves, end], sign * pull[moves])
        if self._fields:
            pressed, rest = np.zeros_like(bars.position), np.zeros_like(bars.position)
            for acting in self._fields:
                acting.add_forces(self._time, bars.position, rest, pressed)
            total += pressed[self.free]
        return total

    def star(self, nodes: Indices) -> NodeSprings:
        """Return some free nodes, given by numbers of shape (n,), with the springs at them."""
        row = np.full(len(self.free) + 1, -1)  # the last is that of ends that stay
        row[nodes] = np.arange(len(nodes))
        rows = row[self.ends]
        springs = np.flatnonzero((rows >= 0).any(axis=1))
        own = self._every.some(self._springs[springs])
        chosen = own.behaviour.with_rest(self.rest[springs])
        return NodeSprings(nodes, springs, rows[springs], chosen)

    def force_on(self, star: NodeSprings, x: Floats) -> Floats:
        """Return the sum of all forces on some nodes [N], shape (n, 3).

        Args:
            x: Where all free nodes are [m], shape (free, 3).
        """
        if self._fields:
            return self.force(self.bars(x))[star.nodes]
        position = self._position
        position[self.free] = x
        first, second = self.outer_ends[star.springs].T
        reach = position[second] - position[first]
        length = np.sqrt(np.einsum("sk,sk->s", reach, reach))
        tension = star.behaviour.pull(length - star.behaviour.rest)
        pull = (tension / np.where(length > 0.0, length, np.inf))[:, None] * reach
        total = self.load[star.nodes]
        for end, sign in ((0, 1.0), (1, -1.0)):
            moves = star.rows[:, end] >= 0
            np.add.at(total, star.rows[moves, end], sign * pull[moves])
        return total

    def freeze(self, bars: Bars) -> None:
        """Set the force of jets in the energy to their present force."""
        if self._jets:
            pushed, rest = np.zeros_like(bars.position), np.zeros_like(bars.position)
            for jet in self._jets:
                jet.add_forces(self._time, bars.position, rest, pushed)
            self._blown = pushed[self.free]

    def energy(self, x: Floats, bars: Bars) -> tuple[float, float]:
        """Return the energy and a bound of its rounding error [J].

        The work of loads is zero at the positions of the free nodes in the state.

        Args:
            x: Positions of the free nodes [m], shape (free, 3).
            bars: The springs at these positions.
        """
        elastic = self.behaviour.energy(bars.length - self.rest)
        done = self.present_load * (x - self._start)
        pressed = sum(float(e.energy(self._time, bars.position)) for e in self._fields)
        total = float(elastic.sum() - done.sum()) + pressed
        spoilt = bars.length * np.abs(bars.tension)
        sizes = elastic.sum() + np.abs(done).sum() + spoilt.sum() + pressed
        sizes += sum(acting.spread(self._time, bars.position) for acting in self._fields)
        return total, ROUNDING * float(sizes)

    def noise(self, bars: Bars) -> float:
        """Return what rounding may leave of a force that balances [N]."""
        place = float(np.abs(self._position).max(initial=0.0))
        steep = np.abs(self.behaviour.slope(bars.length - self.rest))
        reach = bars.length + self.rest + place
        noise = ROUNDING * float((steep * reach).max(initial=0.0))
        return noise + ROUNDING * sum(
            acting.noise(self._time, bars.position) for acting in self._fields
        )

    def largest(self, bars: Bars) -> float:
        """Return the largest force of a spring or load [N], by which residuals are judged."""
        load = np.sqrt((self.load**2).sum(axis=1)).max(initial=0.0)
        return max(float(np.abs(bars.tension).max(initial=0.0)), float(load))

    def pressing(self, bars: Bars) -> Floats:
        """Return how strongly enclosed volumes may resist each free node [N/m], shape (free,).

        Gershgorin's bound by the rows of their part of K.
        """
        size = len(self.free)
        total = np.zeros(3 * size)
        for acting in self._fields:
            sparse, wide = acting.split(self._time, bars.position, self._number, size)
            total += np.asarray(abs(sparse).sum(axis=1)).ravel()
            total += np.abs(wide) @ np.abs(wide).sum(axis=0)
        return total.reshape(-1, 3).max(axis=1)

    def weakening(self, bars: Bars) -> float:
        """Return how far below zero pressed springs may bring an eigenvalue of K [N/m].

        Their part of K is -T/L across two nodes each; Gershgorin's bound over the nodes.
        """
        pressed = np.maximum(-bars.tension, 0.0) / np.where(bars.length > 0.0, bars.length, 1.0)
        total = np.zeros(len(self.free))
        for end in (0, 1):
            moves = self.ends[:, end] >= 0
            np.add.at(total, self.ends[moves, end], 2.0 * pressed[moves])
        where = bars.position, self._number, len(self.free)
        turning = sum(acting.weakening(self._time, *where) for acting in self._fields)
        return float(total.max(initial=0.0)) + turning

    def matrix(self, bars: Bars, *, exact: bool) -> "Stiffness":
        """Return K [N/m], shape (3 free, 3 free).

        Args:
            exact: Whether pressed springs weaken the net; otherwise K is positive semidefinite.
        """
        from scipy.sparse import coo_matrix, csc_matrix

        from tissuec.mechanics.stiffness import Stiffness

        size = len(self.free)
        own = self.entries(bars, exact=exact)
        values: list[Floats] = [own[0]]
        rows: list[NDArray[np.integer]] = [own[1]]
        columns: list[NDArray[np.integer]] = [own[2]]
        wide = [np.zeros((3 * size, 0))]
        for acting in self._fields:
            sparse, beside = acting.split(
                self._time, bars.position, self._number, size, exact=exact
            )
            values.append(np.asarray(sparse.data, dtype=float))
            rows.append(sparse.row)
            columns.append(sparse.col)
            wide.append(beside)
        where = np.concatenate(rows), np.concatenate(columns)
        total = coo_matrix((np.concatenate(values), where), shape=(3 * size, 3 * size))
        return Stiffness(csc_matrix(total), np.hstack(wide))

    def entries(self, bars: Bars, *, exact: bool) -> tuple[Floats, Indices, Indices]:
        """Return the contributions of springs to K [N/m], with their rows and columns.

        All three arrays have the shape (entry,); entries of one place add up.

        Args:
            bars: The springs at the positions of interest.
            exact: As of ``matrix``.
        """
        has_direction = bars.length > 0.0
        steep = self.behaviour.slope(bars.length - self.rest)
        if not exact:
            steep = np.maximum(steep, 0.0)
        across = bars.tension / np.where(has_direction, bars.length, 1.0)
        if not exact:
            across = np.maximum(across, 0.0)
        # What has no direction resists in all of them.
        across = np.where(has_direction, across, steep)
        along = np.where(has_direction, steep - across, 0.0)
        block = along[:, None, None] * np.einsum("si,sj->sij", bars.direction, bars.direction)
        block += across[:, None, None] * np.eye(3)
        moves, sign, row, column = self._blocks
        return (sign[:, None, None] * block[moves]).ravel(), row, column

    @cached_property
    def _blocks(self) -> tuple[Indices, Floats, Indices, Indices]:
        """Return blocks of K: the spring and the sign of each, and where its entries stand."""
        pairs, signs = ((0, 0), (1, 1), (0, 1), (1, 0)), (1.0, 1.0, -1.0, -1.0)
        moves = [np.flatnonzero((self.ends[:, pair] >= 0).all(axis=1)) for pair in pairs]
        counts = [len(each) for each in moves]
        one, other = (
            np.concatenate(
                [self.ends[m, pair[k]] for m, pair in zip(moves, pairs, strict=True)]
            )
            for k in (0, 1)
        )
        shape = len(one), 3, 3
        row = np.broadcast_to(3 * one[:, None, None] + np.arange(3)[:, None], shape)
        column = np.broadcast_to(3 * other[:, None, None] + np.arange(3), shape)
        sign = np.repeat(signs, counts)
        return np.concatenate(moves), sign, row.ravel(), column.ravel()
