"""A sphere: an icosahedron whose triangles are divided in four, again and again."""

from itertools import combinations
from typing import Annotated, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.fields import Length, OneOf, Position, Whole
from tissuec.core.structs import replace
from tissuec.meshes.generators import MESHES, Mesh
from tissuec.meshes.generators.joining import require_limits, springs


@MESHES.member("sphere")
class Sphere(Struct, frozen=True, eq=False):
    """A closed surface of nearly equal triangles around a centre.

    n subdivisions give 10·4ⁿ + 2 surface nodes, 30·4ⁿ surface springs and 20·4ⁿ triangles. The
    net is symmetric about each coordinate plane through the centre. From one subdivision on, it
    has a node in each coordinate direction. Spokes run to an additional node at the centre,
    which is the last one.

    Attributes:
        centre: Centre of the sphere.
        radius: Distance of every surface node from the centre.
        subdivisions: How often each of the 20 triangles is divided in four.
        interior: Springs through the inside: none, spokes (to the centre) or antipodes
            (across).
    """

    centre: Position
    radius: Length
    subdivisions: Annotated[int, Whole(at_least=0, at_most=7)]
    interior: Annotated[str, OneOf(("none", "spokes", "antipodes"))] = "none"

    def __post_init__(self) -> None:
        require_limits(self)

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        return replace(self, subdivisions=self.subdivisions + 1)

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        surface, edges = 10 * 4**self.subdivisions + 2, 30 * 4**self.subdivisions
        if self.interior == "spokes":
            return surface + 1, edges + surface
        return surface, edges + (surface // 2 if self.interior == "antipodes" else 0)

    def build(self) -> Mesh:
        """Return nodes, springs, and the surface with its normals pointing outwards."""
        unit, triangles = icosahedron()
        for _ in range(self.subdivisions):
            unit, triangles = divide(unit, triangles)
        count = len(unit)
        pairs = [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
        if self.interior == "antipodes":
            pairs.append(np.stack((np.arange(count), antipodes(unit)), axis=1))
        if self.interior == "spokes":
            pairs.append(np.stack((np.arange(count), np.full(count, count)), axis=1))
            unit = np.vstack((unit, np.zeros(3)))
        position = np.asarray(self.centre, dtype=np.float64) + self.radius * unit
        return Mesh(position, springs(len(unit), *pairs), triangles.astype(np.int32))


def icosahedron() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the 12 corners on the unit sphere, shape (12, 3), and 20 outward triangles."""
    golden = (1.0 + 5.0**0.5) / 2.0
    flat = np.array([(0.0, y, z) for y in (-1.0, 1.0) for z in (-golden, golden)])
    corner = np.concatenate([np.roll(flat, shift, axis=1) for shift in range(3)])
    near = np.linalg.norm(corner[:, None] - corner, axis=2) < 2.1  # every edge has length 2
    triples = np.array(
        [
            t
            for t in combinations(range(12), 3)
            if all(near[a, b] for a, b in combinations(t, 2))
        ]
    )
    inward = np.linalg.det(corner[triples]) < 0.0
    triples[inward] = triples[inward][:, ::-1]
    return corner / np.sqrt(1.0 + golden**2), triples


def divide(
    unit: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the net in which the middle of each edge became a node on the unit sphere.

    Args:
        unit: Nodes on the unit sphere, shape (node, 3).
        triangles: Node numbers, shape (triangle, 3).
    """
    count = len(unit)
    first, second = triangles, np.roll(triangles, -1, axis=1)
    keys = np.minimum(first, second) * count + np.maximum(first, second)
    edges, which = np.unique(keys, return_inverse=True)
    low, high = np.divmod(edges, count)
    # Sums and roots treat both signs alike, so that opposite nodes stay exact negatives.
    middle = unit[low] + unit[high]
    middle /= np.sqrt((middle**2).sum(axis=1, keepdims=True))
    ab, bc, ca = (count + which.reshape(-1, 3)).T
    a, b, c = triangles.T
    quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    divided = np.stack([np.stack(quarter, axis=1) for quarter in quarters], axis=1)
    return np.vstack((unit, middle)), divided.reshape(-1, 3)


def antipodes(unit: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the number of the node opposite to each node of a net from ``divide``.

    Args:
        unit: Nodes on the unit sphere, shape (node, 3), with an exact negative of each.
    """
    opposite = np.empty(len(unit), dtype=np.int64)
    opposite[np.lexsort(unit.T)] = np.lexsort(-unit.T)
    return opposite
