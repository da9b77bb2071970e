"""Contact on too few nodes for the curvature of a tool, and nodes beyond planes of symmetry.

A tool presses on nodes. Its force converges as the contact radius becomes large compared with
the distance of nodes: a ball on one node alone presses with half the force of theory at the
same depth (H. Hertz, J. reine angew. Math. 92:156, 1881), on four or more nodes within some
15 %. The side of a capsule is curved across its line only, and needs more than one row of
nodes. Where contact acts on faces, these take the place of nodes: a ball touches six triangles
or more if its contact radius is about the size of a face. Tools that are thin compared with it
are left out. The check is made at the largest force.

A body and its mirror image touch only on the plane between them. Nothing holds other nodes on
their side: a dead load, or pressure, can push them through, into the mirror image.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

import numpy as np

from tissuec.core.arrays import norm, typical
from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.geometry.nearest import CAPSULE, places
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network, ToolPart
from tissuec.script.plan import Plan

if TYPE_CHECKING:
    from tissuec.forces.contact.contact import Contact

FEW_NODES = "few nodes in contact"
ENOUGH_FACES = 6  # triangles under a ball, the same
ENOUGH = 4  # nodes under a ball: its contact radius is then about the distance of nodes
ROW = 0.25  # of the distance of nodes: closer than that, nodes are in one row


class _Grip(NamedTuple):
    """Nodes or faces that a capsule touches.

    Attributes:
        nodes: Their numbers, shape (n,).
        force: With which it presses on them together [N].
        across: Extent of those beside its line, across it [m]; 0 of none.
        has_side: Whether there are any of these.
    """

    nodes: Indices
    force: float
    across: float
    has_side: bool


@WATCHES.member(FEW_NODES)
class FewNodes:
    """Watches on how many nodes of solids the capsules of tools press.

    Walls are left out: they bear a tool by their tension, wherever they touch it.
    """

    kind = FEW_NODES

    def __init__(self, network: Network, tools: list[ToolPart], bodies: list[BodyPart]):
        self._tools = tools
        self._bodies = [(body, _distance(network, body)) for body in bodies]

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without contact, such tools or solids."""
        if network.contact is None:
            return None
        tools = [t for t in network.tools if any(s.kind == "capsule" for s in t.shapes)]
        bodies = [body for body in network.bodies if tools and _is_solid(network, body)]
        return cls(network, tools, bodies) if bodies else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        contact = state.contact
        assert contact is not None, "otherwise there is no watch"
        for tool in self._tools:
            for body, distance in self._bodies:
                found = list(_touched(contact, position, tool, body))
                if not found:
                    continue
                count = len(np.unique(np.concatenate([one.nodes for one in found])))
                is_faced = contact.has_points_on(body.nodes)
                if any(one.has_side for one in found):
                    is_few = max(one.across for one in found) < ROW * distance
                else:
                    is_few = count < (ENOUGH_FACES if is_faced else ENOUGH)
                what = "face" if is_faced else "node"
                thinnest = min(s.radius for s in tool.shapes if s.kind == "capsule")
                yield Finding(
                    f"{tool.name} on {body.name}",
                    count if is_few else 0,
                    f"{tool.name} presses on too few {what}s of {body.name} for its curvature "
                    "when its force is largest",
                    "",
                    what,
                    f"the force depends on where {what}s are; use cells well below the radius "
                    f"of {show(thinnest, LENGTH)}",
                    tool.span,
                    sum(one.force for one in found),
                )


