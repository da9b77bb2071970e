"""Observables of a motion, as smooth functions of views of states, with derivatives."""

from collections.abc import Iterable
from typing import NamedTuple, Protocol

import numpy as np
from scipy import sparse

from tissuec.compiled.record_tables import tabulated
from tissuec.core.units import TIME, show
from tissuec.kernels.derivative_records import Forces, Links, NodeState
from tissuec.learn.derivatives.event_schedule import ActingForces, Leg, acting_fields
from tissuec.learn.derivatives.matrices import acceleration, pull_back
from tissuec.learn.derivatives.motion import Diverged
from tissuec.model.network import Floats, Indices
from tissuec.script.fit_problem import Fit
from tissuec.script.measures import Subject

_NONE: Indices = np.zeros(0, dtype=np.int64)


class Unseen(Diverged):
    """A tool that holds nothing is observed; the arguments are the time [s] and its name."""

    def __str__(self) -> str:
        since = show(float(self.args[0]), TIME)
        return (
            f"{self.args[1]} does not hold anything after {since}, but the data has "
            "later values of it"
        )


class StateView(NamedTuple):
    """A state, shape (3 node,), on a leg, and all numbers, shape (number,)."""

    leg: Leg
    vector: Floats
    x: Floats
    v: Floats
    time: float = 0.0  # [s]


class ObservableDerivative(NamedTuple):
    """Derivatives of one component: by places and velocities, shape (3 node,), and numbers."""

    x: Floats
    v: Floats
    numbers: Floats | None  # shape (number,); None where they do not enter


class Observable(Protocol):
    """A measured quantity."""

    def at(self, view: StateView) -> Floats:
        """Return its components in SI units, shape (component,)."""
        ...

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the derivatives of all components."""
        ...


def nodes_of(subject: Subject, leg: Leg) -> Indices:
    """Return the nodes of a subject, shape (n,); for a tool, those that it holds on a leg.

    Raises:
        Unseen: The tool holds no node.
    """
    if subject.nodes is not None:
        return subject.nodes
    held = leg.holders.get(subject.name, _NONE)
    if not len(held):
        raise Unseen(leg.start, subject.name)
    return held


def mixed(slopes: Iterable[ObservableDerivative], weights: Floats) -> ObservableDerivative:
    """Return the derivatives of Σ weights · components from those of each component.

    Args:
        slopes: Derivatives of each component.
        weights: Dimensionless, shape (component,).
    """
    pairs = list(zip(weights.tolist(), slopes, strict=True))
    x, v = np.zeros_like(pairs[0][1].x), np.zeros_like(pairs[0][1].v)
    numbers: Floats | None = None
    for weight, slope in pairs:
        x += weight * slope.x
        v += weight * slope.v
        if slope.numbers is not None:
            own = weight * slope.numbers
            numbers = own if numbers is None else numbers + own
    return ObservableDerivative(x, v, numbers)


class Places:
    """The places of nodes, or of one along a direction."""

    def __init__(self, nodes: Indices, along: Floats | None):
        self.nodes, self.along = nodes, along

    def at(self, view: StateView) -> Floats:
        """Return x, y and z of every node, or the part along the direction."""
        places = view.x.reshape(-1, 3)[self.nodes]
        return places.ravel() if self.along is None else np.asarray(places @ self.along)

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return ones."""
        found: list[ObservableDerivative] = []
        rest = np.zeros_like(view.v)
        axes = np.eye(3) if self.along is None else self.along[None]
        for node in self.nodes:
            for axis in axes:
                by = np.zeros_like(view.x)
                by[3 * node : 3 * node + 3] = axis
                found.append(ObservableDerivative(by, rest, None))
        return found


