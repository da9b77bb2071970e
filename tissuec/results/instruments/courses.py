"""Which instruments are seen, and where each is: solid tools, and what cuts."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.model.network import Floats, Indices, ToolShape
from tissuec.results.instruments import JET, Course
from tissuec.results.instruments.grips import (
    Scenery,
    frame_along,
    free_shaft,
    grips,
    shaft_across,
)
from tissuec.results.moments import Moments
from tissuec.results.recording import Event


def courses(moments: Moments) -> tuple[Course, ...]:
    """Return all instruments that are seen in a run, without the shapes that tools have."""
    scenery = Scenery.of(moments)
    if not len(scenery.shown):
        return ()
    return (
        *grips(scenery), *cuts(scenery), *_handles(scenery), *_jets(scenery),
    )  # fmt: skip


def solids(moments: Moments) -> tuple[Course, ...]:
    """Return the shapes of the tools of a run, in the order of the network."""
    scenery = Scenery.of(moments)
    return tuple(tool_solids(scenery)) if len(scenery.shown) else ()


def _tools(scenery: Scenery, kind: str) -> list[tuple[str, float, NDArray[np.float64]]]:
    """Return name, radius and points of the shapes of tools of a kind, (row, 2, 3) each."""
    network, points = scenery.moments.trajectory.network, scenery.moments.tools()
    found: list[tuple[str, float, NDArray[np.float64]]] = []
    for tool in network.tools:
        first = int(tool.nodes.start) - network.body_nodes
        for number, shape in enumerate(tool.shapes):
            own = points[:, first + 2 * number : first + 2 * number + 2]
            if tool.kind == kind and own.shape[1] == 2:
                found.append((tool.name, shape.radius, own))
    return found


def _handles(scenery: Scenery) -> list[Course]:
    """Return the rods that the balls of probes are carried by."""
    found: list[Course] = []
    always = (float(scenery.moments.times[0]), np.inf)
    for name, radius, points in _tools(scenery, "probe"):
        if np.array_equal(points[:, 0], points[:, 1]):
            shaft = scenery.shaft(name)
            if shaft is None:
                shaft = free_shaft(points[0, 0], scenery.tissue(0))
            axes = np.broadcast_to(frame_along(shaft), (len(points), 3, 3))
            none = np.zeros(len(points))
            found.append(Course("handle", name, radius, always, points[:, 0], axes, none))
    return found


def _jets(scenery: Scenery) -> list[Course]:
    """Return the jets of nozzles while they flow."""
    found: list[Course] = []
    events = scenery.moments.trajectory.events
    for name, radius, points in _tools(scenery, "nozzle"):
        flows = [one for one in events if one.kind == "irrigate" and name in one.cause]
        if not flows:
            continue
        way = points[:, 1] - points[:, 0]
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        axes = np.stack([frame_along(-one) for one in way])
        reach = [_reach(scenery.tissue(row), points[row, 0], way[row], radius)
                 for row in range(len(points))]  # fmt: skip
        for event in flows:
            later = (one for one in events if one.time > event.time)
            ends = (one.time for one in later if (one.kind, one.place) == ("end", event.place))
            life = (event.time, next(ends, np.inf))
            found.append(
                Course(JET, name, radius, life, points[:, 0], axes, np.array(reach) / radius)
            )
    return found


def _reach(tissue: Floats, tip: Floats, way: Floats, radius: float) -> float:
    """Return how far a jet goes until it meets tissue [m].

    Args:
        tissue: Nodes [m], shape (node, 3).
        tip: Where it begins [m], shape (3,).
        way: Unit vector, shape (3,).
        radius: Of the opening [m].
    """
    ahead = (tissue - tip) @ way
    aside = np.linalg.norm(tissue - tip - ahead[:, None] * way, axis=1)
    met = ahead[(ahead > radius) & (aside < 3.0 * radius + 0.1 * ahead)]
    return float(met.min()) if len(met) else 20.0 * radius


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
    return Course(shape.seen_as, name, size, always, origin, axes, setting / size)


def _middle(scenery: Scenery, row: int) -> Floats:
    tissue = scenery.tissue(row)
    return np.asarray((tissue.max(axis=0) + tissue.min(axis=0)) / 2.0)


_OPEN, _AFTER, _ALONG = 0.35, 0.2, 0.15  # [rad]: of each blade before, after and during a cut
_SPAN = 1.6  # units of tissue between blades
_AWAY = 1.5  # units that blades draw back by
_NEXT = "along|through|facing|from|to|by|using"  # what may follow a name
_WITH = re.compile(rf'"[^"]*"|\bwith\s+("[^"]*"|[^"]+?)(?=\s+(?:{_NEXT})\b|\s+\(|$)')


def cuts(scenery: Scenery) -> Iterator[Course]:
    """Yield an instrument for each sentence that cuts, except tools shown by their shape."""
    trajectory = scenery.moments.trajectory
    shaped = {tool.name for tool in trajectory.network.tools if tool.shapes}
    cut = (one for one in trajectory.events if one.kind == "cut")
    unseen = (one for one in cut if scissors_of(one.cause) not in shaped)
    events = [one for one in unseen if len(_ends(scenery, one))]
    for _, same in groupby(events, key=lambda one: one.place):
        yield _cut(scenery, list(same))


def _normal(places: Floats, ways: Floats) -> Floats:
    """Return the normal of a cut: springs lead across it, and their middles hardly spread.

    Of all springs, each taken in the direction that it has across the cut, the mean leads
    straight across; which directions these are is found from each axis of space.

    Args:
        places: Middles of the springs [m], shape (spring, 3).
        ways: From one end of each to the other [m], shape (spring, 3).
    """
    found: list[tuple[float, Floats]] = []
    for normal in np.eye(3):
        for _ in range(10):
            mean = (np.where(ways @ normal < 0.0, -1.0, 1.0)[:, None] * ways).mean(axis=0)
            normal = mean / np.linalg.norm(mean)
        across = float(np.median(np.abs(ways @ normal)))
        found.append((across / (float((places @ normal).std()) + 0.1 * across), normal))
    return max(found, key=lambda one: one[0])[1]


def _ends(scenery: Scenery, event: Event) -> Indices:
    """Return the rows in frames of the ends of the lines that are cut, shape (line, 2)."""
    trajectory = scenery.moments.trajectory
    return trajectory.ends[np.isin(trajectory.lines, event.springs)]


def _cut(scenery: Scenery, events: Sequence[Event]) -> Course:
    """Return the blades of one cut, which can last over several events."""
    moments = scenery.moments
    places: list[Floats] = []
    ways: list[Floats] = []
    for event in events:
        position = moments.vectors_in("position", scenery.row(event.time))
        first, second = (position[one] for one in _ends(scenery, event).T)
        places.append((first + second) / 2.0)
        ways.append(second - first)
    every, way = np.concatenate(places), np.concatenate(ways)
    axis = _normal(every, way)
    middle = (every.max(axis=0) + every.min(axis=0)) / 2.0
    scissors = scissors_of(events[0].cause)
    tissue = scenery.tissue(scenery.row(events[0].time))
    shaft = shaft_across(axis, middle, tissue, scenery.shaft(scissors))
    axes = np.stack([np.cross(axis, shaft), axis, shaft])
    spans = np.ptp(every @ axes.T, axis=0)
    time = np.array([event.time for event in events])
    times = moments.times
    points = np.stack([one.mean(axis=0) for one in places]) if len(events) > 1 else middle[None]
    origin = np.stack([np.interp(times, time, points[:, k]) for k in range(3)], axis=1)
    before = np.clip((time[0] - times) / scenery.pause, 0.0, 1.0)
    after = np.clip((times - time[-1]) / scenery.pause, 0.0, 1.0)
    length = max(spans[0], spans[2]) / _SPAN / (1 if len(events) == 1 else 3)
    unit = scenery.unit(length, scissors)
    setting = np.zeros(len(times))
    if scissors:
        during = (before == 0.0) & (after == 0.0) & (len(events) > 1)
        setting = _OPEN * before + _AFTER * after + _ALONG * during * (times < time[-1])
    else:  # its edge is drawn through the surface of the tissue
        origin = origin + shaft * (float((every @ shaft).max()) - origin @ shaft)[:, None]
        if len(events) == 1:
            origin = origin + axes[0] * (spans[0] * (0.5 - before))[:, None]
    origin = origin + shaft * (_AWAY * unit * after)[:, None]
    life = (time[0] - scenery.pause, time[-1] + scenery.pause)
    seen = np.broadcast_to(axes, (len(times), 3, 3))
    kind = "scissors" if scissors else "scalpel"
    return Course(kind, scissors, unit, life, origin, seen, setting)


def scissors_of(sentence: str) -> str:
    """Return the name of the scissors that a sentence cuts with; "" without."""
    names = (found[1] for found in _WITH.finditer(sentence))
    return next((name.strip('"') for name in names if name), "")
