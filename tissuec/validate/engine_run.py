"""The engine's run of a plan, watched: states at output times, and what happened."""

from collections.abc import Callable

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import evenly
from tissuec.core.signals import interruption
from tissuec.core.structs import replace
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import Outcome, run
from tissuec.engine.method import Samples
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.script.measures.snapshot import EnergyBalance, Snapshot
from tissuec.script.plan import Plan, without_outputs
from tissuec.validate.solution import Break, TriggerFiring

WITHOUT_OUTPUT = 101  # times at which a scene that writes nothing is observed
MOST_ROWS = 2001
MOST_BYTES = 256e6  # that the states of one solution may take


class Observed(Struct, frozen=True, eq=False):
    """A run of the engine at chosen times.

    Attributes:
        times: [s], shape (row,).
        position, velocity, force: As in a reference, shape (row, node, 3).
        imbalance: Energy that is there and should not be [J], shape (row,).
        scale: Largest energy so far [J], shape (row,).
        breaks, firings: What happened.
        strain: Largest tension or pressure over the force that breaks, of each spring at any
            output time, shape (spring,).
        outcome: How the run ended.
    """

    times: Floats
    position: Floats
    velocity: Floats
    force: Floats
    imbalance: Floats
    scale: Floats
    breaks: tuple[Break, ...]
    firings: tuple[TriggerFiring, ...]
    strain: Floats
    outcome: Outcome


def output_times(network: Network, plan: Plan) -> Floats:
    """Return every time at which a plan writes or judges something [s], shape (time,)."""
    times = Recorder(network, plan, MemoryRecording()).times
    duration = plan.simulation.duration
    return times if len(times) > 1 else np.linspace(0.0, duration, WITHOUT_OUTPUT)


def thinned(times: Floats, nodes: int) -> Floats:
    """Return the times [s], or evenly chosen ones if there are too many to compare, shape (n,).

    Args:
        times: Times [s], shape (row,).
        nodes: Number of nodes.
    """
    most = int(min(MOST_ROWS, MOST_BYTES / (9 * 8 * max(nodes, 1))))
    return times[evenly(len(times), max(most, 2))]


def observe(
    network: Network, plan: Plan, times: Floats, progress: Callable[[float], None]
) -> Observed:
    """Run a plan with the engine and return its states at some times.

    No file is written and no expectation evaluated; the energy ledger is kept.

    Args:
        times: Times of interest [s], shape (row,).
        progress: Called with the simulated time [s].

    Raises:
        KeyboardInterrupt: The run was interrupted.
    """
    watched = replace(without_outputs(plan), needs_ledger=True)
    tap = _SampleRecorder(network, watched, times)
    outcome = run(network, watched, tap, progress=progress)
    if outcome.kind == "interrupted":
        raise interruption(outcome.signal)
    return tap.observed(outcome)


class _SampleRecorder(Recorder):
    """A recorder that keeps the samples themselves."""

    def __init__(self, network: Network, plan: Plan, times: Floats):
        super().__init__(network, plan, MemoryRecording())
        self.times = times
        self._rows: list[tuple[Floats, ...]] = []
        self._strain = np.zeros(network.entity_count)
        self._standing: tuple[State, EnergyBalance]

    def enter(self, state: State, ruptured: NDArray[np.bool_], ledger: EnergyBalance) -> None:
        super().enter(state, ruptured, ledger)
        standing = replace(state, holders=dict(state.holders))
        self._standing = standing, ledger

    def record(self, samples: Samples) -> None:
        super().record(samples)
        state, ledger = self._standing
        none = np.zeros(self.network.entity_count, dtype=bool)
        snapshot = Snapshot(state, samples.time, samples.position, samples.velocity, none)
        ledger = replace(ledger, work=samples.work, dissipated=samples.dissipated)
        tension = snapshot.tension
        strain = np.maximum(tension / state.springs.strength, -tension / state.springs.crush)
        own = self._strain[: self.network.spring_count]
        np.maximum(own, strain.max(axis=0, initial=0.0), out=own)
        for field in state.fields:
            breakable = field.breakable
            if breakable is not None and breakable.entities[0] < len(self._strain):
                loads = [breakable.loads(position) for position in samples.position]
                own = breakable.entities
                highest = np.max(loads, axis=0, initial=0.0)
                self._strain[own] = np.maximum(self._strain[own], highest)
        self._rows.append(
            (
                samples.time,
                samples.position,
                samples.velocity[:, : self.network.node_count],
                snapshot.node_force,
                ledger.balance(snapshot.energies),
                ledger.size(snapshot.energies),
            )
        )

    def record_end(self, sample: Samples) -> None:
        if not self._rows or float(self._rows[-1][0][-1]) < float(sample.time[0]):
            self.record(sample)

    def observed(self, outcome: Outcome) -> Observed:
        """Return the observations of a run."""
        size = self.network.node_count
        empty = (np.zeros(0), *(np.zeros((0, size, 3)) for _ in range(3)), *[np.zeros(0)] * 2)
        columns = (np.concatenate(column) for column in zip(empty, *self._rows, strict=True))
        times, position, velocity, force, imbalance, scale = columns
        spans = [trigger.span for trigger in self.plan.triggers]
        happened = outcome.logged_events
        firings = [
            TriggerFiring(t, spans.index(h.span)) for t, h in happened if h.kind == "trigger"
        ]
        return Observed(
            times=times,
            position=position,
            velocity=velocity,
            force=force,
            imbalance=imbalance,
            scale=np.maximum.accumulate(scale),
            breaks=_breaks(outcome, self.network),
            firings=tuple(firings),
            strain=self._strain,
            outcome=outcome,
        )


def _breaks(outcome: Outcome, network: Network) -> tuple[Break, ...]:
    """Return the breaks, joined by time: a run reports them by tissues.

    Edges that are lost with elements are left out.
    """
    edges = range(network.spring_count, network.line_count)
    found: dict[float, list[int]] = {}
    for time, logged_event in outcome.logged_events:
        if logged_event.kind in ("rupture", "crush"):
            springs = [one for one in logged_event.springs if one not in edges]
            found.setdefault(time, []).extend(springs)
    return tuple(Break(time, np.sort(np.array(springs))) for time, springs in found.items())
