"""The shapes of tools, with which they touch: rods with round ends, openings and plates."""

from collections.abc import Iterator

import numpy as np

from tissuec.core.vectors import norm
from tissuec.model.network import Floats, ToolShape
from tissuec.results.instruments import Course
from tissuec.results.instruments.scenery import Scenery
from tissuec.results.instruments.shafts import frame_along

_TUBE = 0.3  # of the size of the bodies: how much of a nozzle is seen
_PLATE = 0.7  # of that size: half a side of the part of a plane that is seen


def tool_solids(scenery: Scenery) -> Iterator[Course]:
    """Yield the shapes of all tools, in the order of the network."""
    points, first = scenery.moments.tools(), 0
    if not points.shape[1]:
        return
    for tool in scenery.moments.trajectory.network.tools:
        for shape in tool.shapes:
            yield _shape(scenery, tool.name, shape, points[:, first : first + 2])
            first += 2


def _shape(scenery: Scenery, name: str, shape: ToolShape, points: Floats) -> Course:
    """Return a shape at every moment.

    Args:
        scenery: Where.
        name: Of the tool.
        shape: What its points carry.
        points: [m], shape (row, 2, 3).
    """
    way = points[:, 1] - points[:, 0]
    length = norm(way)
    axis = np.where(length[:, None] > 0.0, way, [0.0, 0.0, 1.0])
    axis = axis / norm(axis)[:, None]
    origin, size, setting = points[:, 0], shape.radius, length
    if shape.kind == "opening":  # its tube leads back from where the fluid leaves it
        axis, setting = -axis, np.full(len(points), _TUBE * scenery.size)
    if shape.kind == "plane":
        size = _PLATE * scenery.size
        middle = np.stack([_middle(scenery, row) for row in range(len(points))])
        origin = middle - ((middle - origin) * axis).sum(axis=1, keepdims=True) * axis
    axes = np.stack([frame_along(one) for one in axis])
    always = (float(scenery.moments.times[0]), np.inf)
    return Course(shape.kind, name, size, always, origin, axes, setting / size)


def _middle(scenery: Scenery, row: int) -> Floats:
    tissue = scenery.tissue(row)
    return np.asarray((tissue.max(axis=0) + tissue.min(axis=0)) / 2.0)
