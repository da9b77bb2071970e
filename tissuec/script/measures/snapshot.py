"""A view of a run at one time, or at several: what conditions, logs and expectations read.

Arrays of a snapshot may have leading axes, written ``…``: a batch of samples between two events
is one snapshot. Only what is needed is computed.
"""

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct, field
from msgspec.structs import force_setattr
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.mechanics import observables
from tissuec.mechanics.state import State
from tissuec.model import topology
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.script.measures import Subject

_NOTHING = np.zeros(0, dtype=np.int64)


class EnergyBalance(Struct, frozen=True, eq=False):
    """Energy balance since the start of the run [J]; each a number or of shape (…).

    Attributes:
        initial: Energy when the run began, after the events at 0 s.
        work: Done by external forces and by whoever drives nodes.
        dissipated: In dampers and by ambient damping.
        switched: Put in or taken out by events, such as a cut or a change of gravity.
        scale: Largest energy so far, by which the balance is judged.
    """

    initial: float = 0.0
    work: Floats | float = 0.0
    dissipated: Floats | float = 0.0
    switched: float = 0.0
    scale: Floats | float = 0.0

    def balance(self, energies: observables.Energies) -> Floats:
        """Return the energy that is there and should not be [J], shape (…)."""
        due = self.initial + self.work - self.dissipated + self.switched
        return energies.total - due

    def size(self, energies: observables.Energies) -> Floats:
        """Return how large the energies of this snapshot are [J], shape (…).

        The gravity energy is left out: where it is zero is a matter of the drawing.
        """
        parts = (energies.kinetic + energies.elastic, self.work, self.dissipated, self.switched)
        largest = np.abs(parts[0])
        for part in parts[1:]:
            largest = np.maximum(largest, np.abs(part))
        return largest


class Snapshot(Struct, frozen=True, eq=False, dict=True):
    """The state at a time, and what follows from it.

    Attributes:
        state: What is alive, held and set; its own state and time are ignored. Where
            threads are drawn in, its rest lengths are those of this time, shape (…, spring).
        time: [s], shape (…).
        position, velocity: State [m], [m/s], shape (…, node, 3).
        ruptured: True for entities that broke by themselves until now, shape (entity,).
        ledger: Energies of the run; None where they are not kept.
        pinned: Snapshots that conditions may look back to, by their times [s].
    """

    state: State
    time: Floats | float
    position: Floats
    velocity: Floats
    ruptured: NDArray[np.bool_]
    ledger: EnergyBalance | None = None
    pinned: Mapping[float, "Snapshot"] = field(default_factory=dict[float, "Snapshot"])

    def __post_init__(self) -> None:
        if self.state.reelings:  # rest lengths are those of this time
            force_setattr(self, "state", self.state.at(self.time))

    @classmethod
    def of(cls, state: State) -> "Snapshot":
        """Return the snapshot of a state, with nothing ruptured or pinned."""
        none = np.zeros(state.network.entity_count, dtype=bool)
        return cls(state, state.time, state.position, state.velocity, none)

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Return which nodes are held, shape (node,)."""
        return self.state.held

    @cached_property
    def tension(self) -> Floats:
        """Return the tension of every spring [N], shape (…, spring)."""
        return observables.tension(self.state, self.position, self.velocity)

    @cached_property
    def node_force(self) -> Floats:
        """Return the sum of the inner forces on every node [N], shape (…, node, 3)."""
        found = observables.inner_forces(self.state, self.time, self.position, self.velocity)
        vars(self).setdefault("tension", found.tension)  # which is needed, too
        return found.node

    @cached_property
    def pieces(self) -> NDArray[np.int32]:
        """Return which connected piece of its body each node belongs to, shape (node,)."""
        network = self.state.network
        own = network.of_bodies  # joints hold pieces together, and leave them pieces
        ends, alive = network.line_ends[own], self.state.alive_lines[own]
        if self.state.is_cut:
            of_springs = own & (np.arange(network.line_count) < network.spring_count)
            springs = network.line_ends[of_springs & self.state.alive_lines]
            ends, alive = np.concatenate([springs, self.state.joined_pairs]), None
        return topology.pieces(network.node_count, ends, alive)

    @cached_property
    def energies(self) -> observables.Energies:
        """Return kinetic, elastic and gravity energy of everything [J], each of shape (…)."""
        return observables.energies(self.state, self.time, self.position, self.velocity)

    def nodes(self, subject: "Subject") -> Indices:
        """Return the nodes of a subject, shape (n,); for a tool, those that it holds now."""
        if subject.weights is not None and subject.nodes is not None:
            return subject.nodes
        if subject.nodes is not None:
            return self.state.with_copies(subject.nodes)
        return self.state.holders.get(subject.name, _NOTHING)

    def mean(self, subject: "Subject", at_nodes: Floats) -> Floats:
        """Return the mean of the nodes of a subject, or what a point has of them.

        It is in the unit of the numbers, shape (…, column); NaN without nodes.

        Args:
            at_nodes: Numbers of all nodes, shape (…, node, column).
        """
        nodes = self.nodes(subject)
        if not len(nodes):
            return np.full((*at_nodes.shape[:-2], at_nodes.shape[-1]), np.nan)
        if subject.weights is not None:
            return np.einsum("a,...ak->...k", subject.weights, at_nodes[..., nodes, :])
        return at_nodes[..., nodes, :].mean(axis=-2)

    def lines(self, subject: "Subject") -> Indices:
        """Return the springs and edges of elements of a subject, shape (n,).

        Those of a tool are between nodes that it holds now.
        """
        if subject.nodes is not None:
            return subject.lines
        inside = np.zeros(self.state.network.node_count, dtype=bool)
        inside[self.nodes(subject)] = True
        return np.flatnonzero(inside[self.state.network.line_ends].all(axis=1))

    def intact(self, subject: "Subject") -> Indices:
        """Return those of its lines that are alive, shape (line,)."""
        lines = self.lines(subject)
        return lines[self.state.alive[lines]]

    def intact_springs(self, subject: "Subject") -> Indices:
        """Return those of its springs that are alive, shape (spring,)."""
        return self.state.network.springs_among(self.intact(subject))

    def elements(self, subject: "Subject") -> Indices:
        """Return the elements with all nodes in a subject, as entities, shape (n,).

        A set of springs has none.
        """
        if subject.is_springs:
            return _NOTHING
        return self.state.network.elements_within(self.nodes(subject))

    def with_ledger(self, ledger: EnergyBalance) -> "Snapshot":
        """Return this snapshot with a ledger, and with all that was computed already."""
        other = replace(self, ledger=ledger)
        computed = {name: value for name, value in vars(self).items() if name in _COMPUTED}
        vars(other).update(computed)
        return other

    def pick(self, chosen: int | Indices) -> "Snapshot":
        """Return one snapshot of a batch, or several, along its only leading axis.

        Args:
            chosen: An index, or indices of shape (n,).
        """
        ledger = self.ledger
        if ledger is not None:
            parts = {name: np.asarray(getattr(ledger, name))[chosen] for name in _IN_TIME}
            ledger = replace(ledger, **parts)
        return replace(
            self,
            time=np.asarray(self.time)[chosen],
            position=self.position[chosen],
            velocity=self.velocity[chosen],
            ledger=ledger,
        )


_COMPUTED = ("held", "tension", "node_force", "pieces", "energies")
_IN_TIME = ("work", "dissipated", "scale")
