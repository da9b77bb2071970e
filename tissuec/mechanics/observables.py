"""Lengths, tensions, forces and energies of a net, for logs, conditions and the energy table.

Every function takes states with any number of leading axes, written ``…`` in the shapes, so
that a whole batch of samples is one call. Parameters are those of a :class:`State`, whose
rest lengths may have the leading axes of the states.

Shared arguments:
    state: Parameters of the network.
    time: Time [s], shape (…).
    position: Of all nodes [m], shape (…, node, 3).
    velocity: Of all nodes [m/s], shape (…, node, 3).
    springs: Indices of the springs, shape (spring,); all springs if None.
    nodes: Indices of the nodes, shape (n,); all nodes if None is allowed and given.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import dot, norm
from tissuec.core.keeping import kept_on_owner
from tissuec.forces.acting.embedding import EmbeddedNodes
from tissuec.forces.fields import Field
from tissuec.forces.springs.springs import flat, reach
from tissuec.mechanics.state import ALL, State
from tissuec.model.blocks import OF_ELEMENTS
from tissuec.model.network import Floats, Indices, Network

TOGETHER = 1 << 18  # springs that are evaluated at once: more need much memory, and take longer


def lengths(ends: NDArray[np.int32], position: Floats) -> Floats:
    """Return the distance between the ends of each spring [m], shape (…, spring)."""
    starts = range(0, max(len(ends), 1), TOGETHER)
    parts = (reach(ends[start : start + TOGETHER], position) for start in starts)
    found = [norm(part) for part in parts]
    return found[0] if len(found) == 1 else np.concatenate(found, axis=-1)


def elongation(ends: NDArray[np.int32], position: Floats, rest: Floats) -> Floats:
    """Return how far each spring is stretched beyond its rest length.

    Args:
        ends: Node pair of each spring, shape (spring, 2).
        position: Node positions [m], shape (…, node, 3).
        rest: Rest lengths [m], shape (spring,) or (…, spring).

    Returns:
        Elongation [m], shape (…, spring); negative where a spring is compressed.
    """
    return lengths(ends, position) - rest


def tension(
    state: State, position: Floats, velocity: Floats, springs: Indices | None = None
) -> Floats:
    """Return the tension of some springs [N], shape (…, spring)."""
    parts = _in_parts(state.network if springs is None else springs)
    found = [state.spring_force(part).pull(position, velocity).tension for part in parts]
    return found[0] if len(found) == 1 else np.concatenate(found, axis=-1)


def rest_lengths(state: State, velocity: Floats, springs: Indices | None = None) -> Floats:
    """Return rest lengths including their flow [m].

    The shape is (spring,), or (…, spring) where any rest length flows.
    """
    every = state.springs if springs is None else state.springs.some(springs)
    rest, memory = every.rest, every.inelastic
    return rest if memory is None else rest + memory.flowed(flat(velocity))


class NodeForces(NamedTuple):
    """Forces of springs, pressure and contact.

    Attributes:
        node: Their sum on every node [N], shape (…, node, 3).
        tension: Of every spring [N], shape (…, spring).
    """

    node: Floats
    tension: Floats


def inner_forces(
    state: State, time: Floats | float, position: Floats, velocity: Floats
) -> NodeForces:
    """Return the forces of springs, pressure and contact of the part that is drawn.

    The mirror image balances their components across planes of symmetry.
    """
    forces = _spring_forces(state, position, velocity)
    for acting in state.fields:
        acting.add_forces(time, position, velocity, forces.node)
    return forces


def _spring_forces(state: State, position: Floats, velocity: Floats) -> NodeForces:
    """Return sums over springs, in their order: they do not depend on the batch."""
    network = state.network
    total = np.zeros(position.shape)
    tension = np.empty((*position.shape[:-2], network.spring_count))
    for part in _in_parts(network):
        acting = state.spring_force(part)
        pull = acting.pull(position, velocity)
        tension[..., part] = pull.tension
        acting.add_forces(position, pull, total)
    return NodeForces(total, tension)


def _in_parts(springs: Network | Indices) -> Iterator[Indices | slice]:
    """Yield springs, or slices of all of them, in parts that memory has room for."""
    every = isinstance(springs, Network)
    count = springs.spring_count if every else len(springs)
    if every and count <= TOGETHER:
        yield ALL
        return
    for start in range(0, max(count, 1), TOGETHER):
        part = slice(start, min(start + TOGETHER, count))
        yield part if every else springs[part]


def applied_forces(state: State) -> Floats:
    """Return weight and external forces on every node now, jets aside [N], shape (node, 3)."""
    position = state.position
    total, still = np.zeros_like(position), np.zeros_like(position)
    for acting in state.outer:
        acting.add_forces(state.time, position, still, total)
    return total


def force_on(
    state: State,
    time: Floats | float,
    position: Floats,
    velocity: Floats,
    nodes: Indices,
) -> Floats:
    """Return the resultant of the inner forces on some nodes [N], shape (…, 3).

    Forces on embedded nodes are on their hosts, unless the nodes are all embedded.
    """
    fields = _separate_fields(state, nodes)
    if fields is None:
        return inner_forces(state, time, position, velocity).node[..., nodes, :].sum(axis=-2)
    total = pull_on(state, position, velocity, nodes)
    for acting in fields:
        pressed = np.zeros(position.shape)
        acting.add_forces(time, position, velocity, pressed)
        total += pressed[..., nodes, :].sum(axis=-2)
    return total


def _separate_fields(state: State, nodes: Indices) -> tuple[Field, ...] | None:
    """Return the fields whose forces on some nodes add up to the resultant, one by one.

    None if forces of all are moved to hosts before. Glue, as the support of nodes that are all
    embedded, is not among the fields.
    """
    if (embedding := state.embedding) is None:
        return state.fields
    if np.isin(nodes, embedding.nodes).all():
        return tuple(f for f in state.fields if not isinstance(f, EmbeddedNodes))
    return None


def torque_on(
    state: State,
    time: Floats | float,
    position: Floats,
    velocity: Floats,
    nodes: Indices,
    about: Floats,
) -> Floats:
    """Return the resultant torque of the forces of ``force_on`` [N m], shape (…, 3).

    Args:
        about: A point [m], shape (…, 3).
    """
    fields = _separate_fields(state, nodes)
    if fields is None:
        forces = inner_forces(state, time, position, velocity).node
        return _torque(position[..., nodes, :], forces[..., nodes, :], about)
    springs, sign = _boundary(state.network, np.asarray(nodes, dtype=np.int64).tobytes())
    ends = state.springs.ends[springs]
    inside = np.where(sign > 0.0, ends[:, 0], ends[:, 1])
    force = sign[:, None] * state.spring_force(springs).vectors(position, velocity)
    total = _torque(position[..., inside, :], force, about)
    for field in fields:
        pressed = np.zeros(position.shape)
        field.add_forces(time, position, velocity, pressed)
        total += _torque(position[..., nodes, :], pressed[..., nodes, :], about)
    return total


def _torque(place: Floats, force: Floats, about: Floats) -> Floats:
    return np.cross(place - about[..., None, :], force).sum(axis=-2)


def pull_on(state: State, position: Floats, velocity: Floats, nodes: Indices) -> Floats:
    """Return the resultant of the spring forces on some nodes [N], shape (…, 3).

    Springs with both ends among the nodes cancel and are left out, so a log of a few nodes
    costs only the springs that join them to the rest.
    """
    springs, sign = _boundary(state.network, np.asarray(nodes, dtype=np.int64).tobytes())
    return np.einsum(
        "s,...sk->...k", sign, state.spring_force(springs).vectors(position, velocity)
    )


@kept_on_owner(64)
def _boundary(network: Network, nodes: bytes) -> tuple[Indices, Floats]:
    """Return the springs between some nodes and the rest, and 1 where the first end is inside.

    Kept, because conditions need the force on the same nodes several times a step.
    """
    inside = np.zeros(network.node_count, dtype=bool)
    inside[np.frombuffer(nodes, dtype=np.int64)] = True
    first, second = inside[network.springs.ends].T
    springs = np.flatnonzero(first != second)
    return springs, np.where(first[springs], 1.0, -1.0)


def kinetic_energy(state: State, velocity: Floats, nodes: Indices | None = None) -> Floats:
    """Return Σ ½ m v² over the free nodes among ``nodes`` [J], shape (…)."""
    free = _free(state, nodes)
    if state.guides is not None:  # without what is prescribed, as of driven nodes
        velocity = velocity.copy()
        state.guides.keep(velocity)
    moving = velocity[..., free, :]
    return 0.5 * _sum_each(state.inertia[free] * dot(moving, moving))


def elastic_energy(
    state: State, position: Floats, velocity: Floats, springs: Indices | None = None
) -> Floats:
    """Return the energy stored in intact springs and their branches [J], shape (…)."""
    chosen: Network | Indices = state.network
    if springs is not None:
        chosen = springs[state.alive[springs]]
    elif not state.alive_springs.all():
        chosen = np.flatnonzero(state.alive_springs)
    total = np.zeros(position.shape[:-2])
    for part in _in_parts(chosen):
        energy = state.spring_force(part).energy(position, velocity)
        total = total + _sum_each(energy)
    return total


def energy_within(state: State, position: Floats, velocity: Floats, nodes: Indices) -> Floats:
    """Return the energy stored in elements, and by bending, between some nodes [J], shape (…).

    Args:
        state: What is intact.
        position, velocity: Of all nodes [m], [m/s], shape (…, node, 3).
        nodes: Shape (n,); an element or a fold counts if all of its nodes are among them.
    """
    inside = np.zeros(position.shape[-2], dtype=bool)
    inside[nodes] = True
    total = np.zeros(position.shape[:-2])
    for field in state.of_kind(*OF_ELEMENTS, "plates"):
        own = field.intact(state.alive)
        own = own.without(np.flatnonzero(~inside[own.nodes].all(axis=1)))
        total = total + own.recalling(velocity).energy(0.0, position)
    return total


def _sum_each(values: Floats) -> Floats:
    """Return the sums over the last axis, each the same whatever the other axes hold."""
    return np.add.reduce(np.ascontiguousarray(values), axis=-1)


class Energies(NamedTuple):
    """Energies at a moment [J], each of shape (…); pressure and contact count as elastic."""

    kinetic: Floats
    elastic: Floats
    gravity: Floats

    @property
    def total(self) -> Floats:
        """Return the sum of all energies [J], shape (…)."""
        return self.kinetic + self.elastic + self.gravity


def energies(
    state: State, time: Floats | float, position: Floats, velocity: Floats
) -> Energies:
    """Return the energies of the free nodes, of intact springs, of pressure and contact [J]."""
    elastic = elastic_energy(state, position, velocity)
    for acting in state.fields:
        elastic = elastic + acting.recalling(velocity).energy(time, position)
    weight = np.zeros(position.shape[:-2])
    for acting in state.outer:
        weight = weight + acting.energy(time, position)
    return Energies(kinetic_energy(state, velocity), elastic, weight)


def _free(state: State, nodes: Indices | None) -> Indices:
    """Return the free nodes, or those among ``nodes``, shape (free,)."""
    free = state.free
    return np.flatnonzero(free) if nodes is None else nodes[free[nodes]]
