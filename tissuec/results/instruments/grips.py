"""What holds nodes, drawn where it holds them, and the way its shaft leads."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from tissuec.core.arrays import cross, directions
from tissuec.core.names import key_of
from tissuec.model.network import Floats, Indices
from tissuec.results.instruments import Course
from tissuec.results.instruments.meshes import mesh_of
from tissuec.results.moments import Moments
from tissuec.results.tools import FIX, with_ends

_SHARE = 1.0 / 15.0  # of the run, that an instrument takes to come or to go
_SMALLEST, _LARGEST = 0.03, 0.1  # units of instruments, beside the size of the bodies
_NEAR = 1e-9  # of the duration


class Scenery(NamedTuple):
    """What instruments are placed in.

    Attributes:
        moments: Of the run.
        shown: Rows in frames of the nodes of bodies, shape (node,).
        size: Diagonal of the box around the bodies at first [m].
        pause: Time in which an instrument comes or goes [s].
    """

    moments: Moments
    shown: Indices
    size: float
    pause: float

    @classmethod
    def of(cls, moments: Moments) -> "Scenery":
        """Return that of a run."""
        trajectory = moments.trajectory
        bodies = trajectory.network.body_nodes or trajectory.network.node_count
        shown = np.flatnonzero(trajectory.nodes < bodies)
        first = trajectory.position[0][shown]
        size = float(np.linalg.norm(np.ptp(first, axis=0))) if len(shown) else 0.0
        pause = _SHARE * float(moments.times[-1] - moments.times[0])
        return cls(moments, shown, size or 1.0, pause or 1.0)

    def kind(self, tool: str) -> str:
        """Return the kind of a tool; "" where the scene is not known to say it."""
        return str(self._entries(tool).get("kind", ""))

    def shaft(self, tool: str) -> Floats | None:
        """Return the unit vector that the scene gives the shaft of a tool, shape (3,)."""
        found = self._entries(tool).get("shaft")
        return None if found is None else np.array(found) / np.linalg.norm(found)

    def _entries(self, tool: str) -> Mapping[str, Any]:
        tools: Mapping[str, Any] = self.moments.trajectory.manifest.get("tools", {})
        key = key_of(tool)
        for name, entries in tools.items():
            if key_of(name) == key:
                return entries
        return {}

    def row(self, time: float) -> int:
        """Return the first row at or after a time [s]: at an event, the net before it."""
        times = self.moments.times
        found = np.searchsorted(times, time - _NEAR * float(times[-1]))
        return int(min(found, len(times) - 1))

    def last_row(self, time: float) -> int:
        """Return the last row at or before a time [s]; of the sides of an event, the first."""
        row = self.row(time)
        later = self.moments.times[row] > time + _NEAR * float(self.moments.times[-1])
        return max(0, row - bool(later))

    def tissue(self, row: int) -> Floats:
        """Return the nodes of bodies in a row [m], shape (node, 3)."""
        return self.moments.vectors_in("position", row)[self.shown]

    def rows_of(self, nodes: Indices) -> Indices:
        """Return the rows in frames of nodes of the network that are shown, shape (shown,)."""
        recorded = self.moments.trajectory.nodes
        return np.searchsorted(recorded, nodes[np.isin(nodes, recorded)])

    def unit(self, length: float, tool: str) -> float:
        """Return the unit of an instrument [m].

        Args:
            length: That it spans [m].
            tool: Its name; the scene may give its size.
        """
        if (size := self._entries(tool).get("size")) is not None:
            return float(size)
        return float(np.clip(length, _SMALLEST * self.size, _LARGEST * self.size))


_WIDEST = 0.35  # [rad]: of each arm
_EDGE = 0.05  # of what is held: the part at either side that is at a jaw
_SHORTEST = 0.5  # of an arm, along which nodes touch it
_OPEN = 0.05  # [rad]: by which arms open before they hold
_AWAY = 1.5  # units that forceps come from
_NEAREST = 0.05  # of the size of the bodies: of the tissue that is looked at around them
_TURNS = 36  # directions in which they could open


def grips(scenery: Scenery) -> Iterator[Course]:
    """Yield an instrument for each time that one holds nodes."""
    trajectory = scenery.moments.trajectory
    shaped = {tool.name for tool in trajectory.network.tools if tool.shapes}
    bodies = {part.name for part in trajectory.network.parts}
    others = {FIX, *trajectory.sets, *shaped, *bodies}
    for hold, stop in with_ends(trajectory.holds):
        nodes = scenery.rows_of(hold.nodes)
        if hold.holder not in others and len(nodes) and hold.time < scenery.moments.times[-1]:
            yield _grip(scenery, hold.holder, nodes, (hold.time, stop))


def _grip(scenery: Scenery, name: str, nodes: Indices, held: tuple[float, float]) -> Course:
    """Return an instrument that holds some nodes.

    Args:
        scenery: Where.
        name: Of the tool.
        nodes: Rows in frames, shape (node,).
        held: From when until when [s].
    """
    moments = scenery.moments
    first, last = scenery.row(held[0]), scenery.last_row(min(held[1], float(moments.times[-1])))
    rows = np.clip(np.arange(len(moments)), first, max(first, last))
    points = moments.of_held("position", nodes)[rows]
    begin = points[0]
    kind = scenery.kind(name)
    kind = kind if kind in ("needle", "clamp") else "forceps"
    shaft = scenery.shaft(name)
    if shaft is None and kind == "needle":
        shaft = _onwards(scenery, nodes, first)
    axes = _axes(begin, scenery.tissue(first), shaft)
    local = begin @ axes.T
    spans = np.ptp(local, axis=0)
    unit = scenery.unit(max(spans[0], spans[2]) / 1.1, name)
    place, grip = _between_jaws(local, mesh_of(kind).pivot * unit)
    turns = rotations(begin, points)
    shift = place @ axes - begin.mean(axis=0)
    origin = points.mean(axis=1) + np.einsum("rij,j->ri", turns, shift)
    # From 1, before and after, to 0 while it holds.
    away = np.clip(np.maximum(held[0] - moments.times, moments.times - held[1])
                   / scenery.pause, 0.0, 1.0)  # fmt: skip
    seen = np.einsum("rij,kj->rki", turns, axes)
    origin = origin + seen[:, 2] * (_AWAY * unit * away)[:, None]
    life = (held[0] - scenery.pause, held[1] + scenery.pause)
    return Course(kind, name, unit, life, origin, seen, grip + _OPEN * away)


def _between_jaws(held: Floats, arm: float) -> tuple[Floats, float]:
    """Return where forceps work whose jaws touch nodes on both sides, and their angle [rad].

    With the outermost nodes x1 and x2, d1 and d2 below the pivot, where a jaw is at ± d tan(a),
    tan(a) = (x2 - x1) / (d1 + d2). The tips are at the deeper side.

    Args:
        held: Nodes along the axes of the forceps [m], shape (node, 3).
        arm: From the pivot to the tips [m]; 0 without jaws.

    Returns:
        The place along these axes [m], shape (3,); the angle is limited.
    """
    low, high = held.min(axis=0), held.max(axis=0)
    place = (low + high) / 2.0
    if not arm:
        return place, 0.0
    edge = _EDGE * (high[0] - low[0])
    left = held[held[:, 0] <= low[0] + edge].mean(axis=0)
    right = held[held[:, 0] >= high[0] - edge].mean(axis=0)
    place[1:] = (left[1] + right[1]) / 2.0, min(left[2], right[2])
    depth = arm - np.array([left[2], right[2]]) + place[2]
    depth = np.maximum(depth, _SHORTEST * arm)
    slope = min((high[0] - low[0]) / float(depth.sum()), float(np.tan(_WIDEST)))
    place[0] = (low[0] + high[0] + slope * (depth[0] - depth[1])) / 2.0
    return place, float(np.arctan(slope))


def _onwards(scenery: Scenery, nodes: Indices, row: int) -> Floats | None:
    """Return the direction in which a thread would continue beyond nodes, shape (3,).

    Args:
        scenery: Where.
        nodes: Rows in frames, shape (node,).
        row: When.

    Returns:
        None if no spring leads to them, or those around them balance.
    """
    ends = scenery.moments.trajectory.ends
    inside = np.isin(ends, nodes)
    across = ends[inside.sum(axis=1) == 1]
    place = scenery.moments.vectors_in("position", row)
    own = np.isin(across, nodes)
    way = (place[across[own]] - place[across[~own]]).sum(axis=0)
    length = float(np.linalg.norm(way))
    return way / length if length > 0.0 else None


def _axes(held: Floats, tissue: Floats, shaft: Floats | None) -> Floats:
    """Return the axes of forceps, which open where the tissue is thinnest, shape (3, 3).

    Args:
        held: Nodes that they hold [m], shape (node, 3).
        tissue: All nodes [m], shape (node, 3).
        shaft: Its direction, if it is known, shape (3,).
    """
    middle = (held.max(axis=0) + held.min(axis=0)) / 2.0
    shaft = free_shaft(middle, tissue) if shaft is None else shaft
    reach = max(
        3.0 * float(np.linalg.norm(held - middle, axis=1).max()), _NEAREST * _size(tissue)
    )
    around = tissue[np.linalg.norm(tissue - middle, axis=1) <= reach]
    plain = frame_along(shaft)
    turn = np.linspace(0.0, np.pi, _TURNS, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    across = np.asarray(circle @ plain[:2], dtype=float)
    x = across[int(np.ptp(around @ across.T, axis=0).argmin())]
    return np.stack([x, cross(shaft, x), shaft])


def _size(points: Floats) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def rotations(reference: Floats, points: Floats) -> Floats:
    """Return the rotations that turn points into others best (Kabsch 1976), (row, 3, 3).

    None where the points lie on a line.

    Args:
        reference: [m], shape (point, 3).
        points: [m], shape (row, point, 3).
    """
    flat = reference - reference.mean(axis=0)
    sizes = np.linalg.svd(flat, compute_uv=False) if len(flat) > 1 else np.zeros(3)
    if len(flat) < 3 or sizes[1] <= 1e-6 * sizes[0]:
        return np.broadcast_to(np.eye(3), (len(points), 3, 3))
    moved = points - points.mean(axis=1, keepdims=True)
    u, _, v = np.linalg.svd(np.einsum("rni,nj->rij", moved, flat))
    u[:, :, 2] *= np.linalg.det(u @ v)[:, None]
    return np.asarray(u @ v)


_TRIED = 72  # directions in the plane
_SPREAD = 200  # directions in space
_ALONG = 1e-3  # part of a direction at right angles to another below which it leads along it
_UP = np.array([0.0, 0.0, 1.0])


def shaft_across(
    axis: Floats, foot: Floats, tissue: Floats, wanted: Floats | None = None
) -> Floats:
    """Return a unit vector at right angles to an axis that leads out of tissue, upwards.

    Args:
        axis: Unit vector, shape (3,).
        foot: Where the instrument works [m], shape (3,).
        tissue: Nodes around it [m], shape (node, 3).
        wanted: Where it leads as far as it can, shape (3,).
    """
    if wanted is not None:
        aside = wanted - (wanted @ axis) * axis
        if float(np.linalg.norm(aside)) > _ALONG:
            return aside / np.linalg.norm(aside)
    turn = np.linspace(0.0, 2.0 * np.pi, _TRIED, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    tried = np.asarray(circle @ frame_along(axis)[:2], dtype=float)
    return tried[int(np.argmax(_merit(tried, foot, tissue)))]


def frame_along(shaft: Floats) -> Floats:
    """Return unit vectors x, y and z, of which z is the given one, shape (3, 3)."""
    side = np.eye(3)[int(np.abs(shaft).argmin())]
    x = np.cross(side, shaft)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(shaft, x), shaft])


def free_shaft(foot: Floats, tissue: Floats) -> Floats:
    """Return a unit vector that leads out of tissue, upwards, shape (3,).

    Args:
        foot: Where the instrument works [m], shape (3,).
        tissue: Nodes around it [m], shape (node, 3).
    """
    tried = directions(_SPREAD)
    return tried[int(np.argmax(_merit(tried, foot, tissue)))]


def _merit(tried: Floats, foot: Floats, tissue: Floats) -> Floats:
    """Return how well directions suit: up, away from the middle, and through no tissue."""
    away = foot - tissue.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(tissue, axis=0))) or 1.0
    ways = (tissue - foot) / size
    far = np.linalg.norm(ways, axis=1)
    ways = ways[far > 0.02] / far[far > 0.02, None]
    # How many nodes stand within 25 degrees of each direction.
    blocked = (tried @ ways.T > 0.906).mean(axis=1) if len(ways) else np.zeros(len(tried))
    return tried @ (_UP + 1.5 * away / size) - 4.0 * np.sqrt(blocked)
