"""The network in the form of the stepping code: renumbered, sorted, without idle parts.

Nodes keep their places for a whole run. A spring that dies is first set to zero in place, which
leaves every sum as if it were gone; the arrays are made again when many have died.
"""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.compiled.calls import kernel_address
from tissuec.compiled.record_tables import RecordTable, aligned_zeros
from tissuec.engine.blocks import Places, block_size, parts_of
from tissuec.engine.boundary_conditions import knots, lengths, longest_step, pack_acts
from tissuec.engine.chunks import are_chunks, chunks_of
from tissuec.engine.integrators import Integrator
from tissuec.engine.numbering import number_nodes
from tissuec.engine.operations import Features
from tissuec.engine.spring_runs import RunPlaces, are_shared, packed, places_of
from tissuec.engine.threads import ThreadTeam, useful
from tissuec.engine.unknowns import new_solver
from tissuec.forces import Field, acts_of
from tissuec.forces.branches import table_of
from tissuec.forces.load import Load
from tissuec.forces.rest_length import reels
from tissuec.kernels.records import (
    BoundaryConditions,
    Chunks,
    ContactTable,
    Fields,
    InternalVariables,
    Net,
    RestLengthActuators,
    Runs,
    Solver,
)
from tissuec.mechanics.state import State
from tissuec.model.network import SPRINGS, Floats, Indices, Network
from tissuec.model.profiles import TimeProfile
from tissuec.model.springs import Springs
from tissuec.model.topology import join_nodes_of, lower_and_upper

Bools = NDArray[np.bool_]
Pass = tuple[Callable[..., None], Any]  # a kernel of a field, and the table that it reads
LEAST = 1e-300  # [m]
#: Of ``Features``, what stepping code asks a net for.
FLAGS = (
    "watched", "crushed", "ledger", "reeled", "touched", "inelastic", "cornered",
)  # fmt: skip


