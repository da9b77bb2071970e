"""The equations of motion between two events, with SciPy's sparse matrices.

With the signed incidence matrix B (row s: -1 at the first end of spring s, +1 at the second),
x the positions and v the velocities of all nodes,

    r = B x,  L = |r|,  e = L - L0,  n = r / L,  w = n · (B v),  T = f(e) + g(e, w),
    forces on the nodes = -Bᵀ (T n),    m a = forces + loads - drag v + m g.

The unknowns are y = (u, v, z, s, A, W, D): displacements u from the drawing and velocities of
the free nodes, what bristles of friction remember, how far branches of springs have given way
and rest lengths have flowed, the inverses of what branches of elements gave way by, the work W
done by loads and by whoever drives nodes, and the energy D lost in dampers, by friction, by
ambient damping and by what relaxes or flows.
Displacements, because they keep the digits that positions far from the origin would lose.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy import sparse

from tissuec.model.blocks import EMBEDDING
from tissuec.validate.contact_search import NearbyContact
from tissuec.validate.embedded import EmbeddedPoints
from tissuec.validate.field_matrices import FieldMatrices
from tissuec.validate.forces import FORMULAS, ForceFormula
from tissuec.validate.forces.activation import ActiveFibres
from tissuec.validate.forces.bending import PlateBending
from tissuec.validate.forces.cut_plates import held_stiffness
from tissuec.validate.forces.elements import ElementSolid
from tissuec.validate.forces.fluids import FluidField
from tissuec.validate.forces.jets import JetForce
from tissuec.validate.forces.laws import ReferenceLaws
from tissuec.validate.forces.membranes import MembraneWall
from tissuec.validate.forces.pressure import PressedSkin, VolumeField
from tissuec.validate.forces.supports import GuidedMotion
from tissuec.validate.forces.ties import CohesiveTies, GluedFaces, TiedPoints
from tissuec.validate.yielding import RelaxingFields, Yielding

if TYPE_CHECKING:
    from tissuec.mechanics.state import State
    from tissuec.model.blocks import FieldBlock

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SMALL = 4000  # numbers of a matrix that is no faster if it is sparse
ROUNDING = 4.0 * np.finfo(float).eps
WEAKEST = 1e-200  # breaking force by which any tension can be divided [N]
_NONE: Floats = np.zeros(0)


class SpringStates(NamedTuple):
    """State of the intact springs.

    Attributes:
        direction: Unit vectors, shape (spring, 3); zero where the length is.
        length: [m], shape (spring,).
        closing: Rates of lengthening [m/s], shape (spring,).
        tension: [N], shape (spring,); zero where the length is.
        brake: What dashpots pull with [N], shape (spring,).
        stretch: Lengths less rest lengths, as far as these have flowed [m], shape (spring,).
        pull: What springs and their branches pull with, dashpots aside [N], shape (spring,).
    """

    direction: Floats
    length: Floats
    closing: Floats
    tension: Floats
    brake: Floats
    stretch: Floats
    pull: Floats


class ReferenceEnergies(NamedTuple):
    """Energies at a moment [J]: of the free nodes, and of all living springs."""

    kinetic: float
    elastic: float
    gravity: float

    @property
    def total(self) -> float:
        return self.kinetic + self.elastic + self.gravity


class ErrorScales(Struct, frozen=True):
    """Scales of errors.

    Attributes:
        displacement: Largest distance of a node from where it is drawn [m].
        speed: Largest speed of a node [m/s].
        energy: Largest energy [J].
    """

    displacement: float
    speed: float
    energy: float

    def joined(self, other: "ErrorScales") -> "ErrorScales":
        """Return the larger of both."""
        return ErrorScales(
            max(self.displacement, other.displacement),
            max(self.speed, other.speed),
            max(self.energy, other.energy),
        )


class Equations:
    """Equations of motion of a net from the time of a state to ``stop``, without events.

    Args:
        state: Read once, now.
        stop: End of the stretch [s]. Profiles that jump at either end are taken from inside.

    Shared arguments:
        time: Time [s].
        y: Unknowns (u [m], v [m/s], z, s, A, W [J], D [J]), shape (6 free + inner + 2,).
        moved: Displacements of all nodes [m], shape (node, 3).
        velocity: Of all nodes [m/s], shape (node, 3).
        position: Of all nodes [m], shape (node, 3).
        work: Work done from outside so far [J].
        lost: Energy dissipated so far [J].
        springs: State of the springs, if it is known.
        energies: Energies of the state [J].
    """

    def __init__(self, state: "State", stop: float):
        network = state.network
        self.count, self.rows = network.node_count, network.row_count
        self.drawn = state.drawn
        # Where profiles begin and end may differ from the ends of the stretch by rounding.
        margin = ROUNDING * stop
        self.window = state.time + margin, max(stop - margin, state.time + margin)
        self.embedded = EmbeddedPoints(state.of_kind(EMBEDDING), self.count, state.held)
        self.held, self.free = np.flatnonzero(state.held), self.embedded.free
        self.motions, self.loads = (tuple(e.values()) for e in (state.motions, state.loads))
        touching = state.touching
        self.contact = None if touching is None else NearbyContact(touching)
        blocks = [block for block in state.present_blocks if block.kind != EMBEDDING]
        self.fields = tuple(self._formula(block, state) for block in blocks)
        of_elements = (ElementSolid, MembraneWall)
        self.elements = [one for one in self.fields if isinstance(one, of_elements)]
        self.ties = [one for one in self.fields if isinstance(one, TiedPoints)]
        smooth = [one for one in self.fields if one is not self.contact]
        self.guided = GuidedMotion(state.guides)
        self.matrices = FieldMatrices(smooth, self.embedded, self.count, self.guided)
        self.bodies = network.body_nodes
        self.memory = network.remembering("friction") if touching is None else touching.memory
        own = state.braking, state.mass, state.mass * state.weighing
        self.drag, self.mass, self.heavy = (self.embedded.lumped(n)[self.free] for n in own)
        self.gravity = state.gravity
        self._still = state.position - self.drawn
        self.springs = np.flatnonzero(state.alive_springs)
        numbers = (state.springs.stiffness, state.springs.damping, state.springs.rest)
        chosen = (np.asarray(each)[..., self.springs] for each in numbers)
        self.behaviour = ReferenceLaws(
            network.springs.laws, network.springs.law[self.springs], *chosen
        )
        self.rest = self.behaviour.rest
        # Of the springs that are drawn in or paid out, the places among the living ones.
        self.reelings = [
            (
                reeling,
                np.searchsorted(self.springs, reeling.springs),
                state.alive[reeling.springs],
            )
            for reeling in state.reelings.values()
        ]
        # A spring without stiffness may have none; it breaks under any tension, and under none.
        self.strength = np.maximum(state.springs.strength[self.springs], WEAKEST)
        self.crush = state.springs.crush[self.springs]
        ends = network.springs.ends[self.springs]
        places = ends.T.astype(np.intp)
        self._first: NDArray[np.intp] = places[0]
        self._second: NDArray[np.intp] = places[1]
        self.incidence = incidence_matrix(ends, self.count)
        # SciPy's sparse matrices take four times as long as NumPy for a small product.
        is_small = self.incidence.shape[0] * self.count < SMALL
        backwards = self.incidence.T
        self._backwards: Any = backwards.toarray() if is_small else backwards.tocsr()
        self._reach = self.along(network.position)
        self._edges = network.edges[state.alive_lines[network.spring_count :]]
        self.yielding = Yielding(state.springs.inelastic, self.springs)
        self.relaxing = RelaxingFields(self.elements)
        #: Number of unknowns that bristles, springs and elements remember.
        self.inner = 3 * len(self.memory) + self.yielding.count + self.relaxing.count

    def _formula(self, block: "FieldBlock", state: "State") -> ForceFormula:
        """Return the independent formula of a block."""
        field: Any = block.field.intact(state.alive)
        match block.kind:
            case "elements":
                given = field, state.network.position, state.velocity
                return ElementSolid(*given, _parts_of(field, state))
            case "membranes":
                return MembraneWall(field, state.velocity, _parts_of(field, state))
            case "volume":
                return VolumeField(field)
            case "fluid":
                return FluidField(field)
            case "pressure":
                return PressedSkin(field)
            case "activation":
                return ActiveFibres(field)
            case "plates":
                return PlateBending(field, _held_plates(block, state))
            case "ties":
                tied = state.tied[field.name], state.cut_bodies[field.name]
                thick = getattr(state.network.elements_of(field.name)[0], "thickness", None)
                return CohesiveTies(*tied, state.network.position, state.alive, thick)
            case "glue":
                return GluedFaces(field, self.count)
            case "jet":
                return JetForce(field)
            case "contact":
                assert self.contact is not None
                return self.contact
            case kind:
                return FORMULAS[kind](field)

    @property
    def stiffness(self) -> Floats:
        """Return the stiffness of springs at rest or as drawn, the larger [N/m].

        The shape is (spring,).
        """
        drawn = np.sqrt(np.einsum("sk,sk->s", self._reach, self._reach)) - self.rest
        steep = np.maximum(*(self.behaviour.resisting(e) for e in (drawn, 0.0 * drawn)))
        return np.asarray(steep + self.yielding.sudden)

    @property
    def stiffest(self) -> float:
        """Return the largest stiffness of a spring, or of elements at a node [N/m]."""
        springs = float(self.stiffness.max(initial=0.0))
        return max(springs, float(self._of_elements().max(initial=0.0)))

    def _of_elements(self) -> Floats:
        """Return about what elements resist the motion of each node with [N/m], (node,)."""
        found = np.zeros(self.count)
        for acting in self.fields:
            if isinstance(acting, ElementSolid):
                found += acting.resistance(self.count)
        return found

    # --- state --------------------------------------------------------------------------------

    def gather(self, position: Floats, velocity: Floats, work: float, lost: float) -> Floats:
        """Return the unknowns of a state, shape (6 free + inner + 2,)."""
        moved, bristles = (position - self.drawn)[self.free], velocity[self.memory]
        own, given = velocity[self.free], self.yielding.read(velocity)
        tensors = self.relaxing.read(velocity)
        parts = (moved.ravel(), own.ravel(), bristles.ravel(), given, tensors, [work, lost])
        return np.concatenate(parts)

    def _inside(self, time: float) -> float:
        """Return a time of the stretch at which no profile is taken from outside of it [s]."""
        return min(max(time, self.window[0]), self.window[1])

    def spread(self, time: float, y: Floats) -> tuple[Floats, Floats]:
        """Return displacements [m] and velocities [m/s] of all nodes, shape (node, 3) each.

        Velocities are followed by internal variables, see ``Network.internal``.
        """
        inside = self._inside(time)
        moved, velocity = self._still.copy(), np.zeros((self.rows, 3))
        size = 3 * len(self.free)
        moved[self.free] = y[:size].reshape(-1, 3)
        velocity[self.free] = y[size : 2 * size].reshape(-1, 3)
        for motion in self.motions:
            place, speed = motion.at(inside)
            shift = place - self.drawn[motion.nodes]
            if motion.change is not None:
                shift, speed = (
                    old + (motion.change @ (new - old)[..., None])[..., 0]
                    for new, old in (
                        (shift, moved[motion.nodes]),
                        (speed, velocity[motion.nodes]),
                    )
                )
            moved[motion.nodes], velocity[motion.nodes] = shift, speed
        self.embedded.follow(moved)
        self.embedded.follow(velocity)
        if self.inner:
            tensors = len(y) - 2 - self.relaxing.count
            given = tensors - self.yielding.count
            velocity[self.memory] = y[2 * size : given].reshape(-1, 3)
            self.yielding.write(y[given:tensors], velocity)
            self.relaxing.write(y[tensors:-2], velocity)
        return moved, velocity

    @property
    def cut(self) -> NearbyContact | None:
        """Return contact whose bristles stick or slip; None where they slip as they bend."""
        return self.contact if self.contact is not None and self.contact.is_cut else None

    def slipped(
        self, time: float, y: Floats, changed: NDArray[np.bool_] | None = None
    ) -> Floats:
        """Return unknowns at a time [s] with bristles that are cut, shape as ``y``.

        Args:
            changed: Which bristles slip or stick from now on, shape (bristle,); None to see
                which slip.
        """
        if self.cut is None:
            return y
        moved, velocity = self.spread(time, y)
        self.cut.slip(self.drawn + moved, velocity, changed)
        start, found = 6 * len(self.free), y.copy()
        found[start : start + 3 * len(self.memory)] = velocity[self.memory].ravel()
        return found

    # --- forces -------------------------------------------------------------------------------

    def behaviour_at(self, time: float) -> ReferenceLaws:
        """Return the laws of the living springs with their rest lengths at a time [s]."""
        if not self.reelings:
            return self.behaviour
        rest, inside = self.rest.copy(), self._inside(time)
        for reeling, place, lives in self.reelings:
            rest[place[lives]] = reeling.rest(inside)[lives]
        return self.behaviour.with_rest(rest)

    def _drawing(self, time: float, pull: Floats) -> float:
        """Return the power that drawing threads in puts in [W]; ``pull`` of springs in [N]."""
        inside = self._inside(time)
        return -sum(
            float(pull[place[lives]] @ reeling.rate(inside)[lives])
            for reeling, place, lives in self.reelings
        )

    def along(self, values: Floats) -> Floats:
        """Return B times values of nodes in any unit; shapes (node, 3) and (spring, 3)."""
        return values.take(self._second, axis=0) - values.take(self._first, axis=0)

    def pull(self, time: float, moved: Floats, velocity: Floats) -> SpringStates:
        """Return the state of the intact springs."""
        behaviour = self.behaviour_at(time)
        reach = self._reach + self.along(moved)
        length = np.sqrt(np.einsum("sk,sk->s", reach, reach))
        direction = reach / np.where(length > 0.0, length, 1.0)[:, None]
        closing = np.einsum("sk,sk->s", direction, self.along(velocity))
        stretch = length - behaviour.rest
        if self.yielding.count:
            given = self.yielding.read(velocity)
            stretch = stretch - self.yielding.flowed(given)
            pull = behaviour.pull(stretch) + self.yielding.pull(stretch, given)
        else:
            pull = behaviour.pull(stretch)
        brake = behaviour.brake(stretch, closing)
        tension = np.where(length > 0.0, pull + brake, 0.0)
        return SpringStates(direction, length, closing, tension, brake, stretch, pull)

    def burdens(self, springs: SpringStates) -> Floats:
        """Return tensions and pressures divided by their limits, dimensionless.

        The shape is (spring,).
        """
        return np.maximum(springs.tension / self.strength, -springs.tension / self.crush)

    def element_burdens(self, moved: Floats) -> Floats:
        """Return loads of elements divided by their limits, in the order of ``breakable``.

        The shape is (element,).
        """
        every = (each.burdens(self.drawn + moved) for each in (*self.elements, *self.ties))
        return np.concatenate([_NONE, *every])

    @property
    def breakable(self) -> Indices:
        """Return the elements that may break, as entities, shape (element,)."""
        none = np.zeros(0, dtype=np.int64)
        every = (each.breakable for each in (*self.elements, *self.ties))
        return np.concatenate([none, *every])

    def node_forces(self, springs: SpringStates) -> Floats:
        """Return the sum of the spring forces on every node [N], shape (node, 3)."""
        return -(self._backwards @ (springs.tension[:, None] * springs.direction))

    def inner_forces(
        self, time: float, moved: Floats, velocity: Floats, springs: SpringStates
    ) -> Floats:
        """Return the forces of springs, pressure and contact on every node [N].

        They are those of the part that is drawn. The shape is (node, 3).
        """
        forces = self.node_forces(springs)
        inside = self._inside(time)
        for acting in self.fields:
            acting.add_forces(inside, self.drawn + moved, velocity, forces)
        return self.embedded.shared(forces)

    def outside(self, time: float) -> Floats:
        """Return the external forces on all nodes [N], shape (node, 3)."""
        inside = self._inside(time)
        total = np.zeros((self.count, 3))
        for load in self.loads:
            total[load.nodes] += load.at(inside)
        return self.embedded.shared(total)

    def rate(self, time: float, y: Floats) -> Floats:
        """Return dy/dt, shape (6 free + inner + 2,)."""
        moved, velocity = self.spread(time, y)
        springs, position = self.pull(time, moved, velocity), self.drawn + moved
        forces = self.inner_forces(time, moved, velocity, springs)
        work = -np.vdot(forces[self.held], velocity[self.held])
        inside = self._inside(time)
        work += sum(acting.pumping(inside, position, velocity) for acting in self.fields)
        own = velocity[self.free]
        acting = forces[self.free] - self.drag[:, None] * own
        if self.loads:
            loads = self.outside(time)[self.free]
            acting += loads
            work += np.vdot(loads, own)
        if self.reelings:
            work += self._drawing(time, springs.pull)
        lost = springs.brake @ springs.closing + self.drag @ np.einsum("nk,nk->n", own, own)
        lost += sum(acting.dissipated(inside, position, velocity) for acting in self.fields)
        pull = np.zeros_like(forces)
        pull[self.free] = acting + self.heavy[:, None] * self.gravity
        before = pull.copy()
        self.guided.keep(pull)
        work -= np.vdot(before - pull, velocity[: self.count])
        fall = pull[self.free] / self.mass[:, None]
        bending, giving, wasted = self._bending(position, velocity), _NONE, 0.0
        if self.yielding.count:
            given = self.yielding.read(velocity)
            giving, wasted = self.yielding.rate(springs.stretch, springs.pull, given)
        relaxing = self.relaxing.rates(position, velocity)
        ledger = np.array([work, lost + wasted], float)
        return np.concatenate([own.ravel(), fall.ravel(), bending, giving, relaxing, ledger])

    def _bending(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of what bristles remember, shape (3 memory,)."""
        if self.contact is None or not len(self.memory):
            return _NONE
        return self.contact.bristle_rates(position, velocity).ravel()

    def jacobian(self, time: float, y: Floats) -> sparse.csc_matrix:
        """Return ∂(dy/dt)/∂y of springs, fields and drag, sparse; the other rows are empty.

        Work and losses follow from the other unknowns and have no effect on them, so that
        Newton's iteration converges without them; without contact it needs smaller steps. Of
        the internal variables of springs, their effects on the net and on themselves are
        included; of those of elements, those on themselves.
        """
        moved, velocity = self.spread(time, y)
        springs, behaviour = self.pull(time, moved, velocity), self.behaviour_at(time)
        n, safe = springs.direction, np.where(springs.length > 0.0, springs.length, 1.0)
        along = n[:, :, None] * n[:, None, :]
        steep = behaviour.slope(springs.stretch)
        stiffness = steep + self.yielding.sudden
        stiffness = stiffness + behaviour.brake_by_stretch(springs.stretch, springs.closing)
        damping = behaviour.brake_slope(springs.stretch, springs.closing)
        sideways = (self.along(velocity) - springs.closing[:, None] * n) / safe[:, None]
        by_place = (
            stiffness[:, None, None] * along
            + (damping[:, None] * n)[:, :, None] * sideways[:, None, :]
            + (springs.tension / safe)[:, None, None] * (np.eye(3) - along)
        )
        by_speed = damping[:, None, None] * along
        lighter = sparse.diags(np.repeat(1.0 / self.mass, 3))
        size, bristles = 3 * len(self.free), 3 * len(self.memory)
        drag = sparse.diags(np.repeat(self.drag, 3))
        spread, given = self._ends(), self.yielding.derivatives(springs.pull, steep)
        stretching = along_each(n) @ spread  # ∂e/∂u, shape (spring, 3 free)
        position, inside = self.drawn + moved, self._inside(time)
        stiff = self.between(by_place) + self.matrices.by_place(inside, position)
        slow = self.between(by_speed) + self.matrices.by_speed(inside, position, velocity)
        falls = [
            -lighter @ self.matrices.kept(stiff),
            -lighter @ (self.matrices.kept(slow) + drag),
            -lighter @ self.matrices.kept(stretching.T @ given.pull_by_variable),
        ]
        moves = [sparse.csr_matrix((size, size)), sparse.identity(size), None]
        count = self.relaxing.count
        relaxing = sparse.diags(self.relaxing.slowing, shape=(count, count))
        gives = [given.rate_by_stretch @ stretching, None, given.rate_by_variable]
        blocks = [
            [*moves[:2], None, None, None, None],
            [*falls[:2], None, falls[2], None, None],
            [None, None, sparse.csr_matrix((bristles, bristles)), None, None, None],
            [*gives[:2], None, gives[2], None, None],
            [None, None, None, None, relaxing, None],
            [None, None, None, None, None, sparse.csr_matrix((2, 2))],
        ]
        return sparse.csc_matrix(sparse.block_array(blocks))

    def _ends(self) -> sparse.csr_matrix:
        """Return E = B ⊗ 1 on the free nodes, shape (3 spring, 3 free)."""
        joined = self.embedded.spread(self.incidence)
        return sparse.csr_matrix(sparse.kron(joined, sparse.identity(3)))

    def between(self, blocks: Floats) -> sparse.csr_matrix:
        """Return Eᵀ diag(blocks) E with E = B ⊗ 1 on the free nodes, shape (3 free, 3 free).

        Args:
            blocks: In any unit, shape (spring, 3, 3).
        """
        spread = self._ends()
        steps = np.arange(len(blocks) + 1)
        shape = (3 * len(blocks), 3 * len(blocks))
        middle = sparse.bsr_matrix((blocks, steps[:-1], steps), shape=shape)
        return (spread.T @ middle.tocsr() @ spread).tocsr()

    # --- energies and scales ------------------------------------------------------------------

    def energies(
        self, time: float, moved: Floats, velocity: Floats, springs: SpringStates | None = None
    ) -> ReferenceEnergies:
        """Return the energies of a state [J]; ``springs`` is computed if it is not given."""
        inside = self._inside(time)
        pressed = (e.energy(inside, self.drawn + moved) for e in self.fields)
        own = velocity[: self.count].copy()
        self.guided.keep(own)
        own = own[self.free]
        stretch = (springs or self.pull(time, moved, velocity)).stretch
        stored = self.behaviour_at(time).energy(stretch).sum()
        stored += self.yielding.energy(stretch, self.yielding.read(velocity)) + sum(pressed)
        stored += self.relaxing.energy(self.drawn + moved, velocity)
        place = (self.drawn + moved)[self.free]
        return ReferenceEnergies(
            kinetic=0.5 * float(self.mass @ (own * own).sum(axis=1)),
            elastic=float(stored),
            gravity=-float(self.heavy @ (place @ self.gravity)),
        )

    def scales(
        self, moved: Floats, velocity: Floats, energies: ReferenceEnergies
    ) -> ErrorScales:
        """Return the scales of the errors of a state of the bodies."""
        moved, velocity = moved[: self.bodies], velocity[: self.bodies]
        return ErrorScales(
            largest(moved), largest(velocity), energies.kinetic + energies.elastic
        )

    def noise(self) -> ErrorScales:
        """Return the errors of a state that rounding alone causes.

        Lengths are known to ``ROUNDING`` of themselves; times the fastest frequency of a node,
        at most √(2 Σ c / m) over its springs (Gershgorin), that is a noise of velocities.
        """
        gaps = np.diff(self.drawn[self._edges], axis=1)[:, 0]
        reach = max(np.abs(each).max(initial=0.0) for each in (self._reach, gaps))
        longest = max(self.rest.max(initial=0.0), largest(gaps))
        length = float(reach + longest)
        stiffness = self.stiffness
        joined = abs(self._backwards) @ stiffness + self._of_elements()
        joined = self.embedded.shared(joined)[self.free]
        fastest = float(np.sqrt((2.0 * joined / self.mass).max(initial=0.0)))
        place = ROUNDING * length
        strain = self.stiffest * place * length
        return ErrorScales(place, place * fastest, strain)


