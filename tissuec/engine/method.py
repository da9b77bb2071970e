"""Requests to the engine and its answers."""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from msgspec import Struct, field

from tissuec.model.network import Floats, Indices
from tissuec.script.procedures import Choices

#: Given the time [s], returns whether to return between two steps.
Pause = Callable[[float], bool]
#: Takes a time [s] and the positions of all nodes [m], shape (node, 3).
Follow = Callable[[float, Floats], float]
Kind = Literal["reached", "paused", "viewed", "ruptured", "triggered", "diverged", "stuck"]


class Method(Struct, frozen=True):
    """The method of a run.

    Attributes:
        name: "automatic" or a member of ``INTEGRATORS``.
        tolerance: Error of positions relative to the largest displacement of the run so far;
            None means 1e-4 unless a step is given.
        step: Largest size of uniform steps [s]; None lets the tolerance rule.
        duration: Of the whole run [s].
        ledger: Whether work and dissipation are integrated.
        watch_strength: Whether springs may rupture.
        choices: What is chosen of a published procedure; None for what it does by default.
        threads: Maximum number of threads for a large net; results do not depend on it.
        spacing: Time that may pass between two states at which conditions are tested, where
            steps are shorter [s].
    """

    name: str
    tolerance: float | None
    step: float | None
    duration: float
    ledger: bool = False
    watch_strength: bool = False
    choices: Choices | None = None
    threads: int = 1
    spacing: float = 0.0


class Samples(NamedTuple):
    """A batch for the recorder, nodes in the order of the network."""

    time: Floats  # [s], shape (sample,)
    position: Floats  # [m], shape (sample, node, 3)
    velocity: Floats  # [m/s], shape (sample, node, 3)
    work: Floats  # done on the free nodes and springs since the start [J], shape (sample,)
    dissipated: Floats  # by dashpots and drag since the start [J], shape (sample,)
    error: Floats  # of positions, as estimated from step to step [m], shape (sample,)
    reach: Floats  # largest displacement of a node in the steps before [m], shape (sample,)


def unfollowed(time: float, position: Floats) -> float:
    """Ignore a state at a time [s], and all others: return infinity.

    Args:
        time: [s].
        position: Of all nodes [m], shape (node, 3).
    """
    return np.inf


def _no_springs() -> Indices:
    return np.zeros(0, dtype=np.int64)


class Interruption(Struct, frozen=True, eq=False):
    """Why the engine returned, at ``time`` [s], which is that of the state.

    Attributes:
        kind: "reached" the requested end; "paused" at the request of the caller; a step is
            made that holds the time to be "viewed"; springs
            "ruptured" at this very time; a watched condition became true ("triggered"); the
            motion "diverged", and the state keeps the last good state; the engine is
            "stuck", since steps became too small.
        springs: Those that ruptured, ascending.
        spring: The culprit of a failure, if one can be named.
        node: The same for nodes.
        message: What failed, as a sentence without the culprit.
    """

    kind: Kind
    time: float
    springs: Indices = field(default_factory=_no_springs)
    spring: int | None = None
    node: int | None = None
    message: str = ""


class MethodChange(Struct, frozen=True):
    """An integrator takes over, at ``time`` [s]."""

    time: float
    method: str
    reason: str


class Statistics(Struct, frozen=True):
    """Cost of a run so far.

    Attributes:
        method, reason: The integrator and why it was chosen.
        backend: Of the loop over steps; of statics, how equilibria are found.
        accepted, rejected: Steps.
        evaluations: Of the forces.
        factorisations, solutions: Of the matrix of implicit steps.
        stalls: Steps of ``propagation`` at its floor although forces rose.
        smallest, largest: Step [s]; 0 before the first.
        changes: The integrators in turn, the first one included.
        threads: Number of threads that stepped it.
        cost: Predicted processor time of the steps [s], from counts of operations.
    """

    method: str
    reason: str
    backend: str
    accepted: int
    rejected: int
    evaluations: int
    factorisations: int
    solutions: int
    stalls: int
    smallest: float
    largest: float
    changes: tuple[MethodChange, ...] = ()
    threads: int = 1
    cost: float = 0.0

    @classmethod
    def of_nothing(cls) -> "Statistics":
        """Return those of a run that was interrupted before its first step."""
        return cls("no integrator", "no step was made", "none", 0, 0, 0, 0, 0, 0, 0.0, 0.0)