class Mean:
    """The mean place of some nodes, as ``position``."""

    def __init__(self, subject: Subject):
        self.subject = subject

    def at(self, view: StateView) -> Floats:
        """Return x, y and z [m]."""
        return view.x.reshape(-1, 3)[nodes_of(self.subject, view.leg)].mean(axis=0)

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return an equal share for every node."""
        nodes, rest = nodes_of(self.subject, view.leg), np.zeros_like(view.v)
        found: list[ObservableDerivative] = []
        for axis in range(3):
            by = np.zeros_like(view.x)
            by[3 * nodes + axis] = 1.0 / len(nodes)
            found.append(ObservableDerivative(by, rest, None))
        return found


class DistanceObservable:
    """The distance of the mean places of two sets, as ``distance``."""

    def __init__(self, first: Subject, second: Subject):
        self.ends = Mean(first), Mean(second)

    def at(self, view: StateView) -> Floats:
        """Return the distance [m], shape (1,)."""
        return np.array([float(np.linalg.norm(self._way(view)))])

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the direction, shared among the nodes."""
        way = self._way(view)
        away = way / (np.linalg.norm(way) or 1.0)
        first, second = (mixed(end.slopes(view), away) for end in self.ends)
        return [ObservableDerivative(second.x - first.x, np.zeros_like(view.v), None)]

    def _way(self, view: StateView) -> Floats:
        first, second = self.ends
        return second.at(view) - first.at(view)


class LengthObservable:
    """The sum of the lengths of intact springs, as ``length``."""

    def __init__(self, subject: Subject):
        self.subject = subject

    def at(self, view: StateView) -> Floats:
        """Return the length [m], shape (1,)."""
        return np.array([np.linalg.norm(self._reach(view)[1], axis=1).sum()])

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the directions at both ends of every spring."""
        ends, reach = self._reach(view)
        length = np.linalg.norm(reach, axis=1)
        away = reach / np.where(length > 0.0, length, 1.0)[:, None]
        by = np.zeros((len(view.x) // 3, 3))
        np.add.at(by, ends[:, 0], -away)
        np.add.at(by, ends[:, 1], away)
        return [ObservableDerivative(by.ravel(), np.zeros_like(view.v), None)]

    def _reach(self, view: StateView) -> tuple[Indices, Floats]:
        lines = self.subject.lines[view.leg.is_alive[self.subject.lines]]
        ends = view.leg.network.line_ends[lines].astype(np.int64)
        places = view.x.reshape(-1, 3)
        return ends, places[ends[:, 1]] - places[ends[:, 0]]


class Along:
    """The part of a vector along a direction."""

    def __init__(self, look: Observable, direction: Floats):
        self.look, self.direction = look, direction

    def at(self, view: StateView) -> Floats:
        """Return the part, shape (1,)."""
        return np.array([self.look.at(view) @ self.direction])

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the same part of the derivatives."""
        return [mixed(self.look.slopes(view), self.direction)]


