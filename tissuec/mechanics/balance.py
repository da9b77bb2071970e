"""Forces, energy and stiffness of a net at rest, as functions of positions of some nodes.

    E(x) = Σ ∫ f(e) de + energy of enclosed volumes - Σ p·x        F = -∂E/∂x        K = ∂²E/∂x²

with p the weight and the external forces of this moment. Forces without a potential, such as
those of jets, belong to p as well, though they depend on x: in E, they keep the values of the
last call of ``freeze``. Dashpots and drag do not act, because nothing moves. K without the
parts that may make it indefinite follows J. Teran, E. Sifakis, G. Irving, R. Fedkiw, Symp.
Computer Animation 2005, p. 181; for springs see ``springs.resting_springs``.
"""

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.forces.element_fields import ElementField
from tissuec.forces.matrices import summed
from tissuec.forces.springs.resting_springs import Bars, RestingSprings, reached
from tissuec.laws.evaluation import Behaviour
from tissuec.mechanics.guiding import free_projection
from tissuec.mechanics.observables import applied_forces, lengths, rest_lengths
from tissuec.mechanics.state import State
from tissuec.model import topology
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix

    from tissuec.mechanics.dissection import EliminationOrder
    from tissuec.mechanics.inverses import Inverses
    from tissuec.mechanics.stiffness import Stiffness

