"""The engine: steps a state from event to event, delivers samples, reports why it stops.

It owns no physics: integrators and kernels do the arithmetic, ``drive`` the loop over steps;
here is what must be decided between calls of that loop.
"""

import json
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
from msgspec.structs import asdict, astuple, replace

from tissuec.engine import failures
from tissuec.engine.backends import bound_drive, bound_inside, default_backend, loop_operations
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.procedures import PropagationChoices
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import (
    Backend,
    Interruption,
    Method,
    MethodChange,
    Samples,
    Statistics,
)
from tissuec.engine.method_choice import Choice, choose, measured_facts
from tissuec.engine.method_trial import (
    PATIENT,
    MethodTrial,
    candidate_for,
    cost_of,
    evaluation_time,
    trial_cost,
)
from tissuec.engine.sample_buffer import SampleBuffer
from tissuec.engine.state import (
    arrays_of,
    first_step,
    least_pressure,
    new_progress,
    new_task,
    new_work,
)
from tissuec.engine.step_events import RESOLUTION, AcceptedStep, Survey, Watch, bisect
from tissuec.kernels.calls import raise_failure
from tissuec.kernels.record_tables import RecordTable
from tissuec.kernels.records import (
    FULL,
    GLANCES,
    HELD,
    LOOKED,
    OUTSIZE,
    PAUSED,
    REACHED,
    STRAYED,
    SURPASSED,
    UNDERFLOW,
    UNSOLVED,
    VIEWED,
    Progress,
)
from tissuec.mechanics import observables
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.script.plan import AUTOMATIC, DEFAULT_TOLERANCE

FINEST_TOLERANCE = 1e-13  # below, rounding alone is larger
# Spring evaluations after which the loop comes back to be asked for a pause: about 0.2 s.
CALL_SPRINGS: dict[Backend, int] = {"interpreted": 2_000_000, "compiled": 40_000_000}
# Steps that are looked at together for conditions, and coordinates of states in them, at most.
MOST_TOGETHER, GLANCED = 16, 200_000

Pause = Callable[[float], bool]