class Size:
    """The length of a vector."""

    def __init__(self, look: Observable):
        self.look = look

    def at(self, view: StateView) -> Floats:
        """Return the length, shape (1,)."""
        return np.array([float(np.linalg.norm(self.look.at(view)))])

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the part of the derivatives along the vector."""
        vector = self.look.at(view)
        return [mixed(self.look.slopes(view), vector / (np.linalg.norm(vector) or 1.0))]


def look_of(fit: Fit, nodes: Indices | None) -> Observable | None:
    """Return the observable of a fit; None for a measure without derivatives.

    Args:
        fit: What is compared with data.
        nodes: Of positions, those that were measured, shape (node,).
    """
    if fit.measure is None:
        assert nodes is not None
        return Places(nodes, fit.along)
    form, first = fit.measure.form.partition("(")[0], fit.subjects[0]
    if any(one.weights is not None for one in fit.subjects):
        return None
    match form:
        case "position":
            mean = Mean(first)
            return mean if fit.along is None else Along(mean, fit.along)
        case "force":
            support = Support(first)
            if fit.along is not None:
                return Along(support, fit.along)
            return support if len(fit.columns) == 3 else Size(support)
        case "distance":
            return DistanceObservable(first, fit.subjects[1])
        case "length":
            return LengthObservable(first)
        case _:
            return None


def pull(look: Observable, view: StateView, weights: Floats) -> ObservableDerivative:
    """Return the derivatives of Σ weights · components."""
    if isinstance(look, Places):
        by = np.zeros((len(view.x) // 3, 3))
        sense = weights.reshape(-1, 3) if look.along is None else np.outer(weights, look.along)
        np.add.at(by, look.nodes, sense)
        return ObservableDerivative(by.ravel(), np.zeros_like(view.v), None)
    return mixed(look.slopes(view), weights)


def push(
    look: Observable,
    view: StateView,
    tx: Floats,
    tv: Floats,
    change: sparse.csr_matrix,
) -> Floats:
    """Return the derivatives of components by parameters, shape (component, change).

    Args:
        view: State and numbers.
        tx, tv: Changes of positions [m] and velocities [m/s], shape (3 node, change).
        change: Of all numbers, shape (number, change).
    """
    if isinstance(look, Places):
        moved = tx.reshape(-1, 3, tx.shape[1])[look.nodes]
        if look.along is not None:
            moved = np.einsum("k,nkm->nm", look.along, moved)
        return moved.reshape(-1, tx.shape[1]).copy()
    slopes = look.slopes(view)
    moved = np.array([slope.x @ tx + slope.v @ tv for slope in slopes])
    for row, slope in enumerate(slopes):
        if slope.numbers is not None:
            moved[row] += change.T @ slope.numbers
    return moved


class Support:
    """Minus the sum of the inner forces on some nodes, as ``force``."""

    def __init__(self, subject: Subject):
        self.subject = subject
        # By the identity of the leg, which is kept so that no other gets its number.
        self._known: dict[int, tuple[Leg, Links, ActingForces]] = {}

    def at(self, view: StateView) -> Floats:
        """Return x, y and z [N]."""
        return -self._pulled(view)[1].a.reshape(-1, 3).sum(axis=0)

    def slopes(self, view: StateView) -> list[ObservableDerivative]:
        """Return the derivatives, by what a force on these nodes depends on."""
        forces, at = self._pulled(view)
        leg, nodes = view.leg, np.flatnonzero(forces.links.inverse)
        _, acting = self._of(leg)
        found: list[ObservableDerivative] = []
        for axis in range(3):
            due = NodeState(*np.zeros((3, len(view.x))))
            due.a[3 * nodes + axis] = -1.0
            by = leg.nothing._replace(numbers=np.zeros(len(acting.numbers)))
            pull_back(forces, view.time, at, due, by)
            by.mass[:] = 0.0  # no mass is in a force
            by.drag[:] = 0.0  # nor is what acts from outside
            found.append(ObservableDerivative(due.x, due.v, leg.past(by, acting)))
        return found

    def _pulled(self, view: StateView) -> tuple[Forces, NodeState]:
        """Return all forces, and the state with forces in place of accelerations."""
        links, acting = self._of(view.leg)
        springs, fields = acting.with_numbers(view.leg.present(view.vector, acting))
        every = acting_fields(view.leg, [*springs, *fields.values()], view.x)
        forces = tabulated(Forces(links, every))
        at = NodeState(view.x, view.v, np.empty_like(view.x))
        acceleration(forces, view.time, np.zeros(0), at)
        return forces, at

    def _of(self, leg: Leg) -> tuple[Links, ActingForces]:
        """Return the nodes, each of 1 kg, and the springs that reach out of them."""
        if id(leg) not in self._known:
            inside = np.zeros(len(leg.held), dtype=bool)
            inside[nodes_of(self.subject, leg)] = True
            reach_out = inside[leg.network.springs.ends].sum(axis=1) == 1
            steady, drag = np.zeros(3 * len(inside)), np.zeros(len(inside))
            links = Links(inside.astype(float), steady, drag, _NONE, _NONE)
            self._known[id(leg)] = leg, links, leg.acting.some(reach_out, leg.order)
        return self._known[id(leg)][1:]
