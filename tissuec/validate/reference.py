"""The reference's run from event to event, or of equilibria from time to time.

Events come in the order of a run: springs that break, then what earlier actions have entered,
then the script, then the triggers that have become true; samples at that time see it all.
Conditions of ``when`` are taken from the plan as they are; the arithmetic that they use is the
only one that is shared with a run.

Between equilibria, nothing is integrated, so the work is the unexplained part of the change of
energies.
"""

import time as clock
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.core.structs import replace
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.breaking import break_apart
from tissuec.script.measures.snapshot import EnergyBalance, Snapshot
from tissuec.script.plan import LOAD_STEPS, Plan, ScheduledAction
from tissuec.script.verbs import Action, LoggedEvent, after_cuts
from tissuec.script.verbs.settle import Settle
from tissuec.validate.equations import Equations, ErrorScales, overloaded
from tissuec.validate.resting import rest
from tissuec.validate.solution import (
    Break,
    Reference,
    Strains,
    Track,
    TriggerFiring,
    first_true,
    standing_energy,
)
from tissuec.validate.stepping import ONE_STEP, Effort, ReferenceStepper, Step

SAME = 1e-12  # of the duration: times closer than this are one time
SHARP = 1e-14  # of the duration: to this, times of triggers are found
FLOOR = 1e-6  # of the drawing: displacements below are not distinguished


class Ending(NamedTuple):
    """Why a stretch ends: springs break and triggers fire, or neither, at a time [s]."""

    time: float
    broken: Indices
    fired: list[int]


