"""What is measured of a motion, as a smooth function of states and numbers, derived."""

from typing import NamedTuple, Protocol

import numpy as np

from tissuec.core.units import TIME, show
from tissuec.kernels.sensitivity import Links, Values
from tissuec.learn.course import Leg
from tissuec.learn.kernels import Kernels
from tissuec.learn.motion import Diverged
from tissuec.lesson import Fit
from tissuec.measures import Subject
from tissuec.network import Floats, Indices

_NONE: Indices = np.zeros(0, dtype=np.int64)


class Unseen(Diverged):
    """A tool that holds nothing is looked at; its arguments are the time [s] and its name."""

    def __str__(self) -> str:
        since = show(float(self.args[0]), TIME)
        return (
            f"{self.args[1]} holds nothing from {since} on, where something was measured of it"
        )


class View(NamedTuple):
    """A state, on a leg with its numbers; shape (3 node,)."""

    leg: Leg
    values: Values
    x: Floats
    v: Floats


class Slope(NamedTuple):
    """Derivatives of one component: by places and velocities, shape (3 node,), and numbers."""

    x: Floats
    v: Floats
    values: Values | None  # None where numbers do not enter


class Look(Protocol):
    """Something that is measured."""

    def at(self, view: View) -> Floats:
        """Return its components in SI units, shape (component,)."""
        ...

    def slopes(self, view: View) -> list[Slope]:
        """Return the derivatives of all components."""
        ...


class Places:
    """The places of nodes, or of one along a direction."""

    def __init__(self, nodes: Indices, along: Floats | None):
        self.nodes, self.along = nodes, along

    def at(self, view: View) -> Floats:
        """Return x, y and z of every node, or the part along the direction."""
        places = view.x.reshape(-1, 3)[self.nodes]
        return places.ravel() if self.along is None else places @ self.along

    def slopes(self, view: View) -> list[Slope]:
        """Return ones."""
        found, rest = [], np.zeros_like(view.v)
        axes = np.eye(3) if self.along is None else self.along[None]
        for node in self.nodes:
            for axis in axes:
                by = np.zeros_like(view.x)
                by[3 * node : 3 * node + 3] = axis
                found.append(Slope(by, rest, None))
        return found


class Mean:
    """The mean place of some nodes, as ``position``."""

    def __init__(self, subject: Subject):
        self.subject = subject

    def at(self, view: View) -> Floats:
        """Return x, y and z [m]."""
        return view.x.reshape(-1, 3)[_nodes(self.subject, view.leg)].mean(axis=0)

    def slopes(self, view: View) -> list[Slope]:
        """Return an equal share for every node."""
        nodes, rest = _nodes(self.subject, view.leg), np.zeros_like(view.v)
        found = []
        for axis in range(3):
            by = np.zeros_like(view.x)
            by[3 * nodes + axis] = 1.0 / len(nodes)
            found.append(Slope(by, rest, None))
        return found


class Support:
    """Minus the sum of the forces of springs on some nodes, as ``force``."""

    def __init__(self, subject: Subject, kernels: Kernels):
        self.subject, self.kernels = subject, kernels
        self._links: dict[int, tuple[Leg, Links]] = {}

    def at(self, view: View) -> Floats:
        """Return x, y and z [N]."""
        return -self._forces(view).reshape(-1, 3).sum(axis=0)

    def slopes(self, view: View) -> list[Slope]:
        """Return the derivatives, by what a force on these nodes depends on."""
        links, forces = self._of(view.leg), self._forces(view)
        nodes, found = np.flatnonzero(links.inverse), []
        for axis in range(3):
            weight, by_x, by_v = np.zeros((3, len(view.x)))
            weight[3 * nodes + axis] = -1.0
            by = Values(*(np.zeros_like(part) for part in view.values))
            self.kernels.pull_back(
                view.x, view.v, forces, weight, links, view.values, by_x, by_v, by
            )
            by.mass[:] = 0.0  # no mass is in a force
            found.append(Slope(by_x, by_v, by))
        return found

    def _forces(self, view: View) -> Floats:
        forces = np.empty_like(view.x)
        self.kernels.acceleration(
            view.x, view.v, np.zeros(0), self._of(view.leg), view.values, forces
        )
        return forces

    def _of(self, leg: Leg) -> Links:
        """Return the springs that reach out of the nodes, each of which weighs 1 kg."""
        if id(leg) not in self._links:
            inside = np.zeros(len(leg.held), dtype=bool)
            inside[_nodes(self.subject, leg)] = True
            ends = leg.network.ends
            alive = np.flatnonzero(leg.alive_springs & (inside[ends].sum(axis=1) == 1))
            low, high = (np.ascontiguousarray(e) for e in ends[alive].astype(np.int64).T)
            law = leg.network.law[alive].astype(np.int64)
            steady = np.zeros(3 * len(inside))
            links = Links(
                low, high, alive, law, inside.astype(float), steady, 0.0, _NONE, _NONE
            )
            self._links[id(leg)] = leg, links
        return self._links[id(leg)][1]


