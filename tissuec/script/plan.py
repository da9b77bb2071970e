"""The plan of a run: method, script, outputs and expectations."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import Dimension
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.measures import Measure, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.procedures import Choices
from tissuec.script.verbs import Action
from tissuec.script.verbs.settle import Settle, StaticInterval

if TYPE_CHECKING:  # annotations only: scenes without them load faster
    from tissuec.geometry.surfaces import Smoothing

AUTOMATIC = "automatic"
"""The integrator is chosen by facts measured of the scene."""

RELAXATION = "relaxation"
"""The published procedure without inertia: the net is relaxed again and again."""
EQUILIBRIUM = "equilibrium"
"""Statics: the net is in equilibrium all the time, by Newton's method."""
STATIC = (EQUILIBRIUM, RELAXATION)
LOAD_STEPS = 20  # of a run by ``EQUILIBRIUM`` that states no step, at least
DEFAULT_TOLERANCE = 1e-4  # of errors of positions, relative to the largest displacement


class Simulation(Struct, frozen=True):
    """The ``simulate`` block.

    Attributes:
        duration: [s].
        integrator: Name of one, ``AUTOMATIC``, or a member of ``STATIC``.
        tolerance: Bound of the error of positions relative to the largest displacement so far.
        step: Fixed step [s]; None where the tolerance rules.
        span: The block.
        choices: What is chosen of a published procedure; None of other methods.
    """

    duration: float
    integrator: str
    tolerance: float | None
    step: float | None
    span: Span
    choices: Choices | None = None

    @property
    def is_static(self) -> bool:
        """Return whether inertia is neglected: the net is in equilibrium all the time."""
        return self.integrator in STATIC


class ScheduledAction(Struct, frozen=True):
    """An action at a time; events at one time are carried out in this order."""

    time: float  # [s], absolute, or after the trigger
    action: Action


class Condition(Protocol):
    """A condition, which is true at some snapshots and false at others."""

    def __call__(self, snapshot: Snapshot) -> bool:
        """Return whether it holds at a snapshot."""
        ...

    def holds(self, snapshots: Snapshot) -> NDArray[np.bool_]:
        """Return when it holds, shape (…) as a batch of snapshots."""
        ...


