"""Equilibrium for a reference: the energy of its own equations, minimised.

Newton's steps with SciPy's sparse solver lead to an equilibrium near the start. Where they do
not, a trust-region method of SciPy lowers the energy as far as its rounding allows, and
Newton's steps then reduce the forces as far as theirs allows. Where a net can move at no cost,
such as a body that nothing holds, neither determines where it comes to rest; it stays as near
to its start as possible.
"""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import minimize
from scipy.sparse import csr_matrix, identity
from scipy.sparse.linalg import eigsh, spsolve

from tissuec.core.structs import replace
from tissuec.mechanics.state import State
from tissuec.model.blocks import OF_ELEMENTS, FieldBlock
from tissuec.model.network import ELEMENTS, Floats, Indices
from tissuec.validate.equations import Equations, SpringStates
from tissuec.validate.forces.activation import ActiveFibres
from tissuec.validate.forces.pressure import PressedSkin
from tissuec.validate.stepping import ReferenceFailure

COARSE = 1e-5  # of the largest force: up to here the energy decides the direction
BALANCED = 1e-9  # of the largest force: what may be left of it in the end
POLISHING = 100  # more than Newton's method ever needs where all forces have an energy
DIRECT = 20  # Newton's steps before a minimiser is used
SMALLEST = 1e-3  # smallest share of such a step that is tried; the energy must fall
BLOWS = 50  # of jets, whose forces follow the net without an energy
STEADY = 1e-4  # of the largest force: change of theirs from which on Newton's steps continue
TURNS = 4  # of minimising and buckling
LOOSE = 1e-10  # of the stiffest: what resists less counts as without resistance
SMALL = 1500  # unknowns up to which a full matrix is no slower than a sparse one


def rest(state: State, chosen: NDArray[np.bool_]) -> None:
    """Move the chosen free nodes to where the forces on them balance, at rest.

    Args:
        state: Changed in place.
        chosen: Which nodes may move, shape (node,).

    Raises:
        ReferenceFailure: No equilibrium was found.
    """
    field = EnergyField(state, chosen)
    if not len(field.free):
        return
    moved = _nearby(field)
    if not _is_balanced(field, moved):
        moved = _polished(field, _blown(field, field.start))
    for _ in range(TURNS):
        way = _way_off(field, moved)
        if way is None:
            break
        moved = _polished(field, _blown(field, moved + way))
    moved = _put_back(field, moved)
    if not _is_balanced(field, moved):
        left, most = float(np.abs(field.force(moved)).max()), field.largest(moved)
        raise ReferenceFailure(
            f"SciPy's minimiser found no equilibrium at {state.time:g} s: the residual "
            f"force is {left:.2g} N, the largest force {most:.2g} N"
        )
    state.position[field.free] = field.drawn + moved.reshape(-1, 3)
    state.velocity[field.free] = 0.0
    embedded = Equations(state, state.time).embedded
    embedded.follow(state.position)
    embedded.follow(state.velocity)
    state.forget_friction(field.free)
    _give_way(state, field.free)


def relaxed(block: FieldBlock) -> FieldBlock:
    """Return a block without branches of elements, which have given way for good."""
    if block.kind not in OF_ELEMENTS:
        return block
    return replace(block, field=replace(block.field, branches=None))


def _give_way(state: State, free: Indices) -> None:
    """Let what branches at some nodes remember be their elongation or strain."""
    equations = Equations(state, state.time)
    moved = state.position - state.drawn
    stretch = equations.pull(state.time, moved, state.velocity).stretch
    touched = np.isin(state.springs.ends[equations.springs], free).any(axis=1)
    given = equations.yielding.given_way(stretch, touched, state.velocity)
    equations.yielding.write(given, state.velocity)
    equations.relaxing.let_relax(state.position, state.velocity, free)


def _way_off(field: "EnergyField", moved: Floats) -> Floats | None:
    """Return displacements along which a net buckles that should not stay; None if it may.

    Which of the two sides is a rule of the language: in the motion that is resisted least, the
    first component above 0.9 of the largest is positive.
    """
    matrix = field.stiffness(moved)
    top = float(np.abs(matrix.diagonal()).max())
    value, shape = lowest(matrix)
    if value > -LOOSE * top:
        return None
    sizes = np.abs(shape)
    first = shape[np.flatnonzero(sizes > 0.9 * sizes.max())[0]]
    return shape * (0.1 * field.reach / first)