class Between:
    """The distance of the mean places of two sets, as ``distance``."""

    def __init__(self, first: Subject, second: Subject):
        self.ends = Mean(first), Mean(second)

    def at(self, view: View) -> Floats:
        """Return the distance [m], shape (1,)."""
        return np.array([np.linalg.norm(self._way(view))])

    def slopes(self, view: View) -> list[Slope]:
        """Return the direction, shared among the nodes."""
        way = self._way(view)
        away = way / (np.linalg.norm(way) or 1.0)
        by = sum(
            sign * share * slope.x
            for sign, end in ((-1.0, self.ends[0]), (1.0, self.ends[1]))
            for share, slope in zip(away, end.slopes(view), strict=True)
        )
        return [Slope(np.asarray(by), np.zeros_like(view.v), None)]

    def _way(self, view: View) -> Floats:
        return self.ends[1].at(view) - self.ends[0].at(view)


class Length:
    """The sum of the lengths of intact springs, as ``length``."""

    def __init__(self, subject: Subject):
        self.subject = subject

    def at(self, view: View) -> Floats:
        """Return the length [m], shape (1,)."""
        return np.array([np.linalg.norm(self._reach(view)[1], axis=1).sum()])

    def slopes(self, view: View) -> list[Slope]:
        """Return the directions at both ends of every spring."""
        ends, reach = self._reach(view)
        length = np.linalg.norm(reach, axis=1)
        away = reach / np.where(length > 0.0, length, 1.0)[:, None]
        by = np.zeros((len(view.x) // 3, 3))
        np.add.at(by, ends[:, 0], -away)
        np.add.at(by, ends[:, 1], away)
        return [Slope(by.ravel(), np.zeros_like(view.v), None)]

    def _reach(self, view: View) -> tuple[Indices, Floats]:
        springs = self.subject.springs[view.leg.alive_springs[self.subject.springs]]
        ends, places = view.leg.network.ends[springs], view.x.reshape(-1, 3)
        return ends, places[ends[:, 1]] - places[ends[:, 0]]


class Along:
    """The part of a vector along a direction."""

    def __init__(self, look: Look, direction: Floats):
        self.look, self.direction = look, direction

    def at(self, view: View) -> Floats:
        """Return the part, shape (1,)."""
        return np.array([self.look.at(view) @ self.direction])

    def slopes(self, view: View) -> list[Slope]:
        """Return the same part of the derivatives."""
        return [_mixed(self.look.slopes(view), self.direction)]


class Size:
    """The length of a vector."""

    def __init__(self, look: Look):
        self.look = look

    def at(self, view: View) -> Floats:
        """Return the length, shape (1,)."""
        return np.array([np.linalg.norm(self.look.at(view))])

    def slopes(self, view: View) -> list[Slope]:
        """Return the part of the derivatives along the vector."""
        vector = self.look.at(view)
        return [_mixed(self.look.slopes(view), vector / (np.linalg.norm(vector) or 1.0))]


def look_of(fit: Fit, nodes: Indices | None, kernels: Kernels) -> Look | None:
    """Return what a fit looks at; None for a measure without derivatives.

    Args:
        nodes: Of positions, those that were measured.
    """
    if fit.measure is None:
        assert nodes is not None
        return Places(nodes, fit.along)
    form, first = fit.measure.form.partition("(")[0], fit.subjects[0]
    match form:
        case "position":
            mean = Mean(first)
            return mean if fit.along is None else Along(mean, fit.along)
        case "force":
            support = Support(first, kernels)
            if fit.along is not None:
                return Along(support, fit.along)
            return support if len(fit.columns) == 3 else Size(support)
        case "distance":
            return Between(first, fit.subjects[1])
        case "length":
            return Length(first)
        case _:
            return None


def pull(look: Look, view: View, weights: Floats) -> Slope:
    """Return the derivatives of Σ weights · components."""
    if isinstance(look, Places):
        by = np.zeros((len(view.x) // 3, 3))
        sense = weights.reshape(-1, 3) if look.along is None else np.outer(weights, look.along)
        np.add.at(by, look.nodes, sense)
        return Slope(by.ravel(), np.zeros_like(view.v), None)
    return _mixed(look.slopes(view), weights)


def push(look: Look, view: View, tx: Floats, tv: Floats) -> tuple[Floats, list[Values | None]]:
    """Return how components change with the state, and their derivatives by numbers.

    Args:
        tx, tv: Changes of places and velocities, shape (3 node, change).

    Returns:
        Shape (component, change), and for each component what numbers add.
    """
    if isinstance(look, Places):
        moved = tx.reshape(-1, 3, tx.shape[1])[look.nodes]
        if look.along is not None:
            moved = np.einsum("k,nkm->nm", look.along, moved)
        return moved.reshape(-1, tx.shape[1]).copy(), []
    slopes = look.slopes(view)
    moved = np.array([slope.x @ tx + slope.v @ tv for slope in slopes])
    return moved, [slope.values for slope in slopes]


def _nodes(subject: Subject, leg: Leg) -> Indices:
    """Return the nodes of a subject: for a tool, those that it holds on a leg."""
    if subject.nodes is not None:
        return subject.nodes
    held = leg.holders.get(subject.name, _NONE)
    if not len(held):
        raise Unseen(leg.start, subject.name)
    return held


def _mixed(slopes: list[Slope], weights: Floats) -> Slope:
    x = sum(w * slope.x for w, slope in zip(weights, slopes, strict=True))
    v = sum(w * slope.v for w, slope in zip(weights, slopes, strict=True))
    values = None
    if slopes[0].values is not None:
        values = Values(
            *(
                sum(w * part for w, part in zip(weights, parts, strict=True))
                for parts in zip(*(slope.values for slope in slopes), strict=True)  # type: ignore[arg-type]
            )
        )
    return Slope(np.asarray(x), np.asarray(v), values)
