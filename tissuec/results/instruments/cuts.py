"""Scissors and scalpels: drawn where springs are cut."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from tissuec.model.network import Floats, Indices
from tissuec.results.instruments import Course
from tissuec.results.instruments.scenery import Scenery
from tissuec.results.instruments.shafts import shaft_across
from tissuec.results.recording import Event

_OPEN, _AFTER, _ALONG = 0.35, 0.2, 0.15  # [rad]: of each blade before, after and during a cut
_SPAN = 1.6  # units of tissue between blades
_AWAY = 1.5  # units that blades draw back by
_NEXT = "along|through|facing|from|to|by|using"  # what may follow a name
_WITH = re.compile(rf'"[^"]*"|\bwith\s+("[^"]*"|[^"]+?)(?=\s+(?:{_NEXT})\b|\s+\(|$)')


def cuts(scenery: Scenery) -> Iterator[Course]:
    """Yield an instrument for each sentence that cuts."""
    cut = (one for one in scenery.moments.trajectory.events if one.kind == "cut")
    events = [one for one in cut if len(_ends(scenery, one))]
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
    """Return the rows in frames of the ends of the springs that are cut, shape (spring, 2)."""
    trajectory = scenery.moments.trajectory
    return trajectory.ends[np.isin(trajectory.springs, event.springs)]


def _cut(scenery: Scenery, events: Sequence[Event]) -> Course:
    """Return the blades of one cut, which may go on through several events."""
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