def _put_back(field: "EnergyField", moved: Floats) -> Floats:
    """Return displacements put back along what costs nothing, by steps of Gauss and Newton.

    Where Σ m |u - u₀|² is least is the rule of the language.
    """
    root = np.sqrt(np.repeat(field.mass, 3))
    for _ in range(POLISHING):
        motions = neutral(field.stiffness(moved))
        if not motions.shape[1]:
            break
        part = np.linalg.lstsq(root[:, None] * motions, root * (field.start - moved), None)[0]
        back = motions @ part
        moved = _polished(field, moved + back, motions)
        if np.abs(back).max() <= 1e-15 * field.reach:
            break
    return moved


def neutral(matrix: csr_matrix) -> Floats:
    """Return an orthonormal, dimensionless basis of the null space of a symmetric matrix.

    Its shape is (n, k).
    """
    size, top = matrix.diagonal().size, float(np.abs(matrix.diagonal()).max())
    if size <= SMALL:
        _, vectors = eigh(matrix.toarray(), subset_by_value=(-LOOSE * top, LOOSE * top))
        return vectors
    near, count = np.cos(np.arange(size)), 6
    while True:  # a body has six at most, several bodies have more
        found = cast(Any, eigsh)(matrix.tocsc(), k=count, sigma=-1e-3 * LOOSE * top, v0=near)
        values, vectors = np.asarray(found[0]), np.asarray(found[1])
        costs = np.abs(values) > LOOSE * top
        if costs.any() or 2 * count >= size:
            return vectors[:, ~costs]
        count *= 2


def lowest(matrix: csr_matrix) -> tuple[float, Floats]:
    """Return the lowest eigenvalue of a symmetric matrix, in its unit, and its unit vector.

    The vector has the shape (n,).
    """
    size = matrix.diagonal().size
    if size <= SMALL:
        values, vectors = eigh(matrix.toarray(), subset_by_index=[0, 0])
        return float(values[0]), vectors[:, 0]
    # All eigenvalues lie above this (Gershgorin), the lowest next to it.
    rows = np.asarray(abs(matrix).sum(axis=1)).ravel()
    bound = float((2.0 * matrix.diagonal() - rows).min()) - 1e-6 * float(rows.max())
    near = np.cos(np.arange(size))
    found = cast(Any, eigsh)(matrix.tocsc(), k=1, sigma=min(bound, 0.0), v0=near)
    return float(found[0][0]), np.asarray(found[1])[:, 0]


def _nearby(field: "EnergyField") -> Floats:
    """Return displacements at an equilibrium near the start, if Newton's steps lead there.

    Minimisers take hundreds of times as long where tissue hardly changes its volume.
    """
    moved = field.start
    for _ in range(DIRECT):
        force = field.force(moved)
        if np.abs(force).max() <= COARSE * field.largest(moved) + field.noise:
            break
        field.freeze(moved)
        step = _newton_step(field, moved, force)
        before, size = field.energy(moved), 1.0
        while size >= SMALLEST and not field.energy(moved + size * step) < before:
            size *= 0.5
        if size < SMALLEST:
            break
        moved = moved + size * step
    return _polished(field, moved)


def _newton_step(field: "EnergyField", moved: Floats, force: Floats) -> Floats:
    """Return the step after which the force at some displacements [N] would vanish [m]."""
    matrix = field.stiffness(moved)
    shift = 1e-12 * float(np.abs(matrix.diagonal()).max())
    return np.asarray(spsolve((matrix + shift * identity(len(moved))).tocsc(), force))


def _is_balanced(field: "EnergyField", moved: Floats) -> bool:
    left = float(np.abs(field.force(moved)).max())
    return left <= BALANCED * field.largest(moved) + field.noise