class ComparedCondition(Protocol):
    """A condition that tells by how much it holds.

    Attributes:
        comparisons: What it compares, each with the ``dimension`` of both sides.
        needs_ledger: Whether it measures what only a run with an energy ledger knows.
    """

    @property
    def comparisons(self) -> Sequence["ComparedPair"]: ...

    @property
    def needs_ledger(self) -> bool: ...

    def weighed(self, snapshots: Snapshot) -> tuple[NDArray[np.bool_], Floats]:
        """Return when it holds, and the gaps of its comparisons in SI units.

        The shapes are (…) as a batch of snapshots, and (…, comparison).
        """
        ...

    def possible(
        self, gaps: Floats, errors: Floats
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return when it may hold, and when it may fail, shape (row,) each.

        Args:
            gaps: In SI units, shape (row, comparison).
            errors: Of each gap, in the same units, shape (comparison,).
        """
        ...


class ComparedPair(NamedTuple):
    """Two numbers that a condition compares, or one with zero.

    Attributes:
        sign: Such as "<".
        gap: The left number minus the right one, in SI units, shape (…).
        dimension: Of both.
    """

    sign: str
    gap: Floats
    dimension: Dimension


class Trigger(Struct, frozen=True, eq=False):
    """``when condition: …``: fires once, at the first time at which the condition holds."""

    condition: Condition
    events: tuple[ScheduledAction, ...]
    span: Span


class LogRequest(Struct, frozen=True, eq=False):
    """One measure at a rate: ``force(forceps A) every 1 ms``."""

    name: str  # "force of forceps A"
    measure: type[Measure]
    subjects: tuple[Subject, ...]
    every: float  # [s]
    span: Span

    @property
    def needs_ledger(self) -> bool:
        """Return whether it needs the energy ledger of a run."""
        return getattr(self.measure, "needs_ledger", False)


class SurfaceOutput(Struct, frozen=True, eq=False):
    """A smooth surface of a body at a rate: ``surface of oviduct every 40 ms``."""

    body: str
    kind: str  # such as "loop subdivision"
    smoothing: "Smoothing"
    every: float  # [s]
    span: Span


class Expectation(Struct, frozen=True, eq=False):
    """``expect condition at/from/until/over …``, evaluated during the run.

    Attributes:
        condition: Called with a snapshot at each time of judgement, whose ``pinned`` holds
            those of earlier times.
        start, stop: The interval of judgement [s]; equal for ``at``.
        pinned: Times that the condition names [s].
        span: The clause.
        compared: The condition, if it tells by how much it holds.
    """

    condition: Condition
    describe: Callable[[Snapshot], str]  # what was measured, such as "gap(oviduct) = 8.1 mm"
    start: float
    stop: float
    pinned: tuple[float, ...]
    span: Span
    compared: ComparedCondition | None = None


class Output(Struct, frozen=True, eq=False):
    """The ``output`` block.

    Attributes:
        frames: Nodes of the trajectory, shape (node,); empty without a trajectory.
        every: Time between frames [s]; infinite without a trajectory.
        single: Whether frames are stored in single precision.
        logs: Measures at their own rates.
        energy: Time between rows of the energy table [s]; infinite without one.
        surfaces: Smooth surfaces of bodies, at their own rates.
        blocks: Whether a blocks file is written beside the result.
        compress: Whether frames and surfaces are compressed.
        fields: Names of fields that frames contain besides those that all do.
    """

    frames: Indices
    every: float
    single: bool
    logs: tuple[LogRequest, ...]
    energy: float
    surfaces: tuple[SurfaceOutput, ...] = ()
    blocks: bool = False
    compress: bool = False
    fields: tuple[str, ...] = ()


class Plan(Struct, frozen=True, eq=False):
    """All data of a run except the network; immutable, so that it can be run many times."""

    simulation: Simulation
    gravity: Floats  # [m/s²], shape (3,)
    drag: float  # [N s/m] per node
    events: tuple[ScheduledAction, ...]  # ascending in time
    triggers: tuple[Trigger, ...]
    output: Output
    expectations: tuple[Expectation, ...]
    needs_ledger: bool  # whether work and dissipation must be integrated
    breakable: bool  # whether any spring can rupture

    @property
    def every_event(self) -> tuple[ScheduledAction, ...]:
        """The actions at set times, and then those that follow conditions."""
        return *self.events, *(event for trigger in self.triggers for event in trigger.events)

    @property
    def balances(self) -> bool:
        """Return whether the run finds equilibria, at a time, for an interval or throughout."""
        return self.simulation.is_static or any(
            isinstance(event.action, Settle | StaticInterval) for event in self.every_event
        )

    @property
    def static_intervals(self) -> list[StaticInterval]:
        """Return the orders that make the scene static for an interval."""
        every = (event.action for event in self.every_event)
        return [action for action in every if isinstance(action, StaticInterval)]

    def start(self, network: Network) -> State:
        """Return the state at 0 s, before any event."""
        state = State.start(network, gravity=self.gravity, drag=self.drag)
        if any(body.interfaces for body in network.bodies):
            from tissuec.mechanics.interfaces import part_interfaces  # where there are any

            part_interfaces(state)
        return state


def without_outputs(plan: Plan) -> Plan:
    """Return a plan of the same motion, of which nothing is written or judged.

    Work and dissipation change no position, and no ``when`` may use them.
    """
    output = Output(np.zeros(0, dtype=np.int64), np.inf, False, (), np.inf)
    return replace(plan, output=output, expectations=(), needs_ledger=False)


def times_every(step: float, duration: float) -> NDArray[np.float64]:
    """Return 0, step, 2 step, … up to the duration [s], shape (time,).

    The duration is included where it is a multiple of the step. Multiples are rounded products,
    not sums, so that 1000 times 1 ms is exactly 1 s.
    """
    count = int(np.floor(duration / step * (1 + 1e-12)))
    return np.minimum(np.arange(count + 1) * step, duration)
