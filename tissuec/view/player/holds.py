"""Fixed and held parts of a net, and the resultant forces of holds and instruments."""

from collections.abc import Container, Iterator, Sequence
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model import topology
from tissuec.model.network import Floats, Indices
from tissuec.results.instruments import Course
from tissuec.results.moments import Moments
from tissuec.results.recording import AXES
from tissuec.results.tools import FIX, with_ends
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.film import HeldTissue, SkinPiece
from tissuec.view.player.lifetimes import Mask, Timeline, lives
from tissuec.view.player.thinning import Thinning


class DrawnNet(Struct, frozen=True, eq=False):
    """The net that is drawn, in which held nodes form patches and edges.

    Attributes:
        thin: Which nodes are drawn.
        skin: Triangles between them.
        ends: Of springs between them, shape (spring, 2).
        at_skin: Which of these are edges of the skin, shape (spring,).
        edges: Ends of the edges of the skin, shape (edge, 2).
        sides: Numbers of the edges of each triangle, shape (triangle, 3).
    """

    thin: Thinning
    skin: SkinPiece
    ends: Indices
    at_skin: Mask
    edges: Indices
    sides: Indices

    @classmethod
    def of(cls, thin: Thinning, skin: SkinPiece, ends: Indices) -> Self:
        """Return the drawn net of a film.

        Args:
            thin: Which nodes are drawn.
            skin: Triangles between them.
            ends: Of springs between them, shape (spring, 2).
        """
        corners = skin.triangles.astype(np.int64)
        sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        pairs, key = np.sort(ends, axis=1), np.array([len(thin.kept), 1])
        edges, number = np.unique(sides, axis=0, return_inverse=True)
        at_skin = np.isin(pairs @ key, sides @ key)
        return cls(thin, skin, ends, at_skin, edges, number.reshape(-1, 3))

    def triangles(self, held: Mask) -> Mask:
        """Return which drawn triangles have held nodes only, shape (triangle,)."""
        return held[self.skin.triangles].all(axis=1) & ~self.skin.smooth

    def rims(self, held: Mask) -> Mask:
        """Return which edges of the skin border on one held triangle, shape (edge,)."""
        own = self.sides[self.triangles(held)].ravel()
        return np.bincount(own, minlength=len(self.edges)) == 1

    def springs(self, held: Mask) -> Mask:
        """Return which edges of the skin lead between held nodes outside of patches.

        Args:
            held: Which nodes are held, shape (node,).

        Returns:
            Shape (spring,).
        """
        covered = self._covered(held)[self.ends].all(axis=1)
        return held[self.ends].all(axis=1) & self.at_skin & ~covered

    def nodes(self, held: Mask) -> Mask:
        """Return which held nodes belong to no such triangle or spring, shape (node,)."""
        covered = self._covered(held)
        covered[self.ends[self.springs(held)]] = True
        return held & ~covered

    def _covered(self, held: Mask) -> Mask:
        covered = np.zeros(len(held), dtype=bool)
        covered[self.skin.triangles[self.triangles(held)]] = True
        return covered


def read_held(
    trajectory: Trajectory, timeline: Timeline, drawn: DrawnNet, seen: Container[str]
) -> HeldTissue:
    """Return the fixed and held parts of a net.

    Args:
        timeline: The frames that are shown.
        seen: Tools that are drawn themselves, and not the single nodes that they hold.
    """
    every = list(_changes(trajectory, timeline, drawn.thin, ()))
    masks = list(_changes(trajectory, timeline, drawn.thin, seen))
    patches = np.zeros((len(drawn.skin.triangles), 2))
    found = lives(((at, drawn.triangles(held)) for at, held in every), len(patches))
    rims = lives(((at, drawn.rims(held)) for at, held in every), len(drawn.edges))
    longest = np.argsort(found.life[:, 1] - found.life[:, 0], kind="stable")
    patches[found.of[longest]] = found.life[longest]
    springs = lives(((at, drawn.springs(held)) for at, held in masks), len(drawn.ends))
    nodes = lives(((at, drawn.nodes(held)) for at, held in masks), len(drawn.thin.kept))
    rods = np.concatenate([drawn.ends[springs.of], np.stack([nodes.of, nodes.of], axis=1)])
    life = np.concatenate([springs.life, nodes.life])
    return HeldTissue(patches, rods, life, drawn.edges[rims.of], rims.life)


