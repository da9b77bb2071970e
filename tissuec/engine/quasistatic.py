"""Quasi-static runs: a net that is in equilibrium again and again while its holders move.

Free nodes have no velocity. The net is in equilibrium at the times of outputs and of the
script, and at as many between them as the step requires; nothing is computed in between. Energy
that is lost on the way is booked as dissipated.

The procedure of the paper is here, the first of its two ways of propagation: at each time that
counts, the net is relaxed to the local minimum of its energy from where it is. Its second step
calculates the activities of the nodes for the next time. On request, velocity neurons hold v =
Δx / Δt of the last displacement of a node, and its next one begins at x + v Δt, which is what
position neurons make of it (equations 1 to 3). Statics by Newton's method are
``engine.equilibria``.
"""

import json
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from tissuec.core.units import FORCE, show
from tissuec.engine import failures
from tissuec.engine.execution.event_queue import SAME
from tissuec.engine.method import (
    Follow,
    Interruption,
    Method,
    MethodChange,
    Pause,
    Samples,
    Statistics,
    unfollowed,
)
from tissuec.engine.step_events import Survey, Watch
from tissuec.forces.fields import Field
from tissuec.mechanics import observables
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.relaxation import relax
from tissuec.mechanics.settling import Unsettled, refuse_falling
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.script.plan import RELAXATION
from tissuec.script.procedures import RelaxationChoices

THRESHOLD = 1e-9  # of the largest force: the change of a force that counts
SWEEPS = 20_000