class KernelInputs:
    """Translates states into the arrays of the stepping code.

    Its ``springs`` are those that act, by places of nodes, sorted by lower and then by upper
    node; ids are numbers in the network. Dead ones have no stiffness and viscosity and no
    limits; limits are of shape (0,) where none may break.

    Args:
        network: The network of the run.
        watched: Whether springs may break.
        ledger: Whether work and dissipation are integrated.
        threads: That may share loops over nodes and springs.
    """

    def __init__(self, network: Network, *, watched: bool, ledger: bool, threads: int = 1):
        bodies, shown, all_nodes = network.body_nodes, network.shown_nodes, network.node_count
        order, runs = number_nodes(network.position[:bodies], network.springs.ends)
        # Nodes of tools stand last, where measures of motion leave them out.
        self.order = np.concatenate(
            [order, np.arange(shown, all_nodes), np.arange(bodies, shown)]
        )
        self.place = np.empty_like(self.order)
        self.place[self.order] = np.arange(len(self.order))
        self._keeps_order = np.array_equal(self.place, np.arange(len(self.order)))
        self.watched, self.ledger = watched, ledger
        self.start = self.until = 0.0
        low, high = self._ends_of(network.springs.ends)
        self._sorted = None if _are_sorted(low, high) else np.lexsort((high, low))
        self.spring_count = network.spring_count
        self._acting = np.zeros(network.spring_count, dtype=bool)
        self._dead = 0
        # Of all springs, for the first choice of those that act; valid if tools stay in place.
        keeps_tools = np.array_equal(self.order[bodies:], np.arange(bodies, all_nodes))
        self._all_places = runs if keeps_tools else None
        self._places: RunPlaces | None = None  # once somebody has asked for them
        self._chunks: Chunks | None = None  # the same
        count = useful(threads, network.spring_count)
        if count > 1:
            several = are_chunks(all_nodes)
            if runs is not None:
                several = are_shared(high, block_size(low, high))
            count = count if several else 1
        self.team = ThreadTeam(count, all_nodes)
        self._solver: Solver | None = None

    def _ends_of(self, ends: NDArray[np.integer]) -> tuple[Places, Places]:
        """Return the lower and the upper place of nodes that springs join, shape (spring,)."""
        if self._keeps_order:
            return lower_and_upper(ends.astype(np.int32, copy=False))
        return lower_and_upper(self.place.astype(np.int32).take(ends))

    def update(self, state: State) -> None:
        """Update everything that acts in a state, but not positions and velocities."""
        self.state, self.around = state, state.position
        driven = [motion.nodes for motion in state.motions.values()]
        self.moved = np.zeros(state.network.node_count, dtype=bool)
        for nodes in driven:
            self.moved[nodes] = True
        self.held = state.held | self.moved
        self._update_springs(state)
        inverse = np.where(self.held, 0.0, 1.0 / state.mass)
        self.inverse_mass = self.inwards(inverse)
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
        push[self.held] = steady[self.held] = 0.0
        steady += push * inverse[:, None]
        self.drag = self.inwards(drag)
        self.push, self.steady = self.inwards(push), self.inwards(steady)
        self.driven = self.place[np.flatnonzero(self.moved)]

    def _update_springs(self, state: State) -> None:
        """Choose the springs that act and copy their present values."""
        acting = self._select(state)
        grown = bool(np.any(acting & ~self._acting))
        self._dead += int(np.count_nonzero(self._acting & ~acting))
        # Sums of energies would be grouped otherwise than in a run that is resumed.
        few = 0 if self.ledger else len(acting) // 20
        if grown or self._dead > few or not hasattr(self, "springs"):
            among = self._sorted
            ids = np.flatnonzero(acting) if among is None else among[acting[among]]
            self._ids = ids.astype(np.int32)
            ends = self._ends_of(state.springs.ends.take(self._ids, axis=0))
            # Whose columns are contiguous.
            self._ends = np.stack(ends).astype(np.int32, copy=False).T
            self._places = self._chunks = None
            if self._all_places is not None and len(acting) - len(ids) <= few:
                self._places = replace(self._all_places, place=self._all_places.place[ids])
            self._all_places, self._dead = None, 0
        self._acting = acting
        ids, alive = self._ids, acting[self._ids]
        all_act = bool(alive.all())
        in_order = self._sorted is None and len(ids) == len(acting)

        def present(values: NDArray[Any], dead: float) -> NDArray[Any]:
            """Return numbers of the springs; no copies of what takes no room, or is there."""
            if not all_act:
                return np.where(alive, values[ids], values.dtype.type(dead))
            if values.strides == (0,):
                return np.broadcast_to(values[:1], ids.shape)
            return values if in_order else values[ids]

        springs = state.springs
        stiffness, law = present(springs.stiffness, 0.0), present(springs.law, 0)
        jumps = (stiffness > 0.0) | (law > 0)
        rest = springs.rest if in_order else springs.rest[ids]
        inelastic = springs.inelastic
        if inelastic is not None:
            inelastic = inelastic.some(ids).only(alive).renumbered(self.place)
            # What flows or relaxes pulls at no length, too, and jumps as it turns over.
            rest, jumps = np.maximum(rest, LEAST), jumps | (inelastic.remembers & alive)
        self.springs = Springs(
            ends=self._ends,
            stiffness=stiffness,
            damping=present(springs.damping, 0.0),
            # Without a force that could jump, it does not matter when one turns over.
            rest=np.ascontiguousarray(rest) if jumps.all() else np.where(jumps, rest, 0.0),
            strength=present(springs.strength, np.inf) if self.watched else np.zeros(0),
            crush=present(springs.crush, np.inf) if self.watched else np.zeros(0),
            law=law,
            laws=springs.laws,
            ids=cast(Indices, ids),
            inelastic=inelastic,
        )
        # Kept, because features are asked for at every call of the stepping code.
        behaviour = self.springs.behaviour
        self._viscous = behaviour.is_viscous
        self._laws = self.springs.laws if law.any() else ()
        yields = inelastic is not None and bool(np.isfinite(inelastic.limit).any())
        self._cornered = yields or behaviour.has_corners
        self._crushed = self.watched and bool(np.isfinite(self.springs.crush).any())

    def _select(self, state: State) -> Bools:
        """Return which springs act on a free node, or matter otherwise, shape (spring,)."""
        ends = state.springs.ends
        acting = state.alive & ~join_nodes_of(ends, self.held)
        if self.moved.any():
            # Driven nodes feel them, whoever asks for that: steps shall not depend on it.
            one, other = self.moved[ends.T]
            acting |= state.alive & (one | other)
        if state.springs.inelastic is not None:
            acting |= state.alive & state.springs.inelastic.remembers
        # Whoever draws them in does work on them, also where their ends are held.
        for reeling in state.reelings.values():
            acting[reeling.springs] = state.alive[reeling.springs]
        return acting

    @property
    def features(self) -> Features:
        """Return the features that the stepping code needs."""
        return Features(
            viscous=self._viscous,
            watched=self.watched,
            crushed=self._crushed,
            ledger=self.ledger,
            banded=self._solver is not None and not self._solver.scratch.size,
            # Whatever may be drawn in, lest a second variant is compiled when it is.
            reeled=self.state.network.can_be_drawn_in,
            touched=self.state.contact is not None,
            inelastic=self.springs.inelastic is not None,
            cornered=self._cornered,
            laws=self._laws,
            in_runs=self._are_in_runs,
        )

    @property
    def _are_in_runs(self) -> bool:
        """Return whether springs are taken in runs: linear ones of constant lengths."""
        changing = self._laws or self.springs.inelastic is not None
        if changing or self.state.network.can_be_drawn_in:
            return False
        return self.places.is_worthwhile

    @property
    def places(self) -> RunPlaces:
        """Return the places of springs in runs."""
        if self._places is None:
            self._places = places_of(self._ends[:, 0], self._ends[:, 1])
        return self._places

    def solver(self) -> Solver:
        """Return arrays for the matrix of implicit steps, without a matrix in them."""
        low, high = self._ends.T
        kept = self._solver
        same = kept is not None and np.array_equal(kept.slot < 0, self.inverse_mass == 0.0)
        if kept is None or not same or self._solver_ids is not self._ids:
            kept = new_solver(low, high, self.inverse_mass > 0.0)
            self._solver, self._solver_ids = kept, self._ids
        kept.made[:] = 0.0
        return kept

    def is_banded(self) -> bool:
        """Return whether the matrix of implicit steps has a narrow band."""
        return not self.solver().scratch.size

    def inwards(self, vector: Floats) -> Floats:
        """Return numbers or vectors of nodes in the order of the stepping code, flat.

        Args:
            vector: In the order of the network and in any unit, shape (node,) or (node, 3).
        """
        flat = aligned_zeros(vector.size)
        # Clipped, because where it tests indices, NumPy keeps a second copy.
        np.take(vector, self.order, axis=0, out=flat.reshape(vector.shape), mode="clip")
        return flat

    def outwards(self, flat: Floats) -> Floats:
        """Return flat vectors in the order of the network, shape (…, node, 3).

        Args:
            flat: In the order of the stepping code and in any unit, shape (…, 3 node).
        """
        apart = flat.reshape(*flat.shape[:-1], -1, 3)
        # Contiguous, unlike what an index in the middle returns, and twice as fast.
        return apart.copy() if self._keeps_order else apart.take(self.place, axis=-2)

    def near(self, integrator: type[Integrator]) -> dict[str, Floats]:
        """Return the tension and the pressure above which springs are tested closely [N].

        Both have the shape (spring,).
        """
        part, springs = integrator.nearness, self.springs
        if not self.watched:
            # There is one form of the code for springs with laws, which looks at these as well.
            count = 0 if self.features.straight else len(springs.ids)
            return dict.fromkeys(("near", "near_crush"), np.full(count, np.inf))
        return {"near": part * springs.strength, "near_crush": part * springs.crush}

    def net(self, integrator: type[Integrator]) -> Net:
        """Return what acts, without operations on it."""
        springs, nodes, near = self.springs, len(self.order), self.near(integrator)
        low, high = springs.ends.T
        needed = self.features
        # Springs in runs have numbers of their own there; explicit steps need these, too, only
        # to look for what breaks.
        alone = not needed.in_runs or needed.watched or integrator.implicit
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
        """Return what only some scenes have, None for what a scene has nothing of."""
        fields = self.fields()
        kept = cast(tuple[RecordTable, ...], fields.kept)
        touches = (table.record for table in kept if type(table.record) is ContactTable)
        return {
            "reels": self.reels() if needed.reeled else None,
            "touches": next(touches, None),
            "internal": self.internal() if needed.inelastic else None,
            "runs": self.runs(near, needed) if needed.in_runs else None,
            "chunks": self.chunks() if not needed.in_runs or integrator.implicit else None,
            "fields": fields,
        }

    def chunks(self) -> Chunks:
        """Return chunks of nodes, for springs that are not taken in runs."""
        if self._chunks is None:
            low, high = self._ends.T
            self._chunks = chunks_of(low, high, len(self.order))
        return self._chunks

    def runs(self, near: dict[str, Floats], needed: Features) -> Runs:
        """Return springs in runs.

        Args:
            near: Limits [N] as returned by ``near``, shape (spring,).
            needed: The ``features``.
        """
        springs = self.springs
        return packed(
            self.places,
            len(self.order),
            self.team.parts,
            stiffness=springs.stiffness,
            damping=springs.damping if needed.viscous else None,
            rest=springs.rest,
            **(near if needed.watched else dict.fromkeys(near)),
        )

    def acts(self) -> BoundaryConditions:
        """Return motions and loads for the present stretch of time."""
        motions = list(self.state.motions.values())
        return pack_acts(motions, self._loads, self.place, self.start, self.until)

    @property
    def _loads(self) -> list[Load]:
        """Return the loads that change in time, and behind them how lengths of threads do."""
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
        """Return what acts on nodes beside springs, around the positions ``around``."""
        groups = [group for field in self.state.fields for group in self._passes(field)]
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
            return part.table(self.place, acts, self.around)

        groups = parts_of(field, self.place)
        if groups != [[field]]:
            return [[(part.kernel, table_of(part)) for part in group] for group in groups]
        parts = self.team.parts
        return [
            [(field.kernel, table) for table in tables]
            for tables in field.in_parts(table_of(field), parts)
        ]

    def reels(self) -> RestLengthActuators:
        """Return the springs whose rest lengths change."""
        state, springs = self.state, self.springs
        row = np.full(self.spring_count, -1)
        # Dead springs keep the rest lengths with which they pass for none.
        acting = state.alive[springs.ids] & ((springs.stiffness > 0.0) | (springs.law > 0))
        row[springs.ids[acting]] = np.flatnonzero(acting)
        ends = self.place[state.springs.ends]
        first = len(state.motions) + len(self.timed)
        return reels(list(state.reelings.values()), row, ends, first)

    def internal(self) -> InternalVariables:
        """Return what springs remember."""
        network = self.state.network
        nodes = network.remembering(SPRINGS)
        assert self.springs.inelastic is not None
        return table_of(self.springs.inelastic, self.place[nodes], network.position[nodes])

    def longest_step(self, looks: int) -> float:
        """Return the largest step that follows motions and loads of the present stretch [s]."""
        motions = self.state.motions.values()
        return longest_step(motions, self._profiles, self.start, self.until, looks)

    def next_knot(self, time: float, until: float) -> float:
        """Return the next time at which a motion or load has a knot, at most ``until`` [s]."""
        times = knots(self.state.motions.values(), self._profiles)
        later = times[(times > time) & (times < until)]
        return float(later[0]) if len(later) else until


def _are_sorted(low: Places, high: Places) -> bool:
    """Return whether springs stand by their lower and then by their upper ends."""
    upwards, same = low[1:] > low[:-1], low[1:] == low[:-1]
    return bool((upwards | (same & (high[1:] >= high[:-1]))).all())
