"""An experiment of any scene, run by the engine, with differences of runs as derivatives.

Everything that a run can do is in it: contact, volumes, jets, threads, springs that relax.
Where rows have displacements instead of times, runs go from equilibrium to equilibrium.

A derivative is the difference of two runs over a small step in one parameter, as large as makes
the error of the difference least: that of the runs, divided by the step, against that of the
third derivative, which grows with its square (J. Nocedal, S. J. Wright, Numerical Optimization,
2006, chapter 8).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from tissuec.compiler.learning.displacements import rows_of
from tissuec.core.errors import TissueError
from tissuec.core.signals import interruption
from tissuec.core.structs import replace
from tissuec.engine.execution.event_queue import SAME, join_times
from tissuec.engine.execution.finer_run import USUAL
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.method import Samples
from tissuec.learn.derivatives.equilibria import Unbalanced
from tissuec.learn.derivatives.model import Slots, measured, slots_of
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.derivatives.refusals import refusal
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.measurements.experiment import Series
from tissuec.model.network import Floats, Network
from tissuec.script.fit_problem import DataAxis
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import EQUILIBRIUM, Plan, Simulation, without_outputs

#: Of the tolerance of the scene: errors of runs, by which intervals are wider, are small beside
#: those of the scene. Differences are taken over steps that are as long as these errors need.
FINER = 0.1
FINEST = 1e-11
COARSER = 10.0  # times the tolerance, to see what errors of runs are like
OF_STEPS, OF_RELAXING = 1e-12, 1e-9  # errors of runs that have no tolerance
SMALLEST, LARGEST = 1e-4, 1e-2  # steps in parameters


class RunPredictions(NamedTuple):
    """The predictions of a run, and the method that it ended with."""

    values: Floats
    method: str


#: Returns the predictions at some parameters, each of shape (parameter,), by a method and up to
#: a time [s]: each of shape (number,), or None where there is no motion.
Runs: TypeAlias = Callable[[Sequence[Floats], str, float], Sequence[Floats | None]]


class FiniteDifferenceModel:
    """Predictions of a run by the engine.

    Args:
        axis: The moved nodes whose displacement rows have; None where they have times.

    Attributes:
        name: How derivatives are found, for people.
        runs: Does the runs of a derivative; None: one after the other, here.

    Raises:
        CompileError: The script does not move the nodes as far as a row says.
    """

    runs: Runs | None = None

    def __init__(
        self,
        shaping: Parametrisation,
        series: tuple[Series, ...],
        axis: DataAxis | None = None,
    ):
        self.shaping, self.is_still = shaping, axis is not None
        self.name = f"finite differences of {'equilibria' if axis else 'whole runs'}"
        if axis is not None:
            times, rows = rows_of(shaping.compiled, series, axis)
            series = tuple(
                replace(one, times=times[row]) for one, row in zip(series, rows, strict=True)
            )
        self.series, self.slots = series, slots_of(series)
        self.size = len(measured(series))
        self.times = np.unique(np.concatenate([one.times for one in series]))
        self._stop = np.inf
        self._known: tuple[Floats, RunPredictions] | None = None
        self._slopes: tuple[Floats, Floats] | None = None

    @property
    def notes(self) -> tuple[str, ...]:
        """Return why derivatives are differences, in sentences."""
        reason = refusal(self.shaping, at_rest=self.is_still)
        return (f"derivatives are {self.name}" + (f": {reason}" if reason else ""),)

    @property
    def error(self) -> float:
        """Return the relative error of predictions.

        Parameters that differ by less are the same: their predictions differ by chance.
        """
        simulation = self._simulation(np.inf)
        if simulation.is_static:
            return OF_RELAXING
        return OF_STEPS if simulation.tolerance is None else simulation.tolerance

    @property
    def step(self) -> float:
        """Return the step in a parameter over which differences are taken."""
        return float(np.clip(np.cbrt(3.0 * self.error), SMALLEST, LARGEST))

    @property
    def plan(self) -> Plan:
        """Return the plan of a run at the first parameters, without outputs."""
        written = self.shaping.compiled.plan
        stop = float(self.times.max(initial=0.0)) or written.simulation.duration
        return replace(without_outputs(written), simulation=self._simulation(stop))

    def freeze(self, theta: Floats) -> None:
        """Keep nothing: every run finds what happens by itself."""

    def limit(self, stop: float) -> None:
        """Predict only up to a time [s]."""
        if stop != self._stop:
            self._stop, self._known, self._slopes = stop, None, None

    def predict(self, theta: Floats) -> Floats:
        """Return the predictions; raises Diverged, and TissueError where there is no scene."""
        return self._told(theta).values.copy()

    def gradient(self, theta: Floats, weights: Floats) -> Floats:
        """Return the derivatives of Σ weights · predictions."""
        return self.jacobian(theta).T @ weights

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of all predictions, by differences in each parameter."""
        if self._slopes is None or not self._is_same(theta, self._slopes[0]):
            here = self._told(theta)
            points = [
                self._moved(theta, k, sign) for k in range(len(theta)) for sign in (-1, 1)
            ]
            there = [at for at in points if at is not None]
            if self.runs is None:
                found = iter([self.run_at(at, here.method) for at in there])
            else:
                found = iter(self.runs(there, here.method, self._stop))
            sides = [None if at is None else next(found) for at in points]
            rows = [
                self._slope(theta, here, k, points[2 * k : 2 * k + 2], sides[2 * k : 2 * k + 2])
                for k in range(len(theta))
            ]
            self._slopes = theta.copy(), np.array(rows).reshape(len(theta), self.size).T.copy()
        return self._slopes[1].copy()

    def step_error(self, theta: Floats) -> Floats:
        """Return the difference to predictions of a coarser run, or of half the step."""
        here = self._told(theta)
        try:
            return self._run(theta, here.method, COARSER).values - here.values
        except (Diverged, TissueError):
            return np.full(self.size, np.inf)

    def run_at(self, theta: Floats, method: str) -> Floats | None:
        """Return the predictions of a run in SI units, shape (number,); None without motion.

        Args:
            theta: Parameters, dimensionless, shape (parameter,).
            method: By which it is stepped.
        """
        try:
            return self._run(theta, method).values
        except (Diverged, TissueError):
            return None

    # --- parts --------------------------------------------------------------------------------

    def _moved(self, theta: Floats, k: int, sign: int) -> Floats | None:
        """Return parameters with one of them a step away; None where it is at its limit."""
        low, high = self.shaping.bounds()
        moved = theta.copy()
        moved[k] = np.clip(theta[k] + sign * self.step, low[k], high[k])
        return None if moved[k] == theta[k] else moved

    def _slope(
        self,
        theta: Floats,
        here: RunPredictions,
        k: int,
        points: Sequence[Floats | None],
        values: Sequence[Floats | None],
    ) -> Floats:
        """Return the derivatives by one parameter; from one side only where the other ends.

        Args:
            theta: Parameters, dimensionless, shape (parameter,).
            here: What is predicted there.
            k: Place of the parameter.
            points: The same a step before and after, None where there is a limit.
            values: Predictions there, shape (number,); None where there is no motion.
        """
        sides = [(theta[k], here.values)]
        for at, side in zip(points, values, strict=True):
            if at is not None and side is not None:
                sides.append((at[k], side))
        if len(sides) == 1:
            return np.zeros(self.size)
        (before, low), (after, high) = sides[-2:]
        return (high - low) / (after - before)

    def _told(self, theta: Floats) -> RunPredictions:
        """Return the predictions; the last ones are kept in memory."""
        if self._known is None or not self._is_same(theta, self._known[0]):
            self._known = theta.copy(), self._run(theta, "")
        return self._known[1]

    def _is_same(self, theta: Floats, other: Floats) -> bool:
        """Return whether parameters differ by less than runs can tell."""
        return float(np.abs(theta - other).max(initial=0.0)) <= self.error

    def _run(self, theta: Floats, method: str, coarser: float = 1.0) -> RunPredictions:
        """Run the scene.

        Args:
            method: By which it is stepped; "" for that of the scene. Of runs whose difference
                is taken, none may choose another one.
            coarser: Times the tolerance; half the step, where there is no tolerance.
        """
        times = self.times[self.times <= self._stop]
        if not len(times):
            return RunPredictions(np.zeros(self.size), method)
        present = self.shaping.present(theta)
        stop = float(times[-1]) or min(present.plan.simulation.duration, self._stop)
        simulation = self._simulation(stop)
        simulation = replace(simulation, integrator=method or simulation.integrator)
        if coarser != 1.0 and simulation.step is not None:
            simulation = replace(simulation, step=0.5 * simulation.step)
        elif coarser != 1.0:
            assert simulation.tolerance is not None  # there is one or the other
            simulation = replace(simulation, tolerance=coarser * simulation.tolerance)
        plan = replace(without_outputs(present.plan), simulation=simulation)
        watcher = ObservingRecorder(present.network, plan, self.series, self.slots, self._stop)
        outcome = run(present.network, plan, watcher)
        if outcome.kind == "interrupted":
            raise interruption(outcome.signal)
        if outcome.kind != "done":
            time = outcome.state.time
            raise Unbalanced(time, outcome.message) if self.is_still else Diverged(time)
        statistics = outcome.statistics
        settled = len(statistics.changes) < 2  # it came to no other method on the way
        return RunPredictions(watcher.found, statistics.method if settled else "")

    def _simulation(self, stop: float) -> Simulation:
        """Return how runs are stepped: as in the scene, but more finely."""
        simulation = replace(self.shaping.compiled.plan.simulation, duration=stop)
        if self.is_still:
            return replace(simulation, integrator=EQUILIBRIUM, tolerance=None, step=stop)
        if simulation.step is not None:
            return simulation
        tolerance = simulation.tolerance or USUAL
        return replace(simulation, tolerance=max(FINER * tolerance, min(tolerance, FINEST)))


