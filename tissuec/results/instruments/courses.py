"""Which instruments are seen, and where each is at every moment of a run."""

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats
from tissuec.results.instruments import JET, Course
from tissuec.results.instruments.cuts import cuts
from tissuec.results.instruments.grips import grips
from tissuec.results.instruments.scenery import Scenery
from tissuec.results.instruments.shafts import frame_along, free_shaft
from tissuec.results.instruments.solids import tool_solids
from tissuec.results.moments import Moments


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