class Engine:
    """Steps one run.

    ``restart`` takes over a state, ``advance`` steps it to a time and comes back early when
    springs rupture, a watched condition becomes true, or the motion cannot go on. On a rupture
    the state stands at its exact time with the springs still alive: the caller marks them
    dead in ``state.alive`` and calls ``restart``, as after every other change.

    Args:
        network: The network of the run.
        method: How it is to be stepped.
        sample_times: When to record [s], ascending without repetitions, shape (sample,).
        record: Called with each batch of samples. Unless a single step holds more samples than
            half the buffer, the state stands at a step's start then and ``checkpoint``
            gives what a later run can go on from.
        backend: Forces one backend, for tests. Otherwise methods that are shipped are stepped
            by compiled code.
    """

    def __init__(
        self,
        network: Network,
        method: Method,
        sample_times: Floats,
        record: Callable[[Samples], None],
        *,
        backend: Backend | None = None,
    ):
        self.network, self.method = network, method
        self.backend: Backend | None = backend
        self._inputs = KernelInputs(
            network,
            watched=method.watch_strength,
            ledger=method.ledger,
            threads=method.threads,
        )
        self._buffer = SampleBuffer(sample_times, self._inputs, record)
        self._choice: Choice | None = None
        self._changes: list[MethodChange] = []
        self._trial = MethodTrial()
        self._stale = True
        self._segment: float | None = None
        # The step that is made and not taken over, and what interrupts in it.
        self._viewed: tuple[AcceptedStep, Interruption | None] | None = None
        self._asked = 0  # evaluations when a pause was last offered
        self._net: RecordTable | None = None  # what acts, once it is asked for
        self._listed_at = np.nan  # when what is near shapes was listed [s]
        self._listed_around: Floats | None = None  # and around which positions

    @property
    def choice(self) -> Choice:
        """Return the integrator and why it was chosen; known after the first ``restart``.

        Raises:
            ValueError: ``restart`` was not called yet.
        """
        if self._choice is None:
            raise ValueError("the integrator is chosen by the first restart")
        return self._choice

    @property
    def statistics(self) -> Statistics:
        """Return the cost of the run so far."""
        choice, now, effort = self.choice, self._progress, self._work.effort
        return Statistics(
            method=choice.name,
            reason=choice.reason,
            backend=self._backend,
            accepted=now.accepted,
            rejected=now.rejected,
            evaluations=int(effort[0] + effort[LOOKED]),
            factorisations=int(effort[1]),
            solutions=int(effort[2]),
            stalls=int(effort[3]),
            smallest=now.smallest if now.accepted else 0.0,
            largest=now.largest,
            changes=tuple(self._changes),
            threads=self._inputs.team.record.threads,
        )

    def restart(self, state: State) -> None:
        """Take over a state that was changed from outside, with its time."""
        self._inputs.update(state)
        begins = self._choice is None
        if begins:
            self._begin(state)
        if self._integrator.conservative and (refusal := state.loss):
            self._install(
                Choice("dop853", f"{refusal}, which {self.choice.name} does not support", {})
            )
        self._load(state)
        if self.method.ledger:
            least = max(self._task.least, least_pressure(state, self._task.floor))
            self._task = self._task._replace(least=least)
            present = observables.energies(state, state.time, state.position, state.velocity)
            energy = float(present.kinetic + present.elastic)
            self._update(energy=max(self._progress.energy, energy))
        springs = len(self._inputs.springs.ids) if self.method.watch_strength else 0
        if self._work.tension.shape[1] != springs:
            self._work = self._work._replace(tension=np.zeros((3, springs)))
        cornered = len(self._inputs.springs.ids) if self._inputs.features.cornered else 0
        if self._work.sides.shape[2] != cornered:
            self._work = self._work._replace(sides=np.zeros((2, 3, cornered)))
        self._equip(state)
        if begins:  # they may have been measured for the choice
            self._facts = dict(self.choice.facts) or None
        self._forget_net()
        self._tables: dict[type[Any], RecordTable] = {}  # of further records
        self._stale, self._segment, self._viewed = False, None, None
        if not self._progress.step:
            step = first_step(self._inputs, self._integrator, self.method.duration)
            self._update(step=step)

    def advance(
        self,
        state: State,
        until: float,
        watch: Watch | None = None,
        pause: Pause | None = None,
        survey: Survey | None = None,
        view: float = np.inf,
    ) -> Interruption:
        """Step to ``until``, landed on exactly, or to the first interruption.

        Samples with times from the start up to, but not at, the end are recorded; one at the
        start shows the state after all events there.

        Args:
            state: The one that ``restart`` took over; its state and time are advanced.
            until: Time [s], not before that of the state.
            watch: Condition of time [s], positions and velocities (shape (node, 3)); the first
                time at which it holds interrupts. It is asked at the start, at the end of each
                step, and within the step that made it true.
            pause: Asked now and then between two steps, with the time [s]; True makes this
                return "paused", to be called again with the same ``until``.
            survey: Tells whether the condition may hold at any of several times, given arrays
                of shapes (time,) and (time, node, 3). With it, many steps of a small net are
                looked at together, and one by one only where it may hold.
            view: Come back "viewed" as soon as ``look`` can tell the state at this time [s],
                unless something interrupts before it. The steps are the same as without, and
                the state remains where it is.

        Raises:
            ValueError: ``until`` is before the time of the state.
        """
        if self._stale or self._inputs.state is not state:
            self.restart(state)
        if (failure := self._refusal()) is not None:
            return failure
        if view <= self.viewable:
            return Interruption("viewed", view)
        if until < state.time:
            raise ValueError(f"cannot step back from {state.time:g} s to {until:g} s")
        resumed = self._segment is not None and self._progress.time < self._segment
        if not resumed and (early := self._at_once(state, watch)) is not None:
            return early
        with np.errstate(all="ignore"):
            result = self._advance(state, until, watch, pause, survey, view)
        if result.kind == "viewed":
            return result
        self._synchronise(state)
        self._flush()
        self._stale = result.kind not in ("reached", "paused")
        return result

    def look(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return positions [m], velocities [m/s] and the ledger [J] at a time in a viewed step.

        The shapes are (node, 3) twice, and (2,).

        Args:
            time: From the one that was viewed last on, up to the end of its step [s].

        Raises:
            ValueError: No step is viewed.
        """
        if self._viewed is None:
            raise ValueError("no step is viewed")
        x, v, ledger = self._viewed[0].state(time)
        return self._inputs.outwards(x), self._inputs.outwards(v), ledger

    @property
    def viewable(self) -> float:
        """Return up to when ``look`` can tell the state [s]; minus infinity if it cannot."""
        if self._viewed is None:
            return -np.inf
        within, found = self._viewed
        return within.end if found is None else found.time

    def take_over(self, state: State) -> None:
        """Go on to the end of a viewed step, so that its samples are recorded.

        ``look`` remains possible, and so is a checkpoint then, unless something interrupts in
        the step: samples up to there are recorded when the run goes on.
        """
        if self._viewed is None or self._viewed[1] is not None:
            return
        while self._progress.pending:
            self._call(0, evaluations=0)
            self._flush()
        self._synchronise(state)

    def finish(self, state: State) -> None:
        """Record the sample at the final time, after every event there."""
        while self._buffer.is_due(self._progress, np.nextafter(state.time, np.inf)):
            self._progress = self._buffer.enter(
                self._progress,
                self._inputs.inwards(state.position),
                self._inputs.inwards(state.velocity),
                self._work.ledger[self._progress.current],
            )
        self._flush()

    def checkpoint(self) -> dict[str, Any] | None:
        """Return numbers and arrays to resume from, with the state; None within a step."""
        now, work = self._progress, self._work
        if now.pending:
            return None
        around = self._listed_around
        return {
            **asdict(now),
            "segment": np.nan if self._segment is None else self._segment,
            "stretch": self._inputs.start,
            "acceleration": self._inputs.outwards(work.a[now.current]),
            "origin": self._inputs.outwards(work.origin),
            "ledger": work.ledger[now.current].copy(),
            "power": work.power[1].copy(),
            "trend": work.trend.copy(),
            "effort": work.effort.copy(),
            "doubt": work.doubt.copy(),
            "rate": work.rate[0],
            "cap": self._cap,
            "facts": json.dumps(self._facts),
            "made": work.solver.made[0],
            "made_at": work.solver.at.copy(),
            "made_speed": work.solver.speed.copy(),
            "bound": self._task.bound,
            "tier": self._backend,
            "listed_at": self._listed_at,
            "listed_around": np.zeros((0, 3)) if around is None else around,
            **{f"contest {name}": value for name, value in self._trial.state().items()},
            "changes": json.dumps([astuple(change) for change in self._changes]),
            "method": self.choice.name,
            "reason": self.choice.reason,
        }

    def restore(self, state: State, saved: Mapping[str, Any]) -> None:
        """Resume from a checkpoint and the state that belongs to it.

        The next call of ``advance`` must have the same end as the one that was interrupted; the
        run then gives the same bytes as without interruption.
        """
        self._choice = Choice(str(saved["method"]), str(saved["reason"]), {})
        self._begin(state)
        self.restart(state)
        numbers = {
            name: type(value)(saved[name]) for name, value in asdict(self._progress).items()
        }
        self._progress = Progress(**numbers | {"filled": 0, "current": 0})
        self._work.effort[:], self._work.doubt[:] = saved["effort"], saved["doubt"]
        if self._integrator.implicit:
            self._work.solver.at[:] = saved["made_at"]
            self._work.solver.speed[:] = saved["made_speed"]
            self._work.solver.made[:] = saved["made"], 0.0, 1.0
        self._asked = self._evaluations
        self._backend = self.backend or cast(Backend, str(saved["tier"]))
        self._trial = MethodTrial.restore(
            {name.removeprefix("contest "): value for name, value in saved.items()}
        )
        self._changes = [MethodChange(*change) for change in json.loads(str(saved["changes"]))]
        work, inputs = self._work, self._inputs
        work.a[0] = inputs.inwards(np.asarray(saved["acceleration"]))
        work.v[0] = inputs.inwards(state.velocity)
        work.origin[:] = inputs.inwards(np.asarray(saved["origin"]))
        work.ledger[0], work.power[1] = saved["ledger"], saved["power"]
        work.trend[:] = saved["trend"]
        segment = float(saved["segment"])
        self._segment = None if np.isnan(segment) else segment
        inputs.start, inputs.until = float(saved["stretch"]), segment
        work.rate[0], self._cap = saved["rate"], float(saved["cap"])
        self._facts = json.loads(str(saved["facts"]))
        # Steps are cut by how far nodes are from where they were listed: so those lists again.
        self._listed_at, around = float(saved["listed_at"]), np.asarray(saved["listed_around"])
        self._listed_around = around if len(around) else None
        longest = min(inputs.longest_step(self._integrator.looks), self._cap)
        self._task = self._task._replace(bound=float(saved["bound"]), longest=longest)

    def _begin(self, state: State) -> None:
        """Choose the integrator and make the arrays of the run."""
        self._install(self._choice or choose(state, self.method, self._inputs.is_banded))
        self._work.origin[:] = self._inputs.inwards(state.position)
        start = new_progress(state.time)
        sample = int(np.searchsorted(self._buffer.buffer.times, state.time))
        self._progress = replace(start, sample=sample)
        self._backend: Backend = self.backend or default_backend(self._integrator)

    def _load(self, state: State) -> None:
        """Copy the state into the arrays; all of them hold the nodes that stand still."""
        work, inputs = self._work, self._inputs
        still = (inputs.held & ~inputs.moved)[:, None]
        still[self.network.memory] = False
        position = inputs.inwards(state.position)
        velocity = inputs.inwards(np.where(still, 0.0, state.velocity))
        work.x[:], work.v[:], work.a[:] = position, velocity, 0.0
        work.trial_x[:], work.trial_v[:] = position, velocity
        self._update(time=state.time, fresh=1, memory=0.0, calm=0, pending=0)

    def _install(self, choice: Choice) -> None:
        """Go over to an integrator; the state stays where it is."""
        before = getattr(self, "_work", None)
        now = 0.0 if before is None else self._progress.time
        self._changes.append(MethodChange(now, choice.name, choice.reason))
        self._choice, self._integrator = choice, INTEGRATORS[choice.name]
        self._work = new_work(self._integrator, self.network, self._inputs.team.record)
        method = self.method
        if isinstance(method.choices, PropagationChoices):
            self._work.choices[:] = method.choices.row()
        tolerance = DEFAULT_TOLERANCE if method.tolerance is None else method.tolerance
        task = new_task(self.network, self._integrator, tolerance, method.duration)
        self._task = task._replace(fixed=0 if method.step is None else 1)
        self._cap = np.inf  # of the step, by stability [s]
        if before is not None:
            half = self._progress.current
            self._work.x[:], self._work.v[:] = before.x[half], before.v[half]
            self._work.trial_x[:], self._work.trial_v[:] = before.x[half], before.v[half]
            self._work.ledger[:] = before.ledger[half]
            self._work.origin[:], self._work.effort[:] = before.origin, before.effort
            self._work.doubt[:] = before.doubt
            self._work = self._work._replace(tension=before.tension, sides=before.sides)
            self._update(fresh=1, memory=0.0, calm=0, current=0)

    def _equip(self, state: State) -> None:
        """Give the integrator what depends on the net: unknowns or the fastest rate."""
        if self._integrator.implicit:
            self._work = self._work._replace(solver=self._inputs.solver())
        if self._integrator.stabilised:
            self._work.rate[0], self._cap = self._pace(state)
        self._facts: dict[str, float] | None = None
        self._trial.begin(self._progress, self._work.effort, self.choice.name, self._cost)

    @property
    def _cost(self) -> float:
        """Return the predicted time of all steps so far, at what they cost now [s]."""
        springs, work = len(self._inputs.springs.ids), self._work
        return cost_of(work.effort, self._evaluation_time, springs, work.solver)

    @property
    def _evaluation_time(self) -> float:
        """Return the predicted time of a force evaluation [s]."""
        return evaluation_time(self._inputs.state, len(self._inputs.springs.ids))

    def _contend(self, state: State) -> None:
        """Go over to another method if that comes further, where the choice is ours."""
        if self.method.name != AUTOMATIC or self.method.step is not None:
            return
        if self._progress.pending or self._work.effort[0] < self._trial.look:
            return

        def candidate(pace: float) -> tuple[str, float] | None:
            if state.inelastic is not None:
                return None  # implicit methods refuse such springs
            ahead = self.method.duration - self._progress.time
            if state.fields and not self._integrator.implicit and ahead < PATIENT * pace:
                return None
            self._synchronise(state)
            self._facts = self._facts or measured_facts(state)
            solver = self._inputs.solver()
            step, name, banded = self._progress.step, self.choice.name, self._inputs.is_banded()
            evaluation = self._evaluation_time
            found = candidate_for(name, step, pace, self._facts, evaluation, banded=banded)
            if found is None:
                return None
            springs = len(self._inputs.springs.ids)
            return found, trial_cost(found, evaluation, springs, solver)

        change = self._trial.decide(
            self._progress,
            self._work.effort,
            self._cost,
            self.choice.name,
            self.method.duration,
            candidate,
        )
        if change is not None:
            self._change(change, state)

    def _change(self, choice: Choice, state: State) -> None:
        """Go over to another method between two steps."""
        self._synchronise(state)
        was_implicit = self._integrator.implicit
        self._install(choice)
        self._forget_net()
        self._equip(state)
        if was_implicit and not self._integrator.implicit:
            step = first_step(self._inputs, self._integrator, self.method.duration)
            self._update(step=min(step, self._progress.step))
        longest = min(self._inputs.longest_step(self._integrator.looks), self._cap)
        self._task = self._task._replace(longest=longest)

    def _rescue(self, reason: int, state: State) -> bool:
        """Go on explicitly where an implicit method failed that was our own choice."""
        failed = reason in (UNSOLVED, UNDERFLOW, OUTSIZE)
        if not (failed and self._integrator.implicit and self.method.name == AUTOMATIC):
            return False
        why = f"{self.choice.name} could not solve the equations of a step"
        self._trial.rival = ""
        self._change(Choice("dop853", why, {}), state)
        return True

    def _pace(self, state: State) -> tuple[float, float]:
        """Return the fastest rate [1/s] of a state, and the longest step at it [s]."""
        facts = measured_facts(state)
        omega, zeta = facts["omega"], facts["zeta"]
        if not omega:
            return facts["damping"], np.inf
        fastest = omega * (zeta + np.sqrt(zeta * zeta - 1.0)) if zeta > 1.0 else omega
        return float(fastest), self._integrator.stability_limit(omega, zeta)

    def _update(self, **changes: Any) -> None:
        self._progress = replace(self._progress, **changes)

    def _refusal(self) -> Interruption | None:
        """Return why the tolerance cannot be kept at all, or the net not be stepped, if so."""
        if self._integrator.implicit and self._inputs.springs.inelastic is not None:
            reason = f"{self.choice.name} does not support springs that relax or yield"
            return Interruption("stuck", self._progress.time, message=reason)
        tolerance = self.method.tolerance
        if self.method.step is None and tolerance is not None and tolerance < FINEST_TOLERANCE:
            return Interruption(
                "stuck",
                self._progress.time,
                message=f"a tolerance of {tolerance:g} is finer than rounding errors "
                f"({FINEST_TOLERANCE:g})",
            )
        return None

    def _begin_segment(self, until: float) -> None:
        """Prepare a stretch without knots inside: one curve per profile, uniform steps."""
        now, inputs = self._progress, self._inputs
        self._segment = until
        inputs.start, inputs.until = now.time, until
        longest = min(inputs.longest_step(self._integrator.looks), self._cap)
        self._task = self._task._replace(longest=longest)
        if inputs.is_changing:
            # Velocities and forces may jump here; the accelerations so far are no longer true.
            self._update(fresh=1)
            self._forget_net()
            self._work.solver.made[2] = 1.0
        if self.method.step is not None and until > now.time:
            count = np.ceil((until - now.time) / self.method.step * (1.0 - 1e-12))
            self._update(step=(until - now.time) / max(count, 1.0))

    def _at_once(self, state: State, watch: Watch | None) -> Interruption | None:
        """Return what interrupts at the start already, before any step."""
        time = state.time
        if self.method.watch_strength:
            broken = failures.overloaded(state)
            if len(broken):
                self._stale = True
                return Interruption("ruptured", time, springs=broken)
        if watch is not None and watch(time, state.position, state.velocity):
            return Interruption("triggered", time)
        return None

    def _advance(
        self,
        state: State,
        until: float,
        watch: Watch | None,
        pause: Pause | None,
        survey: Survey | None,
        view: float,
    ) -> Interruption:
        """Call the loop over steps again and again until something interrupts."""
        closely = -np.inf  # until when steps are looked at one by one [s]
        self._task = self._task._replace(viewed=view)
        if (found := self._leave_viewed()) is not None:
            return found
        while True:
            if self._segment is None or self._progress.time >= self._segment:
                if self._progress.time >= until:
                    return Interruption("reached", self._progress.time)
                self._begin_segment(self._inputs.next_knot(self._progress.time, until))
            self._contend(state)
            together = 1 if watch is None else self._together
            if survey is not None and together > 1 and self._progress.time >= closely:
                kept = self._progress, [array.copy() for array in arrays_of(self._work)]
                reason = self._call(together)
                if self._is_seen(survey):
                    closely = self._progress.end
                    self._bring_back(*kept)
                    continue
                if reason not in (SURPASSED, VIEWED):
                    self._update(glanced=0)
                if reason == HELD:
                    continue
            else:
                reason = self._call(0 if watch is None else 1)
            if reason == FULL:
                self._synchronise(state)
                self._flush()
            elif reason in (HELD, SURPASSED, VIEWED):
                self._viewed = self._inside(reason == SURPASSED, watch)
                if view <= self.viewable:
                    return Interruption("viewed", view)
                if (found := self._leave_viewed()) is not None:
                    return found
            elif reason == STRAYED and self._listed_at != self._progress.time:
                self._forget_net()
            elif reason == OUTSIZE and failures.is_flight(
                self._work, self._progress, self._inputs
            ):
                self._task = self._task._replace(bound=1e3 * self._task.bound)
            elif reason not in (REACHED, PAUSED) and not self._rescue(reason, state):
                return failures.explain(reason, self._work, self._progress, self._inputs)
            if not self._progress.pending:
                self._asked = self._evaluations
                if pause is not None and pause(self._progress.time):
                    return Interruption("paused", self._progress.time)

    @property
    def _together(self) -> int:
        """Return how many steps are looked at together.

        Only one with contact, threads or springs that relax or flow: they keep state outside of
        ``Work``, with which the run could not go back.
        """
        needed = self._inputs.features
        if needed.touched or needed.reeled or needed.inelastic:
            return 1
        return min(MOST_TOGETHER, 1 + GLANCED // (GLANCES * self._work.zero.size))

    def _is_seen(self, survey: Survey) -> bool:
        """Return whether the condition may hold in the steps of the last call."""
        buffer, outwards = self._buffer.buffer, self._inputs.outwards
        found = slice(self._progress.glanced)
        if not self._progress.glanced:
            return False
        states = buffer.glance_position[found], buffer.glance_velocity[found]
        return survey(buffer.glance_time[found], *map(outwards, states))

    def _bring_back(self, progress: Progress, arrays: list[Floats]) -> None:
        """Go back to where the run stood."""
        self._progress = progress
        for array, kept in zip(arrays_of(self._work), arrays, strict=True):
            array[:] = kept

    def _call(self, hold: int, evaluations: int | None = None) -> int:
        """Run the loop over steps once on the backend that is due.

        Args:
            hold: As in ``Task``.
            evaluations: Likewise; by default as many as take a while.
        """
        backend = self._backend
        limit = self._asked + CALL_SPRINGS[backend] // (len(self._inputs.springs.ids) + 100)
        if self.method.name == AUTOMATIC and self.method.step is None:
            limit = min(limit, self._trial.look)
        limit = limit if evaluations is None else evaluations
        task = self._task._replace(until=self._inputs.until, evaluations=limit, hold=hold)
        self._buffer.make_room(hold)
        work, net, buffer = self._work, self._acting(), self._buffer.buffer
        if backend == "compiled":
            work, buffer = self._table(work), self._table(buffer)
        drive = bound_drive(self._integrator, backend)
        self._update()  # a copy, which the loop changes
        with self._inputs.team:
            reason = drive(self._progress, task, work, net, buffer)
        for table in net.fields.kept:
            raise_failure(table)
        return reason

    def _table(self, record: Any) -> RecordTable:
        """Return a record as compiled code takes it; that of the last one if it is the same."""
        kind = cast("type[Any]", type(record))
        kept = self._tables.get(kind)
        if kept is None or kept.record is not record:
            kept = self._tables[kind] = RecordTable(record)
        return kept

    @property
    def _evaluations(self) -> int:
        """Return the number of force evaluations so far."""
        return int(self._work.effort[0])

    def _acting(self) -> RecordTable:
        """Return what acts, with the operations on it."""
        if self._net is None:
            inputs, needed = self._inputs, self._inputs.features
            if needed.touched:
                if self._listed_around is None:
                    self._listed_at = self._progress.time
                    self._listed_around = inputs.outwards(self._work.x[self._progress.current])
                inputs.around = self._listed_around
            called = loop_operations(self._integrator, needed)
            net = inputs.net(self._integrator)
            self._net = RecordTable(net._replace(operations=called))
        return self._net

    def _forget_net(self) -> None:
        """Have what acts, and the lists of what is near, made anew when they are needed."""
        self._net, self._listed_around = None, None

    def _leave_viewed(self) -> Interruption | None:
        """Leave a step that could be looked at; return what interrupts in it, if anything."""
        if self._viewed is None:
            return None
        (within, found), self._viewed = self._viewed, None
        if found is not None:
            self._cut(within, found.time)
        return found

    def _inside(
        self, surpassed: bool, watch: Watch | None
    ) -> tuple[AcceptedStep, Interruption | None]:
        """Return the accepted step, and the first rupture or trigger in it."""
        inside = bound_inside(self._integrator)
        work = self._table(self._work)
        within = AcceptedStep(inside, self._progress, work, self._acting(), self._inputs)
        rupture = within.first_rupture(self._integrator.looks) if surpassed else None
        stop = within.end if rupture is None else rupture[0]
        triggered = None if watch is None else self._trigger(within, watch, stop)
        if triggered is not None and (rupture is None or triggered < stop):
            return within, Interruption("triggered", triggered)
        if rupture is None:
            return within, None
        return within, Interruption("ruptured", stop, springs=rupture[1])

    def _trigger(self, within: AcceptedStep, watch: Watch, stop: float) -> float | None:
        """Return the first time up to ``stop`` at which the condition is seen to hold."""

        def holds(when: float) -> bool:
            x, v, _ = within.state(when)
            return watch(when, self._inputs.outwards(x), self._inputs.outwards(v))

        before, buffer = within.start, self._buffer.buffer
        last = self._progress.glanced
        self._update(glanced=0)
        for row in range(last - GLANCES, last):
            when = float(buffer.glance_time[row])
            x, v = buffer.glance_position[row], buffer.glance_velocity[row]
            # A glance is cheap and a little wrong; what it finds is looked at closely.
            seen = when < stop and watch(
                when, self._inputs.outwards(x), self._inputs.outwards(v)
            )
            when = min(when, stop)
            if (seen or when == stop) and holds(when):
                resolution = RESOLUTION * (stop - within.start)
                return bisect(
                    holds, before, when, max(resolution, 1e-15 * self.method.duration)
                )
            before = when
            if when == stop:
                break
        return None

    def _cut(self, within: AcceptedStep, stop: float) -> None:
        """Take over the accepted step up to a time within it, with its samples before that."""
        while self._buffer.is_due(self._progress, stop):
            when = float(self._buffer.buffer.times[self._progress.sample])
            self._progress = self._buffer.enter(self._progress, *within.state(when))
        x, v, ledger = within.state(stop)
        work, now = self._work, self._progress.current
        work.x[now], work.v[now], work.ledger[now] = x, v, ledger
        self._update(time=stop, pending=0, fresh=1)

    def _flush(self) -> None:
        """Give the samples so far to the recorder."""
        before = self._progress
        self._update(filled=0)  # the recorder may ask for a checkpoint
        self._buffer.flush(before)

    def _synchronise(self, state: State) -> None:
        """Copy time and state into the state."""
        now, work = self._progress, self._work
        state.time = now.time
        state.position[:] = self._inputs.outwards(work.x[now.current])
        state.velocity[:] = self._inputs.outwards(work.v[now.current])
        state.rest = state.rest_at(state.time)