class ObservingRecorder(Recorder):
    """A recorder that observes a run as an experiment did.

    Args:
        plan: One without outputs.
        slots: The place of each series among the predictions.
        stop: Later rows are ignored [s].

    Attributes:
        found: Predictions in SI units, 0 where nothing was observed, shape (number,).
    """

    takes_notes = False

    def __init__(
        self,
        network: Network,
        plan: Plan,
        series: tuple[Series, ...],
        slots: tuple[Slots, ...],
        stop: float,
    ):
        super().__init__(network, plan, MemoryRecording())
        self._series, self._slots = series, slots
        self.found = np.zeros(sum(slot.rows * slot.width for slot in slots))
        near = SAME * plan.simulation.duration
        wanted = np.concatenate([one.times[one.times <= stop] for one in series])
        # What is measured at the time of an event shows what is after it.
        self.times = join_times(wanted, np.array([event.time for event in plan.events]), near)
        self._places = [np.searchsorted(self.times, one.times - near) for one in series]

    def record(self, samples: Samples) -> None:
        """Take the next samples of ``times``."""
        assert self._state is not None, "enter comes first"
        first, last = np.searchsorted(self.times, samples.time[[0, -1]])
        snapshot = self._snapshot(samples, self._state)
        for one, slot, places in zip(self._series, self._slots, self._places, strict=True):
            rows = np.flatnonzero((places >= first) & (places <= last))
            if len(rows):
                seen = _seen(one, slot.width, snapshot.pick(places[rows] - first))
                entries = slot.start + slot.width * rows[:, None] + np.arange(slot.width)
                self.found[entries] = seen


def _seen(one: Series, width: int, snapshot: Snapshot) -> Floats:
    """Return the values of a series at some snapshots, shape (snapshot, width)."""
    fit = one.fit
    if fit.measure is None:
        values = snapshot.position[..., one.nodes, :]
    else:
        values = fit.measure.sample(fit.subjects, snapshot)
    values = fit.part(values)
    rows = values.reshape(len(snapshot.position), -1)
    if fit.measure is not None and rows.shape[1] != width:
        rows = fit.measure.value(rows)
    return rows.reshape(-1, width)