def _parts_of(field: Any, state: "State") -> Any:
    """Return the ``cut_cells.parts.CellParts`` of elements; None where they are whole.

    Args:
        field: Elements that are there.
    """
    if not field.is_cut:
        return None
    body = state.cut_bodies[field.name]
    for parts, entities in zip(body.parts, body.entities, strict=True):
        if parts.shape == field.cell_shape:
            return parts.some(np.isin(entities, field.walls))
    return None


def _held_plates(block: "FieldBlock", state: "State") -> Any:
    """Return the stiffness of plates beside cuts that act; None of those of a drawn wall."""
    plates: Any = block.field
    every = (one for one in state.network.of_kind(block.kind) if one.name == plates.name)
    if (drawn := next(every)).block.name == block.name:
        return None
    found = held_stiffness(plates, drawn, state.cut_bodies[plates.name])
    return np.delete(found, plates.lost_items(state.alive), axis=0)


def largest(vectors: Floats) -> float:
    """Return the largest length of vectors, in their unit; 0 without vectors.

    Args:
        vectors: In any unit, shape (…, 3).
    """
    return float(np.sqrt((vectors * vectors).sum(axis=-1).max(initial=0.0)))


def along_each(direction: Floats) -> sparse.csr_matrix:
    """Return the matrix of components of vectors along springs, shape (spring, 3 spring).

    Args:
        direction: Unit vectors, dimensionless, shape (spring, 3).
    """
    count = len(direction)
    places = np.arange(3 * count), np.arange(0, 3 * count + 1, 3)
    return sparse.csr_matrix((direction.ravel(), *places), shape=(count, 3 * count))


def incidence_matrix(ends: NDArray[np.int32], nodes: int) -> sparse.csr_matrix:
    """Return B, shape (spring, node): -1 at the first end of each spring, +1 at the second."""
    count = len(ends)
    rows = np.repeat(np.arange(count), 2)
    signs = np.tile([-1.0, 1.0], count)
    return sparse.csr_matrix((signs, (rows, ends.ravel())), shape=(count, nodes))


def overloaded(equations: Equations, moved: Floats, springs: SpringStates) -> Indices:
    """Return the intact springs and elements that are above their limits.

    They are entities, ascending, shape (n,).

    Args:
        equations: Of the stretch.
        moved: Displacements of all nodes [m], shape (node, 3).
    """
    torn = equations.springs[equations.burdens(springs) > 1.0]
    broken = equations.breakable[equations.element_burdens(moved) > 1.0]
    return np.sort(np.concatenate([torn, broken]))