ACROSS = 1e2  # stiffness in held directions, relative to the largest of all others
ROUNDING = 16.0 * float(np.finfo(float).eps)


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
        springs: Those that act.
        mass: Of the free nodes [kg], shape (free,).
        load: Weight and external force on each free node [N], shape (free, 3).
        holds_slides: Whether motions of pieces along what they touch count as neutral.
    """

    def __init__(self, state: State, chosen: NDArray[np.bool_]):
        is_free = chosen & state.free
        self.free: Indices = np.flatnonzero(is_free)
        self._embedding, ends = state.coupling, state.springs.ends
        number = np.where(is_free, np.cumsum(is_free) - 1, -1)
        # Of free nodes and, behind them, of embedded ones that move with these.
        moving, self._reduction = number, None
        if self._embedding is not None:
            moving, self._reduction = self._embedding.reduction(is_free)
        self._moving = np.flatnonzero(moving >= 0)[np.argsort(moving[moving >= 0])]
        resists = (state.springs.stiffness > 0.0) | (state.springs.law > 0)
        acts = state.alive_springs & resists & (moving[ends] >= 0).any(axis=1)
        self._acting, self._every = np.flatnonzero(acts), state.springs
        self.springs = RestingSprings(
            ends=moving[ends[acts]],
            outer_ends=ends[acts],
            behaviour=state.springs.some(self._acting).behaviour,
            rest=rest_lengths(state, state.velocity, self._acting),
        )
        edges = state.joined_pairs
        #: Nodes of springs that act, and of edges of elements at free nodes, shape (link, 2).
        self.links = np.concatenate([ends[acts], edges[(moving[edges] >= 0).any(axis=1)]])
        self._edges = edges
        self.mass = state.inertia[self.free]
        self.load = applied_forces(state)[self.free]
        self._pushing = (*state.jets.values(), *state.pressures)
        self._number, self._time = moving, state.time
        self._fields = tuple(field.recalling(state.velocity).relaxed for field in state.fields)
        # Nothing moves; internal variables say how far elements have flowed.
        self._still = np.zeros_like(state.velocity)
        for field in self._fields:
            self._still[field.internal_rows] = state.velocity[field.internal_rows]
        self._position, self._drawn = state.position.copy(), state.drawn
        self._start = self._position[self.free]
        self._frozen = np.zeros_like(self._start)
        self._last: tuple[Bars | None, list[Floats]] = None, []
        self.holds_slides = False
        self._contact = state.touching
        self._guides = state.guides
        if self._guides is not None:
            self._within = free_projection(self._guides, number, len(self.free))

    @property
    def start(self) -> Floats:
        """Return where the free nodes are in the state [m], shape (free, 3)."""
        return self._start.copy()

    @property
    def every_link(self) -> NDArray[np.integer]:
        """Return the nodes of all springs and edges, held or not, shape (link, 2)."""
        return np.concatenate([self._every.ends, self._edges])

    @property
    def is_guided(self) -> bool:
        """Return whether nodes are held in some directions."""
        return self._guides is not None

    @property
    def present_load(self) -> Floats:
        """Return all forces without a potential on the free nodes [N], shape (free, 3).

        These are weight, external forces, and the forces frozen last.
        """
        return self.load + self._frozen

    def loads(self, bars: Bars) -> Floats:
        """Return all that acts from outside on the free nodes [N], shape (free, 3).

        That is weight, external forces, pressures and jets.
        """
        total = np.zeros_like(bars.position)
        for acting in self._pushing:
            acting.add_forces(self._time, bars.position, self._still, total)
        return self.load + self._on_free(total)

    @cached_property
    def labels(self) -> NDArray[np.integer]:
        """Return the piece of each free node, by its number, shape (free,)."""
        joined = self.link_ends[(self.link_ends >= 0).all(axis=1)]
        if self._embedding is not None:
            pairs = self._number[self._embedding.neighbours]
            joined = np.concatenate([joined, pairs[(pairs >= 0).all(axis=1)]])
        return topology.pieces(len(self.free), joined)

    @cached_property
    def link_ends(self) -> NDArray[np.integer]:
        """Return the nodes of ``links`` as numbers of free nodes, shape (link, 2).

        An embedded node has that of its first free host, and a node that stays -1.
        """
        ends = self._number[self.links]
        if self._reduction is None:
            return ends
        rows = self._reduction[::3]
        return np.append(rows.indices[rows.indptr[:-1]] // 3, -1)[ends]

    def longest(self, bars: Bars) -> float:
        """Return the length of the longest spring or edge, now or at rest [m]."""
        now, rest = self.link_lengths(bars), self.springs.rest
        return float(max(now.max(initial=0.0), rest.max(initial=0.0), self._drawn_edge))

    def link_lengths(self, bars: Bars) -> Floats:
        """Return the lengths of ``links`` [m], shape (link,)."""
        edges = self.links[len(bars.length) :]
        return (
            np.append(bars.length, lengths(edges, bars.position)) if len(edges) else bars.length
        )

    @cached_property
    def _drawn_edge(self) -> float:
        """Return the length of the longest edge at free nodes as drawn [m]; 0 without any."""
        return float(lengths(self.links[len(self._acting) :], self._drawn).max(initial=0.0))

    @property
    def is_embedding(self) -> bool:
        """Return whether nodes are embedded in others."""
        return self._embedding is not None

    def _on_free(self, forces: Floats) -> Floats:
        """Return the forces on free nodes, with those on embedded ones [N], shape (free, 3).

        Args:
            forces: On all nodes, shape (node, 3).
        """
        if self._embedding is None:
            return forces[self.free]
        return self._embedding.shared(forces)[self.free]

    def following(self, vectors: Floats) -> Floats:
        """Return vectors of free nodes and of embedded ones behind them, shape (moving, 3).

        Args:
            vectors: Of free nodes in any unit, shape (free, 3).
        """
        if self._reduction is None:
            return vectors
        return np.asarray(self._reduction @ vectors.ravel()).reshape(-1, 3)

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return which free nodes contact or a force ties to something, shape (free,).

        Guides do not, but leave motions in some directions; see ``held_directions``.

        Args:
            position: Of all nodes of the scene [m], shape (node, 3).
        """
        found = np.zeros(len(position), dtype=bool)
        for acting in self._fields:
            found |= acting.touched(position)
        if self._embedding is not None:
            pairs = self._embedding.neighbours
            found[pairs[found[self._embedding.nodes[self._embedding.owners]]]] = True
        return found[self.free]

    @property
    def contact_stride(self) -> float:
        """Return the longest way of a node that contact does not miss [m]; inf without any."""
        return np.inf if self._contact is None else self._contact.stride

    def contact_matrix(self, x: Floats) -> "csr_matrix":
        """Return the part of K that is of contact, without what weakens [N/m].

        Args:
            x: Positions of the free nodes [m], shape (free, 3).
        """
        from scipy.sparse import csr_matrix

        if self._contact is None:
            return csr_matrix((3 * len(self.free), 3 * len(self.free)))
        where = self._time, self.bars(x).position, self._number, len(self._moving)
        return csr_matrix(self._reduced(self._contact.matrix(*where, exact=False)))

    def pressed(self, x: Floats, nodes: Indices) -> tuple[float, float]:
        """Return the force with which contact presses on some nodes, and what can rub them [N].

        Args:
            x: Positions of the free nodes [m], shape (free, 3).
            nodes: Numbers among the free nodes, shape (n,).
        """
        if self._contact is None:
            return 0.0, 0.0
        position, total = self.bars(x).position, np.zeros_like(self._position)
        self._contact.add_forces(self._time, position, self._still, total)
        force = float(norm(self._on_free(total)[nodes].sum(axis=0)))
        return force, self._contact.least_friction(position) * force

    @property
    def held_directions(self) -> Floats:
        """Return the projections of free nodes into what guides hold, dimensionless.

        The shape is (free, 3, 3).
        """
        off = np.zeros((len(self._position), 3, 3))
        if self._guides is not None:
            off[self._guides.nodes] = np.eye(3) - self._guides.projections
        return off[self.free]

    @property
    def has_elements(self) -> bool:
        """Return whether elements act, whose K costs much more if it is clamped."""
        return any(isinstance(acting, ElementField) for acting in self._fields)

    def bars(self, x: Floats) -> Bars:
        """Return the state of the springs with the free nodes at x [m], shape (free, 3)."""
        position = self._position
        position[self.free] = x
        if self._embedding is not None:
            self._embedding.follow(position)
        return self.springs.bars(position)

    def bars_at(self, position: Floats) -> Bars:
        """Return the state of the springs with all nodes at places [m], shape (node, 3)."""
        return self.springs.bars(position)

    def force(self, bars: Bars) -> Floats:
        """Return the sum of all forces on the free nodes [N], shape (free, 3)."""
        total = self.load.copy()
        if self._reduction is None:
            self.springs.add_forces(bars, total)
        else:
            pulled = np.zeros((len(self._moving), 3))
            self.springs.add_forces(bars, pulled)
            total += (self._reduction.T @ pulled.ravel()).reshape(-1, 3)
        if self._fields:
            total += self._on_free(sum(self._of_fields(bars), np.zeros_like(bars.position)))
        return total if self._guides is None else self._kept(total)

    def _of_fields(self, bars: Bars) -> list[Floats]:
        """Return the forces of each field on all nodes [N], each of shape (node, 3).

        Those at the last positions are kept: whether forces balance is judged by them, too.
        """
        last, forces = self._last
        if last is not bars:
            forces = [np.zeros_like(bars.position) for _ in self._fields]
            for acting, to in zip(self._fields, forces, strict=True):
                acting.add_forces(self._time, bars.position, self._still, to)
            self._last = bars, forces
        return forces

    def _kept(self, force: Floats) -> Floats:
        """Return the part of forces, or of others, in free directions, shape (free, 3)."""
        return np.asarray(self._within @ force.ravel()).reshape(-1, 3)

    def held_part(self, vectors: Floats) -> Floats:
        """Return the part of vectors in directions in which guides hold nodes.

        Args:
            vectors: Of free nodes in any unit, shape (free, 3).
        """
        return np.zeros_like(vectors) if self._guides is None else vectors - self._kept(vectors)

    @property
    def across(self) -> int:
        """Return the number of independent motions that guides prevent."""
        if self._guides is None:
            return 0
        return 3 * len(self.free) - round(float(self._within.diagonal().sum()))

    def keep_to_guides(self, motions: Floats) -> NDArray[np.bool_]:
        """Return which motions are in free directions, not in held ones, shape (motion,).

        Args:
            motions: Columns of any unit, shape (3 free, motion).
        """
        if self._guides is None:
            return np.ones(len(motions.T), dtype=bool)
        kept = np.linalg.norm(self._within @ motions, axis=0)
        return kept > 0.5 * np.linalg.norm(motions, axis=0)

    def star(self, nodes: Indices) -> NodeSprings:
        """Return some free nodes, given by numbers of shape (n,), with the springs at them."""
        row = np.full(len(self._moving) + 1, -1)  # the last is that of ends that stay
        row[nodes] = np.arange(len(nodes))
        rows = row[self.springs.ends]
        springs = np.flatnonzero((rows >= 0).any(axis=1))
        own = self._every.some(self._acting[springs])
        chosen = own.behaviour.with_rest(self.springs.rest[springs])
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
        reach, length = reached(self.springs.outer_ends[star.springs], position)
        tension = star.behaviour.pull(length - star.behaviour.rest)
        pull = (tension / np.where(length > 0.0, length, np.inf))[:, None] * reach
        total = self.load[star.nodes]
        for end, sign in ((0, 1.0), (1, -1.0)):
            moves = star.rows[:, end] >= 0
            np.add.at(total, star.rows[moves, end], sign * pull[moves])
        return total

    def freeze(self, bars: Bars) -> None:
        """Use the present forces without a potential in the energy."""
        self._frozen = np.zeros_like(self._start)
        for acting in self._fields:
            wayward = acting.wayward(self._time, bars.position)
            if wayward is not None:
                self._frozen += self._on_free(wayward)

    def energy(self, x: Floats, bars: Bars) -> tuple[float, float]:
        """Return the energy and a bound of its rounding error [J].

        The work of loads is zero at the positions of the free nodes in the state.

        Args:
            x: Positions of the free nodes [m], shape (free, 3).
            bars: The springs at these positions.
        """
        elastic = self.springs.energy(bars)
        done = self.present_load * (x - self._start)
        pressed = sum(float(e.potential(self._time, bars.position)) for e in self._fields)
        total = float(elastic.sum() - done.sum()) + pressed
        spoilt = bars.length * np.abs(bars.tension)
        sizes = elastic.sum() + np.abs(done).sum() + spoilt.sum() + abs(pressed)
        sizes += sum(acting.spread(self._time, bars.position) for acting in self._fields)
        return total, ROUNDING * float(sizes)

    def noise(self, bars: Bars) -> float:
        """Return the residual that rounding may leave of balanced forces [N]."""
        place = float(np.abs(self._position).max(initial=0.0))
        return ROUNDING * self.springs.noise(bars, place) + ROUNDING * sum(
            acting.noise(self._time, bars.position) for acting in self._fields
        )

    def largest(self, bars: Bars) -> float:
        """Return the largest force of a spring, load or field [N], to judge residuals by.

        That of a field is its sum at a node, also at one that is held.
        """
        forces = [self.load, *self._of_fields(bars)]
        loads = [float(norm(force).max(initial=0.0)) for force in forces]
        return max(float(np.abs(bars.tension).max(initial=0.0)), *loads)

    def pressing(self, bars: Bars) -> Floats:
        """Return how strongly enclosed volumes may resist each free node [N/m], shape (free,).

        Gershgorin's bound by the rows of their part of K.
        """
        size = len(self._moving)
        total = np.zeros(3 * len(self.free))
        for acting in self._fields:
            sparse, wide = acting.split(self._time, bars.position, self._number, size)
            sparse, wide = self._reduced(sparse), self._narrowed(wide)
            total += np.asarray(abs(sparse).sum(axis=1)).ravel()
            total += np.abs(wide) @ np.abs(wide).sum(axis=0)
        return total.reshape(-1, 3).max(axis=1)

    def weakening(self, bars: Bars) -> float:
        """Return a bound on how negative an eigenvalue of K may be [N/m]."""
        where = bars.position, self._number, len(self._moving)
        turning = sum(acting.weakening(self._time, *where) for acting in self._fields)
        return self._stretch * (self.springs.weakening(bars, len(self._moving)) + turning)

    @cached_property
    def _stretch(self) -> float:
        """Return a bound of the square of the norm of T, dimensionless."""
        if self._reduction is None:
            return 1.0
        sizes = abs(self._reduction)
        columns, rows = (np.asarray(sizes.sum(axis=axis)) for axis in (0, 1))
        return float(columns.max(initial=0.0) * rows.max(initial=0.0))

    def _reduced(self, matrix: "csc_matrix") -> "csc_matrix":
        """Return Tᵀ K T of a matrix K of moving nodes, in any unit."""
        from scipy.sparse import csc_matrix

        spread = self._reduction
        return matrix if spread is None else csc_matrix(spread.T @ matrix @ spread)

    def _narrowed(self, columns: Floats) -> Floats:
        """Return Tᵀ W of columns W of moving nodes, in any unit."""
        return columns if self._reduction is None else np.asarray(self._reduction.T @ columns)

    @cached_property
    def _elimination(self) -> "EliminationOrder":
        from tissuec.mechanics.dissection import EliminationOrder

        return EliminationOrder(self._start)

    @cached_property
    def inverses(self) -> "Inverses":
        """Return the maker of inverses of K, which is kept."""
        from tissuec.mechanics.inverses import Inverses

        return Inverses(self._start, self._elimination)

    def matrix(self, bars: Bars, *, exact: bool) -> "Stiffness":
        """Return K [N/m], shape (3 free, 3 free).

        Args:
            exact: Whether pressed springs weaken the net; otherwise K is positive semidefinite.
        """
        from scipy.sparse import csc_matrix, identity

        from tissuec.mechanics.stiffness import Stiffness

        size = len(self._moving)
        values, rows, columns = self.springs.entries(bars, exact=exact)
        parts = [csc_matrix((values, (rows, columns)), shape=(3 * size, 3 * size))]
        wide = [np.zeros((3 * size, 0))]
        for acting in self._fields:
            sparse, beside = acting.split(
                self._time, bars.position, self._number, size, exact=exact
            )
            parts.append(sparse)
            wide.append(beside)
        total, every = self._reduced(summed(parts, size)), self._narrowed(np.hstack(wide))
        if self._guides is None:
            return Stiffness(total, every, self._elimination)
        # Motions in held directions, in which nothing has a part, are stiffer than all others.
        within, top = self._within, ACROSS * float(np.abs(total.diagonal()).max(initial=0.0))
        off = top * (identity(3 * len(self.free)) - within)
        kept = csc_matrix(within @ total @ within + off)
        return Stiffness(kept, np.asarray(within @ every), self._elimination)
