"""The frozen schedule of a net: legs between events, each with the fields that act.

Which springs are alive, who is held, and when, is found by going through the script once; then
it stays as it is, so that the motion is a smooth function of the numbers of the net. Ruptures
and conditions come at the times at which the engine finds them.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.compiled.calls import kernel_address
from tissuec.compiled.record_tables import RecordTable
from tissuec.forces.acting.load import Load
from tissuec.forces.acting.symmetry import SymmetryPlanes
from tissuec.forces.fields import Field, acts_of
from tissuec.forces.matrices import with_numbers
from tissuec.kernels.derivative_records import ActingFields, Links, SpringMemory, Values
from tissuec.learn.derivatives.planes import (
    add_nothing,
    project_changes,
    project_weights,
    pull_nothing,
    push_nothing,
)
from tissuec.learn.parameters.numbers import (
    NO_MEMORY,
    ActingNumbers,
    Fields,
    NumberOrder,
    acting_numbers,
    derivatives_of,
    hidden_nodes,
    memory_of,
    named_fields,
    numbers,
    remembering,
)
from tissuec.mechanics.state import PrescribedMotion, State
from tissuec.model.network import Floats, Indices, Network

AFTER = 1e-9  # of the time of a last event: what follows, to show what is after it


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


class Leg(Struct, frozen=True, eq=False, dict=True):
    """A stretch of time in which nothing but the state changes.

    Attributes:
        start, stop: [s].
        alive: Springs that act, shape (spring,).
        held: Nodes that are no unknowns, shape (node,).
        stopped: Nodes whose velocity is set when the leg begins, shape (node,).
        given: Their velocities [m/s], shape (node, 3).
        gravity: [m/s²], shape (3,).
        drag: Of all nodes alike [N s/m].
        holders: Who holds which nodes.
        changes: What the script made of arrays, by name.
        fields: What acts beside springs, by name; its own numbers do not count.
        numbers: Of these fields.
        planes: Of symmetry; None without any.
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
    drag: float
    holders: Mapping[str, Indices]
    motions: tuple[PrescribedMotion, ...]
    loads: tuple[Load, ...]
    changes: Mapping[str, ArrayChange]
    fields: Fields
    numbers: ActingNumbers
    planes: SymmetryPlanes | None
    remembers: bool
    _paths: dict[bytes, PrescribedPaths] = field(default_factory=dict[bytes, PrescribedPaths])

    @cached_property
    def alive_springs(self) -> NDArray[np.bool_]:
        """Return which springs act, shape (spring,)."""
        found = np.zeros(self.network.spring_count, dtype=bool)
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

    def present(self, values: Values) -> Values:
        """Return the numbers that hold on this leg."""
        changed = {
            name: change.factor * getattr(values, name) + change.more
            for name, change in self.changes.items()
        }
        own = values.fields[self.numbers.places]
        return values._replace(**changed, fields=own)

    def past(self, by: Values) -> Values:
        """Return derivatives by the numbers of this leg as those by the first numbers."""
        changed = {
            name: change.factor * getattr(by, name) for name, change in self.changes.items()
        }
        return by._replace(**changed, fields=self.numbers.of_all(by.fields))

    def links(self, values: Values) -> Links:
        """Return the acting springs, with the masses of this leg."""
        network, free, springs = self.network, ~self.held, self.alive
        moves = free.copy()
        if self.remembers:
            springs = springs[~remembering(network)[springs]]
            moves[hidden_nodes(network)] = False
        low, high = network.springs.ends[springs].astype(np.int64).T
        inverse = np.where(free, 1.0 / values.mass, 0.0)
        return Links(
            np.ascontiguousarray(low),
            np.ascontiguousarray(high),
            springs.astype(np.int64),
            network.springs.law[springs].astype(np.int64),
            inverse,
            (moves[:, None] * self.gravity).ravel(),
            np.where(moves, self.drag + values.drag, 0.0),
            self.loaded,
            self.driven,
        )

    @property
    def memory(self) -> SpringMemory:
        """Return the springs that remember."""
        return memory_of(self.network, self.alive) if self.remembers else NO_MEMORY

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
            nodes = acting.nodes[~self.held[acting.nodes]]
            where = np.searchsorted(loaded, nodes)
            load[:, where] += acting.at(inside)[:, None]
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
    held, network = state.held, state.network
    acting = named_fields(state)
    if not remembers:
        acting = {name: field.relaxed for name, field in acting.items()}
    remembers = remembers and network.relaxes
    if remembers:
        # What is remembered moves as nodes of 1 kg do, whatever the scene weighs.
        hidden = hidden_nodes(network)
        held[hidden] = False
        factor, more = changes.get("mass", ArrayChange(np.ones(len(held)), np.zeros(len(held))))
        factor, more = factor.copy(), more.copy()
        factor[hidden], more[hidden] = 0.0, 1.0
        changes = {**changes, "mass": ArrayChange(factor, more)}
    return Leg(
        state.time,
        stop,
        state.network,
        np.flatnonzero(state.alive),
        held,
        held | set_anew,
        state.velocity.copy(),
        state.gravity.copy(),
        state.drag,
        dict(state.holders),
        tuple(state.motions.values()),
        tuple(state.loads.values()),
        dict(changes),
        acting,
        acting_numbers(acting, state.alive, order.fields),
        state.symmetry,
        remembers,
    )


_NONE: Indices = np.zeros(0, dtype=np.int64)


def present_fields(leg: Leg, values: Values) -> dict[str, Field]:
    """Return the fields of a leg with their numbers, by name.

    Args:
        values: The numbers of this leg.
    """
    found: dict[str, Field] = {}
    start = 0
    for name, force in leg.fields.items():
        columns, stop = derivatives_of(force).columns, start + len(numbers(force))
        found[name] = with_numbers(force, columns, values.fields[start:stop])
        start = stop
    return found


def acting_fields(
    leg: Leg, fields: Fields, x: Floats, planes: SymmetryPlanes | None = None
) -> ActingFields:
    """Return the fields of a leg for compiled code.

    Args:
        leg: The leg, without knots of what fields follow in between.
        fields: As ``present_fields`` returns them.
        x: Positions from which nodes move by no more than the reach of a field [m], shape
            (3 node,).
        planes: Of symmetry, that act last.
    """
    place = np.arange(leg.network.node_count, dtype=np.int64)
    tables: list[RecordTable] = []
    calls: list[tuple[int, int, int]] = []
    counts = [0]

    def enter(one: Field, loops: Sequence[Callable[..., None]], count: int) -> None:
        acts = acts_of(one.changes, leg.start, leg.stop)
        table = RecordTable(one.table(place, acts, x.reshape(-1, 3)))
        force, backwards, forwards = (kernel_address(loop, table) for loop in loops)
        calls.append((force, backwards, forwards))
        tables.append(table)
        counts.append(count)

    if planes is not None:
        enter(planes, (add_nothing, project_weights, push_nothing), 0)
    for one in fields.values():
        _, back, forward = derivatives_of(one)
        enter(one, (one.kernel, back, forward), len(numbers(one)))
    if planes is not None:
        enter(planes, (planes.kernel, pull_nothing, project_changes), 0)
    addresses = np.array(calls, dtype=np.int64).reshape(-1, 3).T
    return ActingFields(
        *(np.ascontiguousarray(part) for part in addresses),
        table=np.array([table.address for table in tables], dtype=np.int64),
        first=np.cumsum(counts),
        weight=np.zeros(3 * len(place) if tables else 0),
        power=np.zeros(2),
        kept=tuple(tables),
    )