class ReferenceRun:
    """One reference under way.

    Attributes:
        initial: Energy after the events at 0 s [J].
        breaks, firings: What happened.
        strain: Largest tension or pressure over the force that breaks, of each spring, shape
            (spring,).
        effort: What it cost.
    """

    def __init__(self, network: Network, plan: Plan, track: Track, method: str, rtol: float):
        self.network, self.plan, self.track = network, plan, track
        self.method, self.rtol = method, rtol
        self.duration = plan.simulation.duration
        self.state = plan.start(network)
        last = self.duration if plan.simulation.is_static else np.inf
        self.queue = ReferenceQueue(plan.events, SAME * self.duration, last)
        self.waiting = list(range(len(plan.triggers)))
        self.work = self.lost = self.switched = self.initial = 0.0
        self.ruptured = np.zeros(network.entity_count, dtype=bool)
        self.strain = np.zeros(network.entity_count)
        self.breaks: list[Break] = []
        self.firings: list[TriggerFiring] = []
        self.effort = Effort()

    def go(self, stop: float, progress: Callable[[float], None] | None = None) -> None:
        """Run from 0 s to an end [s], and report the simulated time [s] after each step."""
        state = self.state
        tell: Callable[[float], None] = progress or (lambda time: None)
        self._happen(_NOTHING, [])
        self.initial, self.switched = standing_energy(state), 0.0
        while state.time < stop:
            until = min(self.queue.next, stop)
            equations = self._equations(until)
            ending = self._at_once(equations) or self._stretch(equations, until, tell)
            self._happen(ending.broken, ending.fired)
        self._look_now(self._equations(stop))

    def _equations(self, stop: float) -> Equations:
        """Return the equations of motion from the state to a time [s]."""
        return Equations(self.state, stop)

    # --- stretches between events -------------------------------------------------------------

    def _at_once(self, equations: Equations) -> Ending | None:
        """Return the ending of a run in which something breaks at the start, else None."""
        time = self.state.time
        moved, velocity = equations.spread(time, self._y(equations))
        broken = overloaded(equations, moved, equations.pull(time, moved, velocity))
        if not len(broken):
            return None
        return Ending(time, broken, [])

    def _stretch(
        self, equations: Equations, stop: float, progress: Callable[[float], None]
    ) -> Ending:
        """Step to a time or to the first break or trigger."""
        self._look_now(equations)
        strains, y = Strains(equations), self._y(equations)
        ending = Ending(stop, _NOTHING, [])
        for step in self._steps(equations, y, stop):
            found = self._ending(equations, strains, step)
            ending = found or ending
            self._look_within(equations, step, stop if found is None else found.time)
            y = step.after if found is None else step.exact(found.time)
            self.track.measure(equations, min(step.stop, ending.time), y)
            progress(min(step.stop, ending.time))
            if found is not None:
                break
        self._take(equations, ending.time, y)
        is_entity = strains.springs < len(self.strain)  # and no glue
        able, highest = strains.springs[is_entity], strains.highest[is_entity]
        self.strain[able] = np.maximum(self.strain[able], highest)
        return ending

    def _steps(self, equations: Equations, y: Floats, stop: float) -> Iterator[Step]:
        """Yield steps that land on every sample, if the method can, and on the stop."""
        stepper = ReferenceStepper(
            equations, self.method, self.rtol, self._floor(), self.effort
        )
        time = self.state.time
        size: float | None = None
        while time < stop:
            lands = self.method in ONE_STEP
            leg = min(self.track.due, stop) if lands else stop
            sizes: list[float] = []
            for step in stepper.steps(time, y, leg, self.track.scales, size):
                yield step
                y, time = step.after, step.stop
                sizes.append(step.stop - step.start)
            # One step that was cut short by a sample says nothing against longer ones.
            size = max(sizes[0], size or 0.0) if len(sizes) == 1 else max(sizes)

    def _ending(self, equations: Equations, strains: Strains, step: Step) -> Ending | None:
        """Return the first break or trigger within a step."""
        broken = strains.first_break(step) if len(strains.springs) else None
        fired = self._trigger(equations, step, broken.time if broken else step.stop)
        if fired is not None and (broken is None or fired.time < broken.time):
            return fired
        if broken is None:
            return None
        return Ending(broken.time, broken.springs, [])

    def _trigger(self, equations: Equations, step: Step, stop: float) -> Ending | None:
        state = self.state
        if not self.waiting and not state.is_slipping:
            return None

        def true(time: float, y: Floats) -> list[int]:
            moved, velocity = equations.spread(time, y)
            return self._true(self._snapshot(time, equations.drawn + moved, velocity, y))

        def seizes(time: float, y: Floats) -> bool:
            moved, velocity = equations.spread(time, y)
            return bool(state.seizing(time, equations.drawn + moved, velocity))

        def happens(time: float, y: Floats) -> bool:
            return bool(true(time, y)) or (state.is_slipping and seizes(time, y))

        when = first_true(happens, step, stop, SHARP * self.duration)
        if when is None:
            return None
        # At the end of its bracket a condition may be true of the interpolated state only.
        return Ending(
            when, _NOTHING, true(when, step.exact(when)) or true(when, step.near(when))
        )

    def _floor(self) -> ErrorScales:
        """Return scales below which errors do not matter."""
        network = self.network
        size = FLOOR * (network.extent or float(network.springs.rest.max(initial=0.0)) or 1.0)
        speed = size / self.duration
        stiffest = float(network.springs.sudden.max(initial=0.0))
        heaviest = float(network.mass[: network.body_nodes].max(initial=0.0))
        return ErrorScales(size, speed, stiffest * size**2 + heaviest * speed**2)

    # --- state --------------------------------------------------------------------------------

    def _y(self, equations: Equations) -> Floats:
        state = self.state
        return equations.gather(state.position, state.velocity, self.work, self.lost)

    def _take(self, equations: Equations, time: float, y: Floats) -> None:
        """Make a state of the unknowns that of the state."""
        state, free = self.state, equations.free
        moved, velocity = equations.spread(time, y)
        state.time = time
        state.position[free] = equations.drawn[free] + moved[free]
        state.velocity[free] = velocity[free]
        internal = self.network.internal_rows
        state.velocity[internal] = velocity[internal]
        state.place_held()
        self.work, self.lost = map(float, y[-2:])

    def _look_now(self, equations: Equations) -> None:
        while self.track.due <= self.state.time:
            self._enter(equations, self._y(equations))

    def _look_within(self, equations: Equations, step: Step, stop: float) -> None:
        """Enter the samples of a step before a time, at which something happens."""
        while self.track.due <= step.stop and self.track.due < stop:
            self._enter(equations, step.near(self.track.due))

    def _enter(self, equations: Equations, y: Floats) -> None:
        self.track.enter(equations, y, self.state.every_holder, self.switched)

    # --- events -------------------------------------------------------------------------------

    def _happen(self, broken: Indices, fired: list[int]) -> None:
        """Do all that is due now, and enter into the ledger what energy it switched."""
        before = standing_energy(self.state)
        for name in self.state.give_way(broken):
            broken = broken[broken != self.state.knots[name].hold]
        if len(broken):
            parted, edges, *_ = break_apart(self.state, broken)
            self.ruptured[parted] = self.ruptured[edges] = True
            if len(parted):
                self.breaks.append(Break(self.state.time, parted))
        self.state.seize()
        self._carry_out()
        while fired := fired or self._true(self._now()):
            for trigger in fired:
                self.waiting.remove(trigger)
                self.firings.append(TriggerFiring(self.state.time, trigger))
                self.queue.script(self.plan.triggers[trigger].events, self.state.time)
            fired = []
            self._carry_out()
        self.switched += standing_energy(self.state) - before

    def _carry_out(self) -> None:
        for action in self.queue.due(self.state.time):
            if isinstance(action, Settle):
                self.state.place_held()
                rest(self.state, action.chosen(self.state))
            else:
                after_cuts(action, self.state).apply(self.state, self.queue)
        self.state.place_held()
        self.state.let_leak()

    def _true(self, snapshot: Snapshot) -> list[int]:
        return [n for n in self.waiting if self.plan.triggers[n].condition(snapshot)]

    def _now(self) -> Snapshot:
        state = self.state
        sums = np.array([self.work, self.lost])
        return self._snapshot(state.time, state.position, state.velocity, sums)

    def _snapshot(self, time: float, position: Floats, velocity: Floats, y: Floats) -> Snapshot:
        work, lost = y[-2:]
        sizes = abs(work), abs(lost), abs(self.switched), self.track.scales.energy
        ledger = EnergyBalance(self.initial, work, lost, self.switched, max(sizes))
        return replace(
            Snapshot.of(self.state),
            time=time,
            position=position,
            velocity=velocity,
            ruptured=self.ruptured,
            ledger=ledger,
        )


