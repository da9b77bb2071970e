"""Runs to compare with: with finer steps and another method, nothing of which is written.

A fault of a method, such as a force that its steps lose, shows in no finer step of the same
method. So an explicit method is compared with one of another order or with an implicit one, and
an implicit method with an explicit one.
"""

from collections.abc import Callable, Collection
from math import inf

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.engine.execution.courses import Courses, counts, rows_of
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import Samples, Statistics
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.script.measures.snapshot import EnergyBalance
from tissuec.script.plan import EQUILIBRIUM, STATIC, Plan, Simulation, without_outputs
from tissuec.script.verbs import LoggedEvent
from tissuec.script.verbs.end import without_end

FEW = 6  # times: fewer do not tell how the cost of a run is spread over it
TOLD = 0.25  # of what a companion may cost: then what it will cost is told
HOPELESS = 1.5  # times what it may cost: more is not begun
USUAL, FINEST = 1e-4, 1e-13  # tolerance, where none is written and at the least


class Progressed:
    """How much of its cost a run has spent until a time, to predict what another will cost."""

    def __init__(self) -> None:
        self._times, self._costs = [0.0], [0.0]

    def note(self, time: float, cost: float) -> None:
        """Note what a run has cost until a time [s]."""
        if time > self._times[-1]:
            self._times.append(time)
            self._costs.append(cost)

    def part(self, time: float) -> float:
        """Return the part of its cost that a run had spent at a time [s]; 1 if unknown."""
        if len(self._times) < FEW or not self._costs[-1]:
            return 1.0
        return float(np.interp(time, self._times, self._costs)) / self._costs[-1]


class Allowance:
    """What companion runs may cost, by counts of operations and not by a clock.

    Args:
        most: Returns the predicted cost at which they end [s].
        progress: Of the run; a companion that falls far behind it ends early.

    Attributes:
        spent: What they have cost so far [s].
        is_hopeless: Whether one ended early.
    """

    def __init__(self, most: Callable[[], float], progress: Progressed | None = None):
        self._most, self._progress = most, progress or Progressed()
        self.spent, self.is_hopeless = 0.0, False

    def watch(self, time: float, ran: Statistics) -> None:
        """Measure what a run has cost until a time [s]."""
        self.spent, most = ran.cost, self._most()
        if self.spent > TOLD * most:
            part = self._progress.part(time)
            self.is_hopeless |= self.spent > HOPELESS * most * part

    @property
    def is_spent(self) -> bool:
        """Return whether the run is to end."""
        return self.is_hopeless or self.spent > self._most()


def finer(plan: Plan, factor: float, method: str = "") -> Plan:
    """Return a plan with finer steps and without outputs of its own.

    Args:
        factor: Factor that its tolerance is divided by; a fixed step is divided by half of it,
            and grows where that is below 1.
        method: Another one than that of the plan, if any.
    """
    simulation = replace(plan.simulation, integrator=method or plan.simulation.integrator)
    if simulation.step is None:
        tolerance = max((simulation.tolerance or USUAL) / factor, FINEST)
        simulation = replace(simulation, tolerance=tolerance)
    else:
        simulation = replace(simulation, step=2.0 * simulation.step / factor)
    return replace(without_outputs(without_end(plan)), simulation=simulation)


def stepped(
    network: Network,
    plan: Plan,
    times: Floats,
    factor: float,
    *,
    method: str = "",
    rows: Floats | None = None,
    courses: Courses | None = None,
    table: Floats | None = None,
    spacing: float = 0.0,
    every: int = 1,
    interrupt: Callable[[], bool] | None = None,
    allowance: Allowance | None = None,
    threads: int = 1,
) -> Floats:
    """Return positions at times with smaller steps [m], shape (time, node, 3).

    They are NaN at times that the run did not reach.

    Args:
        plan: The plan of the run.
        times: Times of interest [s], ascending, shape (time,).
        factor: See ``finer``.
        method: See ``finer``; with one, what is near is searched for otherwise, too.
        rows: Array to be filled; a new one by default.
        courses: What else is compared.
        table: Of these courses, to be filled.
        spacing: See ``Method`` [s].
        every: See ``Courses.stops``.
        interrupt: Returns whether to stop.
        allowance: What it may cost.
        threads: See ``Method``.
    """
    from tissuec.engine.execution.run import run

    rows = np.full((len(times), network.node_count, 3), np.nan) if rows is None else rows
    plan = finer(plan, factor, method)
    contact = network.contact
    if method and contact is not None:
        network = network.with_blocks(replace(contact, exhaustive=True).block)
    silent = _Silent(network, plan, times, rows, courses, table)
    silent.spacing = spacing
    silent.times = times if courses is None else courses.stops(every)
    may_cost = allowance or Allowance(lambda: inf)
    run(
        network, plan, silent, watch=may_cost.watch, threads=threads,
        interrupt=lambda: may_cost.is_spent or (interrupt is not None and interrupt()),
    )  # fmt: skip
    return rows