class QuasiStatic:
    """Steps one quasi-static run; the interface is that of ``Engine``.

    Args:
        network: The network of the run.
        method: With a step: the longest time between two states in equilibrium.
        sample_times: When to record [s], ascending without repetitions, shape (sample,).
        record: Called with each sample.

    Attributes:
        remarks: Remarks of the summary of the run on the equilibria that were found.
    """

    name: ClassVar[str]
    solver: ClassVar[str]  # in the place of the backend of steps, of which there are none

    def __init__(
        self,
        network: Network,
        method: Method,
        sample_times: Floats,
        record: Callable[[Samples], None],
    ):
        assert method.step is not None, "the step says how often the net is in equilibrium"
        self.network, self.method, self.step = network, method, method.step
        self._times, self._record = sample_times, record
        self.remarks: list[str] = []
        self._sample = self._accepted = self._rejected = self._evaluations = 0
        self._work = self._lost = self._begun = 0.0
        self._stale = True
        self._smallest, self._largest = np.inf, 0.0
        self._viewed = np.zeros((0, 3)), np.zeros((0, 3))
        self.follow: Follow = unfollowed

    @property
    def statistics(self) -> Statistics:
        reason = f'"{self.name}" was requested'
        return Statistics(
            method=self.name,
            reason=reason,
            backend=self.solver,
            accepted=self._accepted,
            rejected=self._rejected,
            evaluations=self._evaluations,
            factorisations=0,
            solutions=0,
            stalls=0,
            smallest=self._smallest if self._largest else 0.0,
            largest=self._largest,
            changes=(MethodChange(0.0, self.name, reason),),
        )

    def skip_samples(self, time: float) -> None:
        """Leave out the samples before a time [s]."""
        self._sample = int(np.searchsorted(self._times, time))

    def restart(self, state: State) -> None:
        """Take over a state; see ``Engine.restart``."""
        self._stale, self._begun = True, state.time

    def advance(
        self,
        state: State,
        until: float,
        watch: Watch | None = None,
        pause: Pause | None = None,
        survey: Survey | None = None,
        view: float = np.inf,
    ) -> Interruption:
        """Step to ``until`` or to the first interruption; see ``Engine.advance``.

        Args:
            state: The one that ``restart`` took over.
            until: Time [s].
            watch: Condition that interrupts.
            pause: Returns whether to return between two states in equilibrium.
            survey: Not used.
            view: Come back "viewed" as soon as the state at this time [s] is known, which is
                the last one in equilibrium up to it.
        """
        while True:
            if self._stale and (found := self._go(state, state.time, watch, pause)):
                return found
            if state.time >= until:
                return Interruption("reached", state.time)
            self._take_samples(state, np.nextafter(state.time, np.inf))
            if view < self._next(state.time, until):
                self._viewed = state.position.copy(), state.velocity.copy()
                return Interruption("viewed", view)
            time = self._next(state.time, until)
            if time - state.time <= SAME * self.method.duration:
                self._arrive(state, time)  # the same equilibrium
            elif found := self._go(state, time, watch, pause):
                return found
            self.follow(state.time, state.position)
            if pause is not None and pause(state.time):
                return Interruption("paused", state.time)

    def look(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return positions [m], velocities [m/s] and the ledger [J] at a viewed ``time`` [s].

        The shapes are (node, 3) twice, and (2,); see ``Engine.look``.
        """
        position, velocity = self._viewed
        return position, velocity, np.array([self._work, self._lost])

    @property
    def viewable(self) -> float:
        """Return minus infinity: every viewed time comes after that of the state."""
        return -np.inf

    def take_over(self, state: State) -> None:
        """Do nothing: all samples up to a viewed time are recorded."""

    def finish(self, state: State) -> None:
        """Record the sample at the final time, after every event there."""
        self._take_samples(state, np.nextafter(state.time, np.inf))

    def checkpoint(self) -> dict[str, Any]:
        """Return the numbers that ``restore`` continues from."""
        return {
            "sample": self._sample,
            "steps": np.array([self._accepted, self._rejected, self._evaluations]),
            "ledger": np.array([self._work, self._lost]),
            "begun": self._begun,
            "sizes": np.array([self._smallest, self._largest]),
            "remarks": json.dumps(self.remarks),
        }

    def restore(self, state: State, saved: Mapping[str, Any]) -> None:
        """Continue from a checkpoint."""
        self._sample, self._begun = int(saved["sample"]), float(saved["begun"])
        self._accepted, self._rejected, self._evaluations = map(int, saved["steps"])
        self._work, self._lost = map(float, saved["ledger"])
        self._smallest, self._largest = map(float, saved["sizes"])
        self.remarks = json.loads(str(saved["remarks"]))
        self._stale = False

    def _next(self, time: float, until: float) -> float:
        """Return the next time of an equilibrium [s], at most ``until``."""
        count = np.ceil((until - self._begun) / self.step * (1.0 - 1e-12))
        size = (until - self._begun) / max(count, 1.0)
        frames = self._begun + size * (np.floor((time - self._begun) / size + 1e-9) + 1.0)
        frame = until if frames > until - 1e-9 * size else frames
        sample = self._times[self._sample] if self._sample < len(self._times) else np.inf
        return float(min(frame, sample, until))

    def _take_samples(self, state: State, before: float) -> None:
        """Record the state for the samples that are due before a time [s]."""
        while self._sample < len(self._times) and self._times[self._sample] < before:
            time = self._times[self._sample : self._sample + 1].copy()
            self._sample += 1
            self._record(self.sample(state)._replace(time=time))

    def sample(self, state: State) -> Samples:
        """Return the present state as a batch of one sample."""
        moving = state.velocity if self._moves else np.zeros_like(state.velocity)
        motion = state.position[None].copy(), moving[None].copy()
        sums = np.array([self._work]), np.array([self._lost])
        # How far nodes come between samples is ignored.
        still = np.zeros(1)
        return Samples(np.array([state.time]), *motion, *sums, error=still, reach=still)

    def _go(
        self, state: State, time: float, watch: Watch | None, pause: Pause | None
    ) -> Interruption | None:
        """Advance to a time [s] and to equilibrium there; return an interruption on the way.

        Args:
            pause: As for ``advance``, for where this takes several steps.
        """
        raise NotImplementedError

    def _arrive(self, state: State, time: float) -> float:
        """Move the holders of a state to a time; return the time that has passed [s]."""
        span = time - state.time
        state.time, self._stale = time, False
        state.place_held()
        if not self._moves:
            state.velocity[:] = 0.0  # holders move, but so slowly that dashpots bear nothing
        return span

    def _count(self, span: float) -> None:
        """Count an accepted step [s]."""
        self._accepted += 1
        if span > 0.0:
            self._smallest = min(self._smallest, span)
            self._largest = max(self._largest, span)

    def _happens(self, state: State, watch: Watch | None) -> Interruption | None:
        """Return the interruption in a state, if there is one."""
        if self.method.watch_strength:
            broken = failures.overloaded(state)
            if len(broken):
                return Interruption("ruptured", state.time, springs=broken)
        if watch is not None and watch(state.time, state.position, state.velocity):
            return Interruption("triggered", state.time)
        return None

    def _look(self, state: State) -> "Look":
        """Return the quantities from which work and energy are booked."""
        position, still = state.position, np.zeros_like(state.velocity)
        held = state.held
        force = np.zeros_like(position)
        for load in state.loads.values():
            load.add_forces(state.time, position, still, force)
        inner = observables.inner_forces(state, state.time, position, still)
        if state.guides is not None:
            acting = observables.applied_forces(state) + inner.node
            force[state.guides.nodes] -= state.guides.held_part(acting)
        force[held] = -inner.node[held]
        for field in state.supplied:
            field.add_forces(state.time, position, still, force)
        moving = state.velocity if self._moves else still
        energy = float(observables.energies(state, state.time, position, moving).total)
        reeled = [reeling.springs for reeling in state.reelings.values()]
        drawn = np.concatenate([*reeled, np.zeros(0, dtype=np.int64)])
        pull = observables.tension(state, position, still, drawn)
        changing = tuple(field for field in state.fields if field.changes)
        rest = state.springs.rest[drawn]
        return Look(state.time, position.copy(), force, rest, -pull, energy, changing)

    @property
    def _moves(self) -> bool:
        """Return whether free nodes have velocities."""
        return False

    def _book(self, work: float, lost: float) -> None:
        self._work += work
        self._lost += lost


class Look(NamedTuple):
    """The quantities from which work and energy are booked.

    Attributes:
        time: [s].
        position: Of all nodes [m], shape (node, 3).
        force: From outside, that does work on them [N], shape (node, 3).
        rest: Rest lengths of threads that are drawn in or paid out [m], shape (piece,).
        pull: Forces that do work on these: minus their tensions [N], shape (piece,).
        energy: [J].
        changing: Fields with parameters that change in time, such as a volume that is inflated.
    """

    time: float
    position: Floats
    force: Floats
    rest: Floats
    pull: Floats
    energy: float
    changing: tuple[Field, ...]

    def until(self, after: "Look") -> tuple[float, float]:
        """Return the work [J] by the trapezoidal rule, and how much of it energies lack."""
        done = np.vdot(0.5 * (self.force + after.force), after.position - self.position)
        done += np.vdot(0.5 * (self.pull + after.pull), after.rest - self.rest)
        for field in self.changing:
            for x in (self.position, after.position):
                done += 0.5 * float(field.energy(after.time, x) - field.energy(self.time, x))
        return float(done), float(done) - (after.energy - self.energy)


class Relaxations(QuasiStatic):
    """The procedure of the paper; see the module."""

    name = RELAXATION
    solver = "node by node"

    @property
    def _choices(self) -> RelaxationChoices:
        given = self.method.choices
        return given if isinstance(given, RelaxationChoices) else RelaxationChoices()

    @property
    def _moves(self) -> bool:
        return self._choices.activities == "velocities"

    def _go(
        self, state: State, time: float, watch: Watch | None, pause: Pause | None
    ) -> Interruption | None:
        before = self._look(state) if self.method.ledger else None
        span = self._arrive(state, time)
        balance = Balance(state, np.ones(self.network.node_count, dtype=bool))
        try:
            refuse_falling(balance, balance.start)
        except Unsettled as failure:
            return Interruption("stuck", time, node=failure.node, message=failure.message)
        bars = balance.bars(balance.start)
        threshold = self._choices.threshold
        if threshold is None:
            threshold = THRESHOLD * balance.largest(bars) + balance.noise(bars)
        start = balance.start
        if self._moves:
            start += span * state.velocity[balance.free]
        found = relax(balance, start, threshold=threshold, most=SWEEPS)
        self._count(span)
        self._evaluations += found.sweeps
        state.position[balance.free] = found.x
        state.velocity[balance.free] = 0.0
        if self._moves and span > 0.0:
            state.velocity[balance.free] = (found.x - balance.start) / span
        state.follow_hosts()
        if found.change > threshold and found.sweeps == SWEEPS:
            force = balance.force(balance.bars(found.x))
            node = int(balance.free[np.argmax((force**2).sum(axis=1))])
            left = show(found.change, FORCE)
            message = f"forces still change by {left} after {SWEEPS} sweeps"
            return Interruption("stuck", time, node=node, message=message)
        if before is not None:
            self._book(*before.until(self._look(state)))
        return self._happens(state, watch)
