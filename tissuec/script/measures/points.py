"""Numbers at the points of elements: of a subject, and as means around nodes.

Shared arguments:
    snapshot: At one time or several.
    numbers: Takes elements, which recall what they remember, and positions of all nodes [m],
        shape (node, 3); returns numbers in any unit, shape (element, point).
"""

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np

from tissuec.model.network import Floats, Indices
from tissuec.script.measures.snapshot import Snapshot

PointNumbers: TypeAlias = Callable[[Any, Floats], Floats]


def _states(snapshot: Snapshot) -> Iterator[tuple[int, Floats, Floats]]:
    """Yield the number, positions and velocities of each state, shape (node, 3)."""
    shape = (-1, *snapshot.position.shape[-2:])
    states = zip(
        snapshot.position.reshape(shape), snapshot.velocity.reshape(shape), strict=True
    )
    yield from ((row, *state) for row, state in enumerate(states))


def at_points(
    snapshot: Snapshot, nodes: Indices, numbers: PointNumbers
) -> tuple[Floats, Floats]:
    """Return numbers at the points of intact elements all of whose nodes are among some.

    Args:
        nodes: Shape (node,).

    Returns:
        Numbers, shape (…, n), and the volumes of the points as drawn [m³], shape (n,).
    """
    times = np.shape(snapshot.time)
    parts, volumes = [np.zeros((*times, 0))], [np.zeros(0)]
    for field in snapshot.state.elements:
        elements, used = field.intact(snapshot.state.alive).inside(nodes)
        volume = elements.shares.sum(axis=2)
        found = np.empty((int(np.prod(times)), *volume.shape))
        for row, places, speeds in _states(snapshot):
            for part, own in elements.recalling(speeds).in_blocks():
                found[row, part] = numbers(own, places[used])
        parts.append(found.reshape(*times, -1))
        volumes.append(volume.ravel())
    return np.concatenate(parts, axis=-1), np.concatenate(volumes)


def around_nodes(snapshot: Snapshot, numbers: PointNumbers) -> Floats:
    """Return the means of numbers around each node, by the volumes that it has of points.

    They are 0 where no element is left, shape (…, node).
    """
    found = np.zeros(snapshot.position.shape[:-1])
    rows, volume = found.reshape(-1, found.shape[-1]), np.zeros(found.shape[-1])
    for field in snapshot.state.elements:
        elements = field.intact(snapshot.state.alive)
        for _, own in elements.in_blocks():
            np.add.at(volume, own.nodes, own.node_volumes)
        for row, places, speeds in _states(snapshot):
            for _, own in elements.recalling(speeds).in_blocks():
                each = np.einsum("eqa,eq->ea", own.shares, numbers(own, places))
                np.add.at(rows[row], own.nodes, each)
    return found / np.where(volume > 0.0, volume, 1.0)
