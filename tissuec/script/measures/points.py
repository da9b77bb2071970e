"""Numbers at the points of elements: of a subject, and as means around nodes.

Shared arguments:
    snapshot: At one time or several.
    numbers: Takes elements, which recall what they remember, and positions of all nodes [m],
        shape (node, 3); returns numbers in any unit, shape (element, point, …).
"""

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np

from tissuec.model.network import Floats, Indices
from tissuec.script.measures import Subject
from tissuec.script.measures.snapshot import Snapshot

PointNumbers: TypeAlias = Callable[[Any, Floats], Floats]


def _states(snapshot: Snapshot) -> Iterator[tuple[int, Floats, Floats]]:
    """Yield the number, and positions and velocities of each state, shape (row, 3)."""
    each = (one.reshape(-1, *one.shape[-2:]) for one in (snapshot.position, snapshot.velocity))
    yield from ((row, *state) for row, state in enumerate(zip(*each, strict=True)))


def at_points(
    snapshot: Snapshot, nodes: Indices, numbers: PointNumbers
) -> tuple[Floats, Floats]:
    """Return numbers at the points of intact elements all of whose nodes are among some.

    Args:
        nodes: Shape (node,).

    Returns:
        Numbers, shape (…, n, …), and the volumes of the points as drawn [m³], shape (n,). There
        are no further axes where no element is left.
    """
    times = np.shape(snapshot.time)
    found: list[Floats] = []
    volumes = [np.zeros(0)]
    for field in snapshot.state.elements:
        elements, used = field.intact(snapshot.state.alive).inside(nodes)
        if not elements.item_count:
            continue
        rows = [
            np.concatenate([
                numbers(own, places[used])
                for _, own in elements.recalling(speeds).in_blocks()
            ])
            for _, places, speeds in _states(snapshot)
        ]  # fmt: skip
        each = np.stack(rows)
        found.append(each.reshape(*times, -1, *each.shape[3:]))
        volumes.append(elements.shares.sum(axis=2).ravel())
    if not found:
        return np.zeros((*times, 0)), volumes[0]
    return np.concatenate(found, axis=len(times)), np.concatenate(volumes)


def at_point(snapshot: Snapshot, subject: Subject, numbers: PointNumbers) -> Floats | float:
    """Return a number at a point of a body, from those at the points of its element.

    It has the unit of the numbers and the shape (…, …); it is 0 once the element is lost.
    """
    assert subject.nodes is not None and subject.of_points is not None
    own, volumes = at_points(snapshot, subject.nodes, numbers)
    if not len(volumes):
        return 0.0
    # Not by BLAS, whose sums depend on how many states there are at once.
    parts = np.moveaxis(own, np.ndim(snapshot.time), -1) * subject.of_points
    return np.ascontiguousarray(parts).sum(axis=-1)


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