class _Silent(Recorder):
    """A recorder that keeps positions and courses at times, and writes nothing."""

    takes_notes = False

    def __init__(
        self,
        network: Network,
        plan: Plan,
        times: Floats,
        rows: Floats,
        courses: Courses | None,
        table: Floats | None,
    ):
        super().__init__(network, plan, MemoryRecording())
        self._asked, self._kept, self._events = times, rows, 0
        self._courses, self._table = courses, table

    def enter(self, state: State, ruptured: NDArray[np.bool_], ledger: EnergyBalance) -> None:
        super().enter(state, ruptured, ledger)
        kept = self._state
        if kept is not None and kept.contact is not None:
            # What is measured need not search everywhere: positions tell what a search missed.
            kept.put(replace(kept.contact, exhaustive=False).block)

    def happened(self, time: float, logged_event: LoggedEvent) -> None:
        self._events += counts(logged_event)

    def record(self, samples: Samples) -> None:
        rows, due = rows_of(self._asked, samples.time)
        self._kept[rows] = samples.position[due]
        if self._courses is None or self._table is None or self._state is None:
            return
        snapshot = self._snapshot(samples, self._state)
        for number, time in enumerate(samples.time.tolist()):
            if (asked := self._courses.pinned.get(time)) is not None:
                then = snapshot.pick(np.array([number])).pick(0)  # a copy
                self.memory.pinned[asked] = replace(then, pinned={})
        self._table[rows, 0] = self._events
        self._courses.sample(snapshot, rows, self._table)


def largest(vectors: Floats) -> Floats:
    """Return the length of the longest vector of each row, in their unit, shape (row,).

    Args:
        vectors: In any unit, shape (row, node, 3).
    """
    return np.sqrt(np.einsum("rnk,rnk->rn", vectors, vectors).max(axis=1, initial=0.0))


IMPLICIT = "implicit"
COARSE = 1e-6  # tolerance down to which steps of order 2 are not too many
#: How many times the predicted cost of the run its companion may have, and what it may always
#: cost [s]. That is less than what starting a process takes.
MOST, LEAST = 4.0, 0.1


def is_path_simple(network: Network, plan: Plan) -> bool:
    """Return whether a run consists of equilibria that hardly depend on the way to them.

    So it is by statics without contact and without anything that remembers how it was deformed,
    but where the net snaps.
    """
    return (
        plan.simulation.integrator == EQUILIBRIUM
        and network.contact is None
        and not network.internal
        and not plan.breakable
    )


def kind_of(method: str) -> str:
    """Return the kind of a method: methods of one kind share code."""
    if method in STATIC:
        return method
    return IMPLICIT if INTEGRATORS[method].implicit else method


def is_another(method: str, used: Collection[str]) -> bool:
    """Return whether a method, if there is one, is of another kind than those of a run."""
    return method != "" and kind_of(method) not in map(kind_of, used)


def counterpart(ran: Statistics, network: Network, plan: Plan) -> str:
    """Return a method of another kind than all that stepped a run.

    Args:
        ran: What the run did.
        network: Of the run.
        plan: Likewise.

    Returns:
        A member of ``INTEGRATORS``; "" if there is none, and where the steps of the run are
        fixed: these promise nothing.
    """
    if plan.simulation.step is not None:
        return ""
    used = {change.method for change in ran.changes}
    longest = _longest(ran, plan)
    candidates = _candidates(longest, network, plan.simulation) if longest else ()
    return next((name for name in candidates if is_another(name, used)), "")


def _longest(ran: Statistics, plan: Plan) -> str:
    """Return the method that stepped the largest part of a run."""
    times = [change.time for change in ran.changes] + [plan.simulation.duration]
    share: dict[str, float] = {}
    for change, lasted in zip(ran.changes, np.diff(times), strict=True):
        if change.method not in STATIC:
            share[change.method] = share.get(change.method, 0.0) + float(lasted)
    return max(share, key=lambda name: share[name], default="")


def _candidates(method: str, network: Network, simulation: Simulation) -> tuple[str, ...]:
    """Return the methods that one may be compared with, the cheapest first."""
    others = "dop853", "rkn4", "velocity verlet", "rkc2"
    if INTEGRATORS[method].implicit:
        is_coarse = (simulation.tolerance or 1.0) >= COARSE
        return ("rkc2", *others) if is_coarse and _is_overdamped(network) else others
    if method == "rkc2":
        # For elements, other explicit methods need the short steps that this one avoids.
        return ("esdirk43",) if network.elements else ("esdirk43", *others)
    return ("rkn4", *others) if method == "dop853" else others


def _is_overdamped(network: Network) -> bool:
    """Return whether dashpots and not springs set the fastest rate, at the worst node.

    Elements with viscosity are assumed to be overdamped: the smallest ones usually are.
    """
    if any(each.viscosity.any() for each in network.elements):
        return True
    stiff, viscous = (
        np.bincount(network.springs.ends.ravel(), np.repeat(of, 2), network.node_count)
        for of in (network.springs.stiffness, network.springs.damping)
    )
    return bool((viscous**2 > 4.0 * stiff * network.mass).any())


def foreseen(method: str, ran: Statistics, tolerance: float, finer: float) -> float:
    """Return how many times as long as a run a method takes, by orders; 1 if unknown.

    The number of steps grows as the tolerance to the power of minus one over the order. Where
    stability limits the steps, it grows less.

    Args:
        method: Of the companion.
        ran: What the run did.
        tolerance: Of the run.
        finer: How many times as fine the tolerance of the companion is.
    """
    one, two = INTEGRATORS[ran.method], INTEGRATORS[method]
    if one.implicit or two.implicit or one.stabilised or two.stabilised:
        return 1.0
    theirs = two.evaluations * (tolerance / finer) ** (-1.0 / two.order)
    return theirs / (one.evaluations * tolerance ** (-1.0 / one.order))


def own_steps(ran: Statistics, finer: float) -> float:
    """Return what a run with finer steps of the same method costs, by its order [s].

    Args:
        ran: What the run did.
        finer: How many times as fine the tolerance is.
    """
    return ran.cost * finer ** (1.0 / INTEGRATORS[ran.method].order)