def _changes(
    trajectory: Trajectory, timeline: Timeline, thin: Thinning, seen: Container[str]
) -> Iterator[tuple[float, Mask]]:
    """Yield frames, and which of the drawn nodes are held from then on."""
    holders: dict[str, NDArray[np.integer]] = {}
    for hold in trajectory.holds:
        if hold.holder not in seen and hold.time <= timeline.times[-1]:
            holders[hold.holder] = hold.nodes
            held = np.unique(np.concatenate(list(holders.values())))
            shown = np.isin(trajectory.nodes, held)
            # Points of parts of cut elements, which follow the nodes, are not held.
            is_node = thin.kept < len(shown)
            kept = np.zeros(len(thin.kept), dtype=bool)
            kept[is_node] = shown[thin.kept[is_node]]
            yield float(timeline.frame_of(hold.time)), kept


class HoldingForce(Struct, frozen=True, eq=False):
    """A force on tissue, at one place.

    Attributes:
        name: Of the tool or set.
        life: When it acts [s].
        place: Where [m], shape (row, 3).
        force: On the tissue [N], shape (row, 3).
    """

    name: str
    life: tuple[float, float]
    place: Floats
    force: Floats


def read_pulls(moments: Moments, seen: Sequence[Course] = ()) -> list[HoldingForce]:
    """Return the forces of all that holds nodes, and of tools whose force is logged.

    Args:
        moments: Of the run.
        seen: The instruments that are drawn.
    """
    return [*_holds(moments), *_contacts(moments), *_blades(moments, seen)]


def _holds(moments: Moments) -> Iterator[HoldingForce]:
    """Yield minus the sum of spring forces on held nodes, where all of them are recorded."""
    trajectory = moments.trajectory
    for hold, stop in with_ends(trajectory.holds):
        is_fixed, begins = hold.holder == FIX, hold.time < moments.times[-1]
        for nodes in _connected(trajectory, hold.nodes) if is_fixed else [hold.nodes]:
            if begins and np.isin(nodes, trajectory.nodes).all():
                rows = np.searchsorted(trajectory.nodes, nodes)
                place = moments.of_held("position", rows).mean(axis=1)
                force = 0.0 - moments.of_held("force", rows).sum(axis=1)
                name = _name_of(trajectory, nodes) if is_fixed else hold.holder
                yield HoldingForce(name, (hold.time, stop), place, force)


def _name_of(trajectory: Trajectory, nodes: Indices) -> str:
    """Return the smallest set or body that contains fixed nodes; "fixed" without any.

    Copies that cuts have made of nodes count as these.
    """
    network = trajectory.network
    drawn, every = network.parents[nodes], np.arange(network.node_count)
    groups = [
        (group.name, group.indices)
        for group in trajectory.sets.values()
        if group.what == "nodes"
    ]
    groups += [(body.name, every[body.nodes]) for body in network.bodies]
    around = [one for one in groups if np.isin(drawn, one[1]).all()]
    return min(around, key=lambda one: len(one[1]), default=("fixed", nodes))[0]


def _connected(trajectory: Trajectory, nodes: Indices) -> list[Indices]:
    """Return nodes in groups that springs join as drawn, such as both ends of a tube."""
    network = trajectory.network
    place = np.full(network.node_count, -1)
    drawn, number = np.unique(network.parents[nodes], return_inverse=True)
    place[drawn] = np.arange(len(drawn))
    ends = place[network.line_ends]
    inner = ends[(ends >= 0).all(axis=1)]
    labels = np.asarray(topology.pieces(len(drawn), inner.astype(np.int32)))[number]
    return [nodes[labels == label] for label in np.unique(labels)]


def _contacts(moments: Moments) -> Iterator[HoldingForce]:
    """Yield the forces of tools with shapes, as far as they are logged."""
    trajectory, tools = moments.trajectory, moments.tools()
    network = trajectory.network
    for tool in network.tools:
        first = int(tool.nodes.start) - network.body_nodes
        force = _logged(moments, tool.name) if tool.shapes else None
        if force is not None:
            begin = float(trajectory.logs[f"force of {tool.name}"].time[0])
            yield HoldingForce(tool.name, (begin, np.inf), tools[:, first], force)


def _blades(moments: Moments, seen: Sequence[Course]) -> Iterator[HoldingForce]:
    """Yield the forces that move blades on, as far as they are logged."""
    for course in seen:
        force = _logged(moments, course.name) if course.kind == "scissors" else None
        if force is not None:
            yield HoldingForce(course.name, course.life, course.origin, force)


def _logged(moments: Moments, tool: str) -> Floats | None:
    """Return the force of a tool at all moments [N], shape (row, 3); None if none is logged."""
    log = moments.trajectory.logs.get(f"force of {tool}")
    if log is None or log.columns != AXES or not len(log.time):
        return None
    time, value = log.with_jumps()
    axes = [np.interp(moments.times, time, value[:, axis]) for axis in range(3)]
    return np.stack(axes, axis=1)