_NOTHING: Indices = np.zeros(0, dtype=np.int64)


_ENTERED, _WRITTEN = 0, 1


class ReferenceQueue:
    """Actions in the order of time; those that actions add come before written ones.

    Args:
        events: The script, its times counted from 0 s.
        near: Times that differ by no more than this are one time [s].
        last: Time from which ends of actions count as after the run [s].
    """

    def __init__(self, events: Sequence[ScheduledAction], near: float, last: float = np.inf):
        self._near, self._last = near, last
        self._written = sorted({event.time for event in events})
        self._rows: list[tuple[float, int, int, Action | None]] = []
        self._entered = 0
        self.script(events, 0.0)

    def add(self, time: float, action: Action) -> None:
        """Enter an action at a time [s]."""
        if time < self._last - self._near:
            self._enter(time, _ENTERED, action)

    def land(self, times: Floats) -> None:
        """Enter times at which a derivative jumps [s]."""
        for time in times:
            self._enter(float(time), _ENTERED, None)

    def end(self, ended: LoggedEvent) -> None:
        """Ignore what ends the run: a reference lasts for its whole duration."""

    def script(self, events: Sequence[ScheduledAction], start: float) -> None:
        """Enter written events, counted from a start [s]."""
        for event in events:
            self._enter(start + event.time, _WRITTEN, event.action)

    @property
    def next(self) -> float:
        """Return the time of what comes next [s]; infinite if nothing does."""
        return self._rows[0][0] if self._rows else float("inf")

    def due(self, time: float) -> Iterator[Action]:
        """Take out and yield the events due at a time [s], also those entered meanwhile."""
        while self._rows and self._rows[0][0] <= time + self._near:
            action = self._rows.pop(0)[3]
            if action is not None:
                yield action

    def _enter(self, time: float, rank: int, action: Action | None) -> None:
        # A written time that is nearly the same is meant, such as 3 * 0.1 s and 0.3 s.
        time = next((t for t in self._written if abs(t - time) <= self._near), time)
        self._rows.append((time, rank, self._entered, action))
        self._rows.sort(key=lambda row: row[:3])
        self._entered += 1


MINIMISERS = "minimisers"  # instead of the name of a method
CLOSE = 1e-7  # of the duration: to this, times of ruptures and triggers are found


class StillEquations(Equations):
    """Equations of a net whose holders move so slowly that dashpots exert no force."""

    def spread(self, time: float, y: Floats) -> tuple[Floats, Floats]:
        """Return displacements [m] of all nodes, and no velocities, shape (node, 3) each."""
        moved, velocity = super().spread(time, y)
        return moved, np.zeros_like(velocity)