def _lowered(field: "EnergyField", moved: Floats) -> Floats:
    if not field.frozen_force(moved).any():
        return moved  # SciPy would divide by its gradient
    place, matrix = moved, field.stiffness(moved)

    def bent(u: Floats, p: Floats) -> Floats:  # for many p at each place
        nonlocal place, matrix
        if not np.array_equal(u, place):
            place, matrix = u, field.stiffness(u)
        return matrix @ p

    found = minimize(
        field.energy,
        moved,
        jac=lambda u: -field.frozen_force(u),
        hessp=bent,
        method="trust-ncg",
        options={
            "gtol": COARSE * field.largest(moved),
            "initial_trust_radius": field.reach,
            "max_trust_radius": 100.0 * field.reach,
            "maxiter": 2000,
        },
    )
    return np.asarray(found.x)


def _blown(field: "EnergyField", moved: Floats) -> Floats:
    """Return displacements of least energy, again and again while jets follow the net."""
    for _ in range(BLOWS):
        before = field.freeze(moved)
        moved = _lowered(field, moved)
        change = float(np.abs(field.freeze(moved) - before).max())
        if change <= STEADY * field.largest(moved):
            break
    return moved


def _polished(field: "EnergyField", moved: Floats, motions: Floats | None = None) -> Floats:
    """Return displacements that Newton's steps no longer improve.

    Args:
        motions: Left out of the steps: orthonormal columns, shape (3 free, motion).
    """
    force = field.force(moved)
    for _ in range(POLISHING):
        step = _newton_step(field, moved, force)
        if motions is not None:
            step -= motions @ (motions.T @ step)
        after = field.force(moved + step)
        if not np.abs(after).max() < np.abs(force).max():
            break
        moved, force = moved + step, after
    return moved


