"""Views of a state for observables, and their derivatives."""

from collections.abc import Iterable
from typing import NamedTuple, Protocol

import numpy as np

from tissuec.core.units import TIME, show
from tissuec.kernels.derivative_records import Values
from tissuec.learn.derivatives.event_schedule import Leg
from tissuec.learn.derivatives.motion import Diverged
from tissuec.model.network import Floats, Indices
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
    """A state, on a leg with its numbers; shape (3 node,)."""

    leg: Leg
    values: Values
    x: Floats
    v: Floats
    time: float = 0.0  # [s]


class ObservableDerivative(NamedTuple):
    """Derivatives of one component: by places and velocities, shape (3 node,), and numbers."""

    x: Floats
    v: Floats
    values: Values | None  # None where numbers do not enter


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
    values: Values | None = None
    for weight, slope in pairs:
        x += weight * slope.x
        v += weight * slope.v
        if slope.values is not None:
            parts = [weight * part for part in slope.values]
            if values is not None:
                parts = [a + b for a, b in zip(values, parts, strict=True)]
            values = Values(*parts)
    return ObservableDerivative(x, v, values)
