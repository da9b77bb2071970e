"""What acts in a state, as the arrays of the stepping code.

``layout`` gives each node and spring its place, once for a run; ``acting_springs`` chooses the
springs; here, both are filled into the record that kernels read.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from tissuec.compiled.calls import kernel_address
from tissuec.compiled.record_tables import RecordTable
from tissuec.engine.acting import ActingSprings, knots, lengths, longest_step, pack_acts
from tissuec.engine.integrators import Integrator
from tissuec.engine.layout import NONE, layout_of
from tissuec.engine.operations import Features
from tissuec.engine.threads import ThreadTeam, parts_of
from tissuec.engine.unknowns import (
    SolvingCost,
    cost_of_springs,
    new_solver,
    unknown_solver,
)
from tissuec.forces.acting.load import Load
from tissuec.forces.fields import Field, acts_of
from tissuec.forces.springs.springs import reels, table_of
from tissuec.kernels.records import (
    BoundaryConditions,
    EmbeddingTable,
    Fields,
    GuideTable,
    InternalVariables,
    Net,
    RestLengthActuators,
    Solver,
)
from tissuec.mechanics.state import State
from tissuec.model.network import (
    ELEMENTS,
    FRICTION,
    SPRINGS,
    Floats,
    Indices,
    Network,
)
from tissuec.model.profiles import TimeProfile
from tissuec.model.springs import Springs

if TYPE_CHECKING:  # which needs SciPy
    from tissuec.engine.stage_matrix import StageMatrix
    from tissuec.forces.acting.embedding import EmbeddedNodes

Pass = tuple[Callable[..., None], Any]  # a kernel of a field, and the table that it reads
SPORADIC = {"contact", "jet"}
# Bristles with places: at most this factor times the sum of the near ones and of a few more.
SPARE, FEW = 1.5, 200
#: Of ``Features``, those on which the stepping code of a net depends.
FLAGS = (
    "watched", "crushed", "ledger", "reeled", "touched", "inelastic", "cornered", "embedded",
    "guided",
)  # fmt: skip


class KernelInputs:
    """Translates states into the arrays of the stepping code.

    Args:
        network: The network of the run.
        watched: Whether springs may break.
        ledger: Whether work and dissipation are integrated.
        threads: That may share loops over nodes and springs.

    Attributes:
        layout: Places of nodes and springs.
        acting: The springs that act.
        team: The threads that share loops.
        share: Distance of nodes for which lists of near pairs hold, as a part of the longest.
        evaluation: Predicted time of a force evaluation in the present state, once found [s].
    """

    def __init__(self, network: Network, *, watched: bool, ledger: bool, threads: int = 1):
        self.layout = self._whole = layout_of(network, threads)
        self._bristles = network.remembering(FRICTION)
        self._left_out = self._parked = self._hosts = NONE
        self.acting = ActingSprings(self.layout, watched=watched, ledger=ledger)
        self.watched, self.ledger = watched, ledger
        self.start = self.until = 0.0
        self.share = 1.0
        self.spring_count = network.spring_count
        self.team = ThreadTeam(self.layout.threads, network.row_count)
        self.evaluation: float | None = None
        self._embedding: EmbeddedNodes | None = None  # those with places
        self._solver: Solver | None = None
        self._solver_ids: Indices | None = None  # of the springs that these arrays are for
        self.stage: StageMatrix | None = None

    @property
    def springs(self) -> Springs:
        """Return the springs that act; see ``ActingSprings``."""
        return self.acting.springs

    def inwards(self, vector: Floats) -> Floats:
        """Return the values of nodes, in any unit, as a flat array; see ``Layout.inwards``.

        Args:
            vector: Numbers or vectors, shape (node,) or (node, 3).
        """
        return self.layout.inwards(vector)

    def positions(self, flat: Floats) -> Floats:
        """Return positions of all nodes [m], shape (…, node, 3), as ``Layout.of_nodes``."""
        return self.layout.of_nodes(flat)

    def outwards(self, flat: Floats) -> Floats:
        """Return vectors of all nodes and rows, as ``Layout.outwards`` does.

        Args:
            flat: In any unit, which the result has, too, shape (…, 3 place).
        """
        return self.layout.outwards(flat)

    @property
    def left_out(self) -> bool:
        """Return whether some bristles have no place."""
        return len(self._left_out) > 0

    def leaves_out(self, bristles: Indices) -> bool:
        """Return whether some bristles have no place, or far too many others have one.

        Args:
            bristles: Their numbers among those of the net, shape (bristle,).
        """
        kept = self.layout.place[self._bristles] >= 0
        is_missing = bool((self.layout.place[bristles] < 0).any())
        return is_missing or int(np.count_nonzero(kept)) > SPARE * (len(bristles) + FEW)

    def keep(self, bristles: Indices | None) -> None:
        """Give places to these bristles and to no others; None for all.

        Args:
            bristles: Rows, shape (n,).
        """
        self._left_out = NONE if bristles is None else np.setdiff1d(self._bristles, bristles)
        self._lay_out()
        self._place_nodes()

    def parks(self, state: State) -> bool:
        """Return whether the parked nodes of a state differ from those without places."""
        parked, hosts = state.parked
        same = np.array_equal(parked, self._parked) and np.array_equal(hosts, self._hosts)
        return not same

    def park(self, state: State) -> None:
        """Give places to nodes that are not parked in a state, which ``update`` takes next."""
        self._parked, self._hosts = state.parked
        self._lay_out()

    def _lay_out(self) -> None:
        self.layout = self._whole.without(self._left_out, self._parked, self._hosts)
        self.acting.move_to(self.layout)

    def update(self, state: State) -> None:
        """Update everything that acts in a state, but not positions and velocities."""
        self.state, self.around = state, state.position
        self.evaluation = None
        self._embedding = embedding = state.embedding
        if embedding is not None and len(self._parked):
            self._embedding = embedding.without(self._parked)
        self.moved, self.still, self.free = state.driven, state.still, state.free
        self.acting.update(state, state.held, self.moved)
        self._inverse = inverse = np.where(self.free, 1.0 / state.divisor, 0.0)
        self.internal_rows = state.network.remembering(ELEMENTS)
        push, steady = np.zeros((2, len(inverse), 3))
        drag, self.timed = np.zeros(len(inverse)), list[Load]()
        motion = state.position, state.velocity
        for acting in state.outer:
            if acting.steady is not None:
                steady += acting.steady
            if acting.drag is not None:
                drag += acting.drag
            self.timed += (load for load in acting.loads if not load.is_constant)
            for load in acting.loads:
                if load.is_constant:
                    load.add_forces(state.time, *motion, push)
        push[~self.free] = steady[~self.free] = 0.0
        steady += push * inverse[:, None]
        self._drag, self._push, self._steady = drag, push, steady
        self._place_nodes()
        self.stage = None

    def _place_nodes(self) -> None:
        """Set arrays with a number or a vector for each place."""
        self.inverse_mass = self.response = self.inwards(self._inverse)
        if len(self.internal_rows):
            self.response = self.inverse_mass.copy()
            self.response[self.layout.place[self.internal_rows]] = 1.0
        self.drag = self.inwards(self._drag)
        self.push, self.steady = self.inwards(self._push), self.inwards(self._steady)
        driven = self.layout.place[np.flatnonzero(self.moved)]
        self.driven = driven[driven >= 0]

    @property
    def features(self) -> Features:
        """Return the features that the stepping code needs."""
        return Features(
            viscous=self.acting.is_viscous,
            watched=self.watched,
            crushed=self.acting.is_crushed,
            ledger=self.ledger,
            banded=self._solver is not None and not self._solver.scratch.size,
            # Whatever may be drawn in, lest a second variant is compiled when it is.
            reeled=self.state.network.can_be_drawn_in,
            touched=self.state.contact is not None,
            inelastic=self.springs.inelastic is not None,
            cornered=self.acting.has_corners,
            embedded=self.state.embedding is not None,
            guided=self.state.guides is not None,
            laws=self.acting.laws,
            in_runs=self._are_in_runs,
        )

    @property
    def _are_in_runs(self) -> bool:
        """Return whether springs are taken in runs: linear ones of constant lengths."""
        changing = self.acting.laws or self.springs.inelastic is not None
        if changing or self.state.network.can_be_drawn_in:
            return False
        return self.acting.places.is_worthwhile

    def solver(self) -> Solver:
        """Return arrays for the matrix of implicit steps, without a matrix in them."""
        kept = self._solver_arrays()
        kept.made[:] = 0.0
        kept.made[4] = self.stage is not None
        return kept

    def _solver_arrays(self) -> Solver:
        """Return the arrays for the matrix of implicit steps, without copies."""
        low, high = self.springs.ends.T
        kept, free = self._solver, self.inverse_mass > 0.0
        if self._has_more_than_springs:
            if self.stage is None or kept is None:
                from tissuec.engine.stage_matrix import StageMatrix  # where SciPy is needed

                self.stage = StageMatrix(self.state, self.layout)
                kept = self._solver = unknown_solver(free)
                self._solver_ids = None
            return kept
        same = kept is not None and np.array_equal(kept.slot < 0, ~free)
        if kept is None or not same or self._solver_ids is not self.springs.ids:
            kept = self._solver = new_solver(low, high, free)
            self._solver_ids = self.springs.ids
        return kept

    @property
    def _has_more_than_springs(self) -> bool:
        """Return whether the matrix of implicit steps needs more than springs without memory.

        Contact and jets alone do not: short steps follow where they begin and end anyway.
        """
        kinds = {block.kind for block in self.state.present_blocks}
        more = bool(kinds - SPORADIC) or self.state.guides is not None
        return more or self.springs.inelastic is not None

    def is_direct(self) -> bool:
        """Return whether the matrix of implicit steps has a factor of acceptable size."""
        if any(each.unsolved for each in self.state.fields):
            return False
        solver = self._solver_arrays()
        return not solver.scratch.size if self.stage is None else self.stage.fill.is_small

    def solving_cost(self) -> SolvingCost:
        """Return the cost of the matrix of implicit steps."""
        solver = self._solver_arrays()
        if self.stage is None:
            return cost_of_springs(solver, len(self.springs.ids))
        return self.stage.cost

    def in_python(self, integrator: type[Integrator]) -> dict[str, Callable[..., Any]]:
        """Return the operations on the net that are Python functions, by name.

        Args:
            integrator: The integrator of the net.
        """
        if not integrator.implicit or self.stage is None:
            return {}
        return {"assemble": self.stage.assemble, "solve": self.stage.solve}

    def net(self, integrator: type[Integrator], *, plain: bool = False) -> Net:
        """Return the record that kernels read, without operations.

        Args:
            integrator: What steps it.
            plain: Whether springs in runs also have their numbers in the arrays of all springs.
        """
        springs, nodes, near = (
            self.springs,
            len(self.layout.order),
            self.acting.near(integrator),
        )
        low, high = springs.ends.T
        needed = self.features
        # Springs in runs have numbers of their own there; explicit steps need these, too, only
        # to look for what breaks.
        alone = plain or not needed.in_runs or needed.watched or integrator.implicit
        numbers = slice(None) if alone else slice(0)
        return Net(
            first=np.searchsorted(low, np.arange(nodes + 1)).astype(np.uint64),
            other=(3 * high).astype(np.uint32),
            stiffness=np.ascontiguousarray(springs.stiffness[numbers]),
            damping=np.ascontiguousarray(springs.damping[numbers]),
            rest=springs.rest,
            strength=np.ascontiguousarray(springs.strength),
            crush=np.ascontiguousarray(springs.crush),
            law=np.ascontiguousarray(springs.law[numbers]),
            **near,
            inverse_mass=self.inverse_mass,
            response=self.response,
            internal_rows=self.layout.place[self.internal_rows],
            steady=self.steady,
            push=self.push,
            driven=self.driven,
            drag=self.drag,
            pushed=bool(self.steady.any()),
            dragged=bool(self.drag.any()),
            **{name: getattr(needed, name) for name in FLAGS},
            acts=self.acts(),
            **self._effects(integrator, needed, near),
            team=self.team.record,
        )

    def _effects(
        self, integrator: type[Integrator], needed: Features, near: dict[str, Floats]
    ) -> dict[str, Any]:
        """Return the records of optional features, None for those that are missing."""
        fields, acting = self.fields(), self.acting
        kept = cast(tuple[RecordTable, ...], fields.kept)
        records = (table.record for table in kept)
        touches = (getattr(record, "touches", None) for record in records)
        return {
            "reels": self.reels() if needed.reeled else None,
            "touches": next(filter(None, touches), None),
            "internal": self.internal() if needed.inelastic else None,
            "embedding": self.embedding() if needed.embedded else None,
            "guides": self.guides() if needed.guided else None,
            "runs": acting.runs(near, self.team.parts) if needed.in_runs else None,
            "chunks": self.acting.chunks()
            if not needed.in_runs or integrator.implicit
            else None,
            "fields": fields,
        }

    def acts(self) -> BoundaryConditions:
        """Return motions and loads for the present stretch of time."""
        motions = list(self.state.motions.values())
        return pack_acts(motions, self._loads, self.layout.place, self.start, self.until)

    @property
    def _loads(self) -> list[Load]:
        """Return the loads that change in time, and after them how lengths of threads do."""
        return [*self.timed, *lengths(self.state)]

    @property
    def _profiles(self) -> list[TimeProfile]:
        """Return the profiles of all that changes in time but motions."""
        found = [term.profile for load in self._loads for term in load.terms]
        found += [profile for field in self.state.fields for _, profile in field.changes]
        return found

    @property
    def is_changing(self) -> bool:
        """Return whether what acts depends on the time, or on where nodes were listed."""
        moving = self.state.motions or self._profiles
        return bool(moving) or self.state.contact is not None

    def fields(self) -> Fields:
        """Return the forces on nodes other than springs, around the positions ``around``."""
        embedded = self.state.embedding
        fields = (self._embedding if one is embedded else one for one in self.state.fields)
        groups = [group for field in fields for group in self._passes(field)]
        found = [(kernel, RecordTable(table)) for group in groups for kernel, table in group]
        places = [kernel_address(kernel, table) for kernel, table in found]
        tables = [table.address for _, table in found]
        return Fields(
            first=np.cumsum([0, *map(len, groups)]),
            address=np.array(places, dtype=np.int64),
            table=np.array(tables, dtype=np.int64),
            power=np.zeros((len(found), 2)),
            kept=tuple(table for _, table in found),
        )

    def _passes(self, field: Field) -> list[list[Pass]]:
        """Return groups of what threads can compute of a field at a time."""
        acts = acts_of(field.changes, self.start, self.until)

        def table_of(part: Field) -> Any:
            if self.share < 1.0:
                part = part.within(self.share * part.reach)
            return part.table(self.layout.place, acts, self.around)

        # Divided before items are left out, so that sums are in the same order without these.
        divided = parts_of(field, self.layout.place)
        moving = ([part.moving(self.still) for part in group] for group in divided)
        groups = [[part for part in group if part is not None] for group in moving]
        if len(divided) > 1 or len(divided[0]) > 1:
            return [[(part.kernel, table_of(part)) for part in group] for group in groups]
        return [
            [(field.kernel, table) for table in tables]
            for part in groups[0]
            for tables in part.in_parts(table_of(part), self.team.parts)
        ]

    def reels(self) -> RestLengthActuators:
        """Return the springs whose rest lengths change."""
        state, springs = self.state, self.springs
        row = np.full(self.spring_count, -1)
        # Dead springs keep the rest lengths with which they pass for none.
        acting = state.alive[springs.ids] & ((springs.stiffness > 0.0) | (springs.law > 0))
        row[springs.ids[acting]] = np.flatnonzero(acting)
        ends = self.layout.place[state.springs.ends]
        first = len(state.motions) + len(self.timed)
        return reels(list(state.reelings.values()), row, ends, first)

    def internal(self) -> InternalVariables:
        """Return the internal variables of springs."""
        rows = self.state.network.remembering(SPRINGS)
        assert self.springs.inelastic is not None
        return table_of(self.springs.inelastic, self.layout.place[rows])

    def embedding(self) -> EmbeddingTable:
        """Return the embedded nodes."""
        assert self._embedding is not None
        return self._embedding.table(self.layout.place, self.acts(), self.around)

    def guides(self) -> GuideTable:
        """Return the guided nodes that have places."""
        guides = self.state.guides
        assert guides is not None
        place = self.layout.place[guides.nodes]
        return GuideTable(place[place >= 0], guides.projections.reshape(-1, 9)[place >= 0])

    def longest_step(self, looks: int) -> float:
        """Return the largest step that follows motions and loads of the present stretch [s]."""
        motions = self.state.motions.values()
        return longest_step(motions, self._profiles, self.start, self.until, looks)

    def next_knot(self, time: float, until: float) -> float:
        """Return the next time at which a motion or load has a knot, at most ``until`` [s]."""
        times = knots(self.state.motions.values(), self._profiles)
        later = times[(times > time) & (times < until)]
        return float(later[0]) if len(later) else until