def _touched(
    contact: "Contact", position: Floats, tool: ToolPart, body: BodyPart
) -> Iterator[_Grip]:
    """Yield the nodes of a body that each capsule of a tool touches.

    Args:
        contact: Of the run.
        position: Of all nodes [m], shape (node, 3).
        tool: With capsules.
        body: Which is touched.
    """
    from tissuec.forces.contact.pairs import ContactPairs  # where something touches

    first, where, numbers, faces = body.nodes.start, position[body.nodes], None, None
    if contact.has_points_on(body.nodes):
        where, numbers, faces = contact.points_on(body.nodes, position)
    for shape, ends in zip(tool.shapes, position[tool.nodes].reshape(-1, 2, 3), strict=True):
        if shape.kind != "capsule" or (faces is not None and contact.is_thin(shape.radius)):
            continue
        low, high = ends.min(axis=0) - shape.radius, ends.max(axis=0) + shape.radius
        near = np.flatnonzero(((low < where) & (where < high)).all(axis=1))
        alike = np.full(len(near), shape.radius)
        corners = np.broadcast_to(ends[[0, 1, 1]], (len(near), 3, 3))
        place = places(where[near], np.full(len(near), CAPSULE), corners, alike)
        inside = np.flatnonzero(place.depth > 0.0)
        if not len(inside):
            continue
        place, near = place.some(inside), near[inside]
        own = first + near if numbers is None else numbers[near]
        pairs = ContactPairs(own, own, alike[inside], alike[inside], np.zeros_like(own))
        side = np.flatnonzero((place.weights[:, :2] > 0.0).all(axis=1))
        across = 0.0
        if len(side):
            normal = place.normal[side]
            way = np.cross(ends[1] - ends[0], normal.mean(axis=0))
            length = float(np.linalg.norm(way)) or 1.0
            across = shape.radius * float(np.ptp(normal @ way)) / length
        force = float(contact.pressure(pairs, place.depth).sum())
        yield _Grip(own if faces is None else faces[near], force, across, bool(len(side)))


def _is_solid(network: Network, body: BodyPart) -> bool:
    """Return whether a body has a surface and nodes inside of it, or cells."""
    if body.thread is not None:
        return False
    skin = np.unique(network.skin_of(body))
    size = body.nodes.stop - body.nodes.start
    return bool(len(skin)) and (body.cells is not None or len(skin) < size)


def _distance(network: Network, body: BodyPart) -> float:
    """Return the median distance of neighbours in the surface of a body [m]."""
    corners = network.position[network.skin_of(body)]
    return typical(norm(corners - np.roll(corners, 1, axis=1)))


BEYOND = "beyond a plane of symmetry"
#: Part of the size of the scene that nodes may be beyond a plane, by rounding.
ON_PLANE = 1e-6


@WATCHES.member(BEYOND)
class MirrorPlanes:
    """Watches on which side of planes of symmetry nodes are.

    Args:
        network: With planes.
    """

    kind: ClassVar[str] = BEYOND

    def __init__(self, network: Network):
        self._network, self._close = network, ON_PLANE * network.extent
        self._sides = [
            np.sign(self._away(number, network.position))
            * ~np.isin(np.arange(network.node_count), plane.nodes)
            for number, plane in enumerate(network.mirrored)
        ]
        assert network.guides is not None
        self._span = network.guides.span

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without planes of symmetry."""
        return cls(network) if network.mirrored else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies that have nodes on the other side of a plane."""
        beyond = np.zeros(len(position), dtype=bool)
        for number, side in enumerate(self._sides):
            beyond |= side * self._away(number, position) < -self._close
        for body in self._network.bodies:
            own = np.arange(self._network.node_count)[body.nodes]
            found = own[beyond[body.nodes]]
            where = ""
            if len(found):
                drawn = self._network.position[found[0]]
                place = ", ".join(show(float(x), LENGTH) for x in drawn)
                where = f"at node {self._network.node_ids[found[0]]}, drawn at ({place})"
            yield Finding(
                body.name, len(found),
                f"nodes of {body.name} are beyond a plane of symmetry, in their mirror image",
                where, "node",
                "nothing separates a body from its mirror image; load it less, or draw the "
                "whole body with contact", self._span,
            )  # fmt: skip

    def _away(self, number: int, position: Floats) -> Floats:
        """Return the distances of nodes from a plane [m], shape (node,)."""
        plane = self._network.mirrored[number]
        return np.asarray((position - plane.origin) @ plane.normal)