class StaticRun(ReferenceRun):
    """One reference under way; see the module."""

    def _equations(self, stop: float) -> Equations:
        return StillEquations(self.state, stop)

    @property
    def _longest(self) -> float:
        """Return the longest time between two equilibria [s]."""
        return self.plan.simulation.step or np.inf

    def _at_once(self, equations: Equations) -> Ending | None:
        """Return nothing: ruptures are determined when the net is at rest."""
        return None

    def _stretch(
        self, equations: Equations, stop: float, progress: Callable[[float], None]
    ) -> Ending:
        """Go from one equilibrium to the next, to a time or to the first break or trigger."""
        state, size = self.state, self._longest
        if (ending := self._rested(equations, state.time)) is not None:
            return ending
        self._look_now(equations)
        while state.time < stop:
            start, position = state.time, state.position.copy()
            ending = self._rested(equations, min(self.track.due, stop, start + size))
            if ending is not None:
                return self._closed_in(equations, start, position, ending)
            self._look_now(equations)
            progress(state.time)
        return Ending(stop, np.zeros(0, dtype=np.int64), [])

    def _closed_in(
        self, equations: Equations, start: float, position: Floats, ending: Ending
    ) -> Ending:
        """Return the first rupture or trigger after a time without one [s]."""
        state = self.state
        while ending.time - start > CLOSE * self.duration:
            middle = 0.5 * (start + ending.time)
            state.time, state.position[:] = start, position
            found = self._rested(equations, middle)
            if found is None:
                start, position = middle, state.position.copy()
            else:
                ending = found
        state.time, state.position[:] = start, position
        return self._rested(equations, ending.time) or ending

    def _rested(self, equations: Equations, time: float) -> Ending | None:
        """Bring the state to equilibrium at a time [s]; return the events there."""
        state = self.state
        state.time = time
        state.place_held()
        state.velocity[:] = 0.0
        rest(state, np.ones(self.network.node_count, dtype=bool))
        self.work = standing_energy(state) - self.initial - self.switched + self.lost
        y = self._y(equations)
        moved, velocity = equations.spread(time, y)
        self.track.measure(equations, time, y)
        broken = overloaded(equations, moved, equations.pull(time, moved, velocity))
        true = self._true(self._now())
        return Ending(time, broken, true) if len(broken) or true else None


class PhasedRun(StaticRun):
    """One reference under way that is static for some intervals."""

    @property
    def _is_still(self) -> bool:
        return self.state.still_until > self.state.time

    @property
    def _longest(self) -> float:
        return self.duration / LOAD_STEPS

    def _equations(self, stop: float) -> Equations:
        of = super()._equations if self._is_still else super(StaticRun, self)._equations
        return of(stop)

    def _at_once(self, equations: Equations) -> Ending | None:
        of = super()._at_once if self._is_still else super(StaticRun, self)._at_once
        return of(equations)

    def _stretch(
        self, equations: Equations, stop: float, progress: Callable[[float], None]
    ) -> Ending:
        of = super()._stretch if self._is_still else super(StaticRun, self)._stretch
        return of(equations, stop, progress)


FINEST = 1e-13  # the smallest error per step that rounding leaves room for
WITHOUT_PROMISE = 1e-4  # replaces the tolerance where a scene has a fixed step


def default_rtol(plan: Plan) -> float:
    """Return the error per step that should make a reference far better than the promise."""
    return max((plan.simulation.tolerance or WITHOUT_PROMISE) / 1000.0, FINEST)


def reference(
    network: Network,
    plan: Plan,
    times: Floats,
    *,
    method: str = "DOP853",
    rtol: float | None = None,
    until: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Reference:
    """Return the solution of a plan.

    Args:
        times: Times of interest [s], ascending, shape (row,).
        method: One of SciPy's: DOP853, RK45, RK23, Radau, BDF or LSODA.
        rtol: Error per step relative to the largest displacement, speed and energy so far; a
            thousandth of the tolerance by default.
        until: Time at which the run ended early [s]; its whole duration by default.
        progress: Called with the simulated time [s] after each step.

    Raises:
        ReferenceFailure: SciPy's solver cannot continue.
    """
    started = clock.monotonic()
    track = Track(np.asarray(times, dtype=float), network.node_count)
    kind = ReferenceRun if not plan.static_intervals else PhasedRun
    kind = StaticRun if plan.simulation.is_static else kind
    run = kind(network, plan, track, method, rtol or default_rtol(plan))
    run.go(plan.simulation.duration if until is None else until, progress)
    run.effort.wall_time = clock.monotonic() - started
    return Reference(
        method=method,
        rtol=run.rtol,
        times=track.times,
        position=track.position,
        velocity=track.velocity,
        force=track.force,
        holders=tuple(track.holders),
        displacement=track.sizes[:, 0],
        speed=track.sizes[:, 1],
        energies=track.energies,
        initial=run.initial,
        breaks=tuple(run.breaks),
        firings=tuple(run.firings),
        strain=run.strain,
        effort=run.effort,
    )
