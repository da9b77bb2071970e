"""The frozen schedule of a net: legs between events, each with the fields that act.

Which springs are alive, who is held, and when, is found by going through the script once; then
it stays as it is, so that the motion is a smooth function of the numbers of the net. Ruptures
and conditions come at the times at which the engine finds them.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.compiled.calls import kernel_address
from tissuec.compiled.record_tables import RecordTable
from tissuec.core.structs import replace
from tissuec.forces.acting.load import Load
from tissuec.forces.fields import Field, acts_of
from tissuec.forces.matrices import with_numbers
from tissuec.forces.springs.spring_items import SpringItems, items_of
from tissuec.kernels.derivative_records import ActingFields, Links, Values
from tissuec.kernels.records import GuideTable
from tissuec.learn.derivatives.guides import (
    add_nothing,
    project_changes,
    project_forces,
    project_weights,
    pull_nothing,
    push_nothing,
)
from tissuec.learn.parameters.numbers import (
    Fields,
    NumberOrder,
    acting_numbers,
    derivatives_of,
    in_rows,
    internal_rows,
    numbers,
)
from tissuec.mechanics.state import PrescribedMotion, State
from tissuec.model.guides import Guides
from tissuec.model.network import Floats, Indices, Network

AFTER = 1e-9  # of the time of a last event: what follows, to show what is after it

_NONE: Indices = np.zeros(0, dtype=np.int64)


class ArrayChange(NamedTuple):
    """Effect of a script on an array: factor times the initial number, plus more."""

    factor: Floats
    more: Floats


class PrescribedPaths(NamedTuple):
    """Prescribed motions and loads at some times.

    Attributes:
        place: Of driven nodes [m], shape (time, 3 driven).
        speed: Of driven nodes [m/s], shape (time, 3 driven).
        load: Forces that change in time [N], shape (time, 3 loaded).
    """

    place: Floats
    speed: Floats
    load: Floats


class ActingForces(NamedTuple):
    """What acts, with its numbers among all.

    Attributes:
        springs: Those that act.
        fields: What acts beside them, by name; its own numbers do not count.
        places: Of the numbers of springs in the vector of all, shape (n,).
        places_of_fields: Of those of fields, shape (n,).
    """

    springs: tuple[SpringItems, ...]
    fields: Fields
    places: Indices
    places_of_fields: Indices

    @classmethod
    def of(
        cls, springs: tuple[SpringItems, ...], fields: Fields, places_of_fields: Indices,
        order: NumberOrder,
    ) -> "ActingForces":  # fmt: skip
        """Return what acts.

        Args:
            springs, fields: As the attributes.
            places_of_fields: As the attribute, shape (n,).
            order: Of all numbers.
        """
        count, found = order.sizes["rest"], [_NONE]
        for one in springs:
            own = order.places["memory"].start + one.springs[:, None] + count * one.memory_rows
            constants = order.places["constants"]
            found += [
                *(order.places[name].start + one.springs for name in SPRING_ARRAYS),
                own.ravel(), np.arange(constants.start, constants.stop),
            ]  # fmt: skip
        return cls(springs, fields, np.concatenate(found), places_of_fields)

    def some(self, springs: NDArray[np.bool_], order: NumberOrder) -> "ActingForces":
        """Return the same with some of the springs only.

        Args:
            springs: Those of the network that stay, shape (spring,).
            order: Of all numbers.
        """
        kept = [(one, np.flatnonzero(springs[one.springs])) for one in self.springs]
        some = tuple(one.only(items) for one, items in kept if len(items))
        return ActingForces.of(some, self.fields, self.places_of_fields, order)

    @property
    def numbers(self) -> Indices:
        """Return the places of all that acts, springs first, shape (number,)."""
        return np.concatenate([self.places, self.places_of_fields])

    def with_numbers(self, values: Values) -> tuple[tuple[SpringItems, ...], Fields]:
        """Return springs and fields with the numbers of a leg."""
        forces = [*self.springs, *self.fields.values()]
        ends = np.cumsum([len(numbers(force)) for force in forces])
        made = [
            with_numbers(force, derivatives_of(force).columns, own)
            for force, own in zip(forces, np.split(values.numbers, ends)[:-1], strict=True)
        ]
        count = len(self.springs)
        return tuple(made[:count]), dict(zip(self.fields, made[count:], strict=True))


#: Arrays of all springs, in the order of the numbers of ``SpringItems``.
SPRING_ARRAYS = ("stiffness", "damping", "rest")


class Leg(Struct, frozen=True, eq=False, dict=True):
    """A stretch of time in which nothing but the state changes.

    Attributes:
        start, stop: [s].
        alive: Springs that act, shape (spring,).
        held: Nodes, and rows of internal variables, that are no unknowns, shape (row,).
        stopped: Nodes whose velocity is set when the leg begins, shape (node,).
        given: Their velocities [m/s], shape (node, 3).
        gravity: [m/s²], shape (3,).
        weighing: Weights over those that masses would have, shape (node,).
        drag: Of all nodes alike [N s/m].
        holders: Who holds which nodes.
        changes: What the script made of arrays, by name.
        acting: What acts.
        guides: Nodes that are free in some directions only; None without any.
        order: Of all numbers.
        remembers: Whether what springs remember changes; at rest, it does not.
    """

    start: float
    stop: float
    network: Network
    alive: Indices
    held: NDArray[np.bool_]
    stopped: NDArray[np.bool_]
    given: Floats
    gravity: Floats
    weighing: Floats
    drag: float
    holders: Mapping[str, Indices]
    motions: tuple[PrescribedMotion, ...]
    loads: tuple[Load, ...]
    changes: Mapping[str, ArrayChange]
    acting: ActingForces
    guides: Guides | None
    order: NumberOrder
    remembers: bool
    _paths: dict[bytes, PrescribedPaths] = field(default_factory=dict[bytes, PrescribedPaths])

    @cached_property
    def is_alive(self) -> NDArray[np.bool_]:
        """Return which springs and elements are there, shape (entity,)."""
        found = np.zeros(self.network.entity_count, dtype=bool)
        found[self.alive] = True
        return found

    @property
    def driven(self) -> Indices:
        """Return the nodes that are moved, shape (driven,)."""
        return np.unique(np.concatenate([_NONE, *(m.nodes for m in self.motions)]))

    @property
    def loaded(self) -> Indices:
        """Return the free nodes with external forces, shape (loaded,)."""
        nodes = np.unique(np.concatenate([_NONE, *(load.nodes for load in self.loads)]))
        return nodes[~self.held[nodes]]

    @property
    def factors(self) -> Mapping[str, Floats]:
        """Return the dimensionless factors of the script on entries of arrays, by name.

        They have the shape (node,) or (spring,).
        """
        return {name: change.factor for name, change in self.changes.items()}

    def changed(self, vector: Floats) -> Floats:
        """Return all numbers with what the script has changed, shape (number,)."""
        found = vector.copy()
        for name, change in self.changes.items():
            part = self.order.array(found, name)
            part[:] = change.factor * part + change.more
        return found

    def present(self, vector: Floats, acting: ActingForces | None = None) -> Values:
        """Return the numbers that hold on this leg.

        Args:
            vector: All numbers in SI units, shape (number,).
            acting: Part of what acts.
        """
        found, numbers = self.changed(vector), (acting or self.acting).numbers
        mass, drag = (self.order.array(found, name) for name in ("mass", "drag"))
        return Values(mass, drag, found[numbers])

    @property
    def nothing(self) -> Values:
        """Return zeros in the places of the numbers of this leg."""
        sizes = len(self.held), len(self.held), len(self.acting.numbers)
        return Values(*(np.zeros(size) for size in sizes))

    def past(self, by: Values, acting: ActingForces | None = None) -> Floats:
        """Return derivatives by the numbers of this leg as those by all numbers at 0 s.

        Args:
            acting: Part of what acts.

        Returns:
            In the units of ``by``, shape (number,).
        """
        found = np.zeros(self.order.size)
        np.add.at(found, (acting or self.acting).numbers, by.numbers)
        for name in ("mass", "drag"):
            self.order.array(found, name)[:] = getattr(by, name)
        for name, factor in self.factors.items():
            self.order.array(found, name)[:] *= factor
        return found

    def links(self, values: Values) -> Links:
        """Return the nodes, with the masses of this leg."""
        free = ~self.held
        moves = free.copy()
        if self.remembers:
            moves[internal_rows(self.network)] = False
        drag = self.drag + values.drag
        pull = (moves * self.weighing)[:, None] * self.gravity
        if (guides := self.guides) is not None:  # the mirror image brakes the other part
            drag[guides.nodes] -= self.drag * (1.0 - guides.share)
            guides.keep(pull)
        return Links(
            np.where(free, 1.0 / values.mass, 0.0),
            pull.ravel(),
            np.where(moves, drag, 0.0),
            self.loaded,
            self.driven,
        )

    def paths(self, times: Floats) -> PrescribedPaths:
        """Return prescribed positions and velocities at some times [s], shape (time,)."""
        key = times.tobytes()
        if key not in self._paths:
            self._paths[key] = self._prescribed(times)
        return self._paths[key]

    def _prescribed(self, times: Floats) -> PrescribedPaths:
        driven, loaded = self.driven, self.loaded
        place, speed = np.zeros((2, len(times), len(driven), 3))
        load = np.zeros((len(times), len(loaded), 3))
        # Profiles that jump at either end are taken from inside.
        inside = np.clip(times, *self._inside)
        for motion in self.motions:
            where = np.searchsorted(driven, motion.nodes)
            place[:, where], speed[:, where] = motion.at(inside)
        for acting in self.loads:
            moves = ~self.held[acting.nodes]
            where = np.searchsorted(loaded, acting.nodes[moves])
            load[:, where] += acting.at(inside)[:, moves]
        if self.guides is not None:
            _, own, of = np.intersect1d(loaded, self.guides.nodes, return_indices=True)
            within = self.guides.projections[of]
            load[:, own] = np.einsum("nij,tnj->tni", within, load[:, own])
        shape = len(times), -1
        return PrescribedPaths(place.reshape(shape), speed.reshape(shape), load.reshape(shape))

    @property
    def _inside(self) -> tuple[float, float]:
        margin = 1e-12 * (self.stop - self.start)
        return self.start + margin, self.stop - margin


class EventSchedule(Struct, frozen=True, eq=False):
    """All legs of a run, in order."""

    legs: tuple[Leg, ...]

    @property
    def stop(self) -> float:
        """Return when the last leg ends [s]."""
        return self.legs[-1].stop

    def until(self, time: float) -> "EventSchedule":
        """Return the part of this before a time [s], which is later than 0 s."""
        near = 1e-12 * self.stop
        kept = [leg for leg in self.legs if leg.start <= time + near]
        time = max(time, kept[-1].start * (1.0 + AFTER))
        if kept[-1].stop > time + near:
            kept[-1] = replace(kept[-1], stop=time, _paths={})
        return EventSchedule(tuple(kept))

    def leg_at(self, times: Floats) -> Indices:
        """Return the number of the leg of each time [s], both of shape (time,)."""
        starts = np.array([leg.start for leg in self.legs])
        near = 1e-12 * max(self.stop, 1e-300)
        return np.maximum(np.searchsorted(starts, times + near, side="right") - 1, 0)


def leg_of(
    state: State,
    stop: float,
    changes: Mapping[str, ArrayChange],
    order: NumberOrder,
    set_anew: NDArray[np.bool_] | bool = False,
    *,
    remembers: bool = True,
) -> Leg:
    """Return the leg that begins with a state whose events are over.

    Args:
        stop: End of the leg [s].
        changes: What the script changed in arrays, by name.
        remembers: Whether what springs remember changes.
        set_anew: Which free nodes were given their velocities by events, shape (node,).
    """
    network, rows = state.network, np.arange(state.network.row_count)
    held = np.append(state.held, rows[network.internal_rows] >= 0)
    acting = state.named_fields
    if not remembers:
        acting = {name: field.relaxed for name, field in acting.items()}
    remembers = remembers and network.relaxes
    if remembers:
        held[internal_rows(network)] = False  # what is remembered moves as nodes of 1 kg do
    alive = np.flatnonzero(state.alive)
    laws, constants = order.laws or network.springs.laws, order.sizes["constants"]
    acting_springs = alive[alive < network.spring_count]
    springs = tuple(items_of(network, acting_springs, laws, constants, remember=remembers))
    own = order.places["fields"].start + acting_numbers(acting, state.alive, order.fields)
    return Leg(
        state.time,
        stop,
        state.network,
        alive,
        held,
        held | set_anew,
        state.velocity.copy(),
        state.gravity.copy(),
        in_rows(state.weighing, network, 1.0),
        state.drag,
        dict(state.holders),
        tuple(state.motions.values()),
        tuple(state.loads.values()),
        dict(changes),
        ActingForces.of(springs, acting, own, order),
        state.guides,
        order,
        remembers,
    )


def acting_fields(
    leg: Leg, fields: Sequence[Field], x: Floats, guides: Guides | None = None
) -> ActingFields:
    """Return springs and fields for compiled code.

    Args:
        leg: The leg, without knots of what fields follow in between.
        fields: Those that act, with their numbers.
        x: Positions from which nodes move by no more than the reach of a field [m], shape
            (3 node,).
        guides: What they leave of the forces of all fields acts.
    """
    place = np.arange(leg.network.row_count, dtype=np.int64)
    position = x.reshape(-1, 3)[: leg.network.node_count]
    tables: list[RecordTable] = []
    calls: list[tuple[int, int, int]] = []
    counts = [0]

    def enter(record: Any, loops: Sequence[Callable[..., None]], count: int) -> None:
        table = RecordTable(record)
        force, backwards, forwards = (kernel_address(loop, table) for loop in loops)
        calls.append((force, backwards, forwards))
        tables.append(table)
        counts.append(count)

    guided = guides and GuideTable(guides.nodes, guides.projections.reshape(-1, 9))
    if guided is not None:
        enter(guided, (add_nothing, project_weights, push_nothing), 0)
    for one in fields:
        _, back, forward = derivatives_of(one)
        acts = acts_of(one.changes, leg.start, leg.stop)
        enter(one.table(place, acts, position), (one.kernel, back, forward), len(numbers(one)))
    if guided is not None:
        enter(guided, (project_forces, pull_nothing, project_changes), 0)
    addresses = np.array(calls, dtype=np.int64).reshape(-1, 3).T
    return ActingFields(
        *(np.ascontiguousarray(part) for part in addresses),
        table=np.array([table.address for table in tables], dtype=np.int64),
        first=np.cumsum(counts),
        weight=np.zeros(3 * len(place)),
        power=np.zeros(2),
        kept=tuple(tables),
    )