class EnergyField:
    """Forces and energy as functions of the displacements of the nodes that may move.

    Args:
        state: Read once, now.
        chosen: Which nodes may move, shape (node,).

    Attributes:
        free: The nodes that move, ascending, shape (free,).
        drawn: Their drawn positions [m], shape (free, 3).
        mass: Their masses [kg], shape (free,).
        start: Their displacements [m], shape (3 free,).
        reach: A typical length of a spring [m].
        noise: What rounding leaves of a force [N].
    """

    def __init__(self, state: State, chosen: NDArray[np.bool_]):
        stays = np.flatnonzero(~chosen & ~state.held)
        springs, memory = state.springs, state.springs.inelastic
        if memory is not None:
            springs = replace(springs, inelastic=memory.without_branches())
        holders = {**state.holders, "what is not settled": stays}
        still = replace(
            state,
            holders=holders,
            springs=springs,
            blocks={name: relaxed(block) for name, block in state.blocks.items()},
            position=state.position.copy(),
            velocity=state.velocity.copy(),
        )
        still.place_held()
        self._equations = equations = Equations(still, state.time)
        self._time = state.time
        self._speed = np.zeros_like(state.velocity)
        internal = state.network.internal_rows
        self._speed[internal] = state.velocity[internal]
        # Without what bristles of friction remember.
        self._flowed = np.zeros_like(state.velocity)
        flowed = state.network.remembering(ELEMENTS)
        self._flowed[flowed] = state.velocity[flowed]
        self.free, self.drawn = equations.free, equations.drawn[equations.free]
        self.mass = equations.mass
        self.start = (state.position[self.free] - self.drawn).ravel()
        outside = equations.outside(self._time)[self.free]
        self._load = (outside + equations.heavy[:, None] * equations.gravity).ravel()
        self._jets = tuple(state.jets.values())
        kinds = PressedSkin, ActiveFibres
        self._sources = [one for one in equations.fields if isinstance(one, kinds)]
        self._frozen = np.zeros_like(self.start)
        springs = self._springs(self.start)
        self.reach = float(np.mean(springs.length)) if len(springs.length) else 1.0
        self.noise = equations.stiffest * equations.noise().displacement

    def _state(self, moved: Floats) -> Floats:
        """Return displacements of all nodes, shape (node, 3)."""
        rest = np.zeros(self._equations.inner + 2)
        y = np.concatenate([moved, np.zeros_like(moved), rest])
        return self._equations.spread(self._time, y)[0]

    def _springs(self, moved: Floats) -> SpringStates:
        motion = self._state(moved)
        return self._equations.pull(self._time, motion, self._speed)

    def force(self, moved: Floats) -> Floats:
        """Return the forces on the nodes that move [N], shape (3 free,)."""
        motion = self._state(moved)
        forces = self._equations.inner_forces(
            self._time, motion, self._flowed, self._springs(moved)
        )
        return self._kept(forces[self.free].ravel() + self._load)

    def _kept(self, forces: Floats) -> Floats:
        """Return the part of forces on free nodes that moves them [N], shape (3 free,)."""
        every = np.zeros((self._equations.count, 3))
        every[self.free] = forces.reshape(-1, 3)
        self._equations.guided.keep(every)
        return every[self.free].ravel()

    def freeze(self, moved: Floats) -> Floats:
        """Keep the present forces without a potential, and return them [N], shape (3 free,)."""
        self._frozen = self._blown(moved)
        return self._frozen

    def _blown(self, moved: Floats) -> Floats:
        pushed = np.zeros((self._equations.count, 3))
        if not (self._jets or self._sources):
            return pushed[self.free].ravel()
        place = self._equations.drawn + self._state(moved)
        for jet in self._jets:
            jet.add_forces(self._time, place, np.zeros_like(place), pushed)
        for source in self._sources:
            pushed += source.wayward(self._time, place)
        return self._equations.embedded.shared(pushed)[self.free].ravel()

    def frozen_force(self, moved: Floats) -> Floats:
        """Return the forces on free nodes, with the frozen ones [N], shape (3 free,)."""
        if not (self._jets or self._sources):
            return self.force(moved)
        return self.force(moved) + self._kept(self._frozen - self._blown(moved))

    def energy(self, moved: Floats) -> float:
        """Return the energy of the net less the work of loads and frozen forces [J].

        Args:
            moved: Displacements of the free nodes [m], shape (3 free,).
        """
        elastic = self._equations.behaviour.energy(self._springs(moved).stretch).sum()
        place = self._equations.drawn + self._state(moved)
        stored = sum(float(e.energy(self._time, place)) for e in self._equations.fields)
        stored += sum(one.potential(self._time, place) for one in self._sources)
        stored += self._equations.relaxing.energy(place, self._flowed)
        return float(elastic - (self._load + self._frozen) @ moved) + stored

    def largest(self, moved: Floats) -> float:
        """Return the largest force of a spring, or component of a load or sum of forces [N].

        Sums are those of springs and fields at all nodes, also held ones.

        Args:
            moved: Displacements of the free nodes [m], shape (3 free,).
        """
        springs = self._springs(moved)
        tension = np.abs(springs.tension).max(initial=0.0)
        most = max(float(tension), float(np.abs(self._load).max()))
        if not self._equations.fields:
            return most
        motion = self._state(moved)
        sums = self._equations.inner_forces(self._time, motion, self._flowed, springs)
        return max(most, float(np.abs(sums).max()))

    def stiffness(self, moved: Floats) -> csr_matrix:
        """Return the second derivative of the energy [N/m], shape (3 free, 3 free)."""
        springs = self._springs(moved)
        along = springs.direction[:, :, None] * springs.direction[:, None, :]
        safe = np.where(springs.length > 0.0, springs.length, 1.0)
        across = (springs.tension / safe)[:, None, None] * (np.eye(3) - along)
        behaviour = self._equations.behaviour
        steep = behaviour.slope(springs.stretch)
        matrix = self._equations.between(steep[:, None, None] * along + across)
        place = self._equations.drawn + self._state(moved)
        number = np.full(self._equations.count, -1)
        embedded = self._equations.embedded
        number[embedded.moving] = np.arange(len(embedded.moving))
        for acting in self._equations.fields:
            part = acting.matrix(self._time, place, number, len(embedded.moving))
            matrix = (matrix + embedded.reduced(part)).tocsr()
        number[embedded.nodes] = -1
        ways = self._equations.guided.ways(number, len(self.free))
        if ways is not None:
            off = identity(3 * len(self.free)) - ways @ ways.T
            top = float(np.abs(matrix.diagonal()).max())
            matrix = (ways @ (ways.T @ matrix @ ways) @ ways.T + top * off).tocsr()
        return matrix
