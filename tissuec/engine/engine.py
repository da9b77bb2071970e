"""The engine: steps a state from event to event, delivers samples, reports why it stops.

It owns no physics: integrators and kernels do the arithmetic, ``drive`` the loop over steps,
which ``stepper`` calls; here is what must be decided between these calls.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from tissuec.core.signals import Halted
from tissuec.engine import failures
from tissuec.engine.backends import default_backend
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import (
    Follow,
    Interruption,
    Method,
    Pause,
    Samples,
    Statistics,
    unfollowed,
)
from tissuec.engine.method_choice import MethodChoice
from tissuec.engine.method_control import MethodControl
from tissuec.engine.run_arrays import SampleBuffer
from tissuec.engine.saving import restore_control, restore_stepper, saved_choice, saved_engine
from tissuec.engine.step_events import AcceptedStep, Survey, Watch
from tissuec.engine.stepper import PAUSE, Stepper
from tissuec.engine.watching import (
    FIRST_TOGETHER,
    MOST_TOGETHER,
    Loads,
    Standpoint,
    cut_step,
    first_interruption,
    may_happen,
    steps_together,
)
from tissuec.kernels.records import (
    FULL,
    HELD,
    LOOKED,
    OUTSIZE,
    PAUSED,
    REACHED,
    ROAMED,
    STRAYED,
    SURPASSED,
    VIEWED,
)
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network

FINEST_TOLERANCE = 1e-13  # below, rounding alone is larger


class Engine:
    """Steps one run.

    ``restart`` takes over a state, ``advance`` steps it to a time and returns early when
    springs rupture, a watched condition becomes true, or the motion cannot continue. On a
    rupture the state is at its exact time with the springs still alive: the caller marks them
    dead in ``state.alive`` and calls ``restart``, as after every other change.

    Args:
        network: The network of the run.
        method: How it is to be stepped.
        sample_times: When to record [s], ascending without repetitions, shape (sample,).
        record: Called with each batch of samples. Unless a single step holds more samples than
            half the buffer, the state is then at the start of a step and ``checkpoint`` returns
            the data from which a later run can continue.
        backend: Forces one backend, for tests. Otherwise methods that are shipped are stepped
            by compiled code.

    Attributes:
        stepper: What it steps, and calls the loop over steps on.
        follow: Called with a time [s] and the positions of all nodes [m], shape (node, 3),
            between two steps, as soon as nodes in contact may have met others, or nodes have
            moved by the distance that it returned before [m].
        remarks: Nothing; see ``QuasiStatic``.
    """

    remarks: ClassVar[Sequence[str]] = ()

    def __init__(
        self,
        network: Network,
        method: Method,
        sample_times: Floats,
        record: Callable[[Samples], None],
        *,
        backend: str | None = None,
    ):
        self.network, self.method = network, method
        self.backend = backend
        inputs = KernelInputs(
            network,
            watched=method.watch_strength,
            ledger=method.ledger,
            threads=method.threads,
        )
        buffer = SampleBuffer(sample_times, inputs, record)
        self.stepper = Stepper(network, method, inputs, buffer)
        self._control = MethodControl(self.stepper)
        self._stale = True
        # The step that is made and not taken over, and what interrupts in it.
        self._viewed: tuple[AcceptedStep, Interruption | None] | None = None
        self._closely = -np.inf  # until when steps are examined one by one [s]
        self._densely = -np.inf  # until when all of them are examined [s]
        self._together = FIRST_TOGETHER  # steps that are examined together
        self._kept: Standpoint | None = None
        self._loads: Loads | None = None  # of elements that may break
        self.follow: Follow = unfollowed

    @property
    def choice(self) -> MethodChoice:
        """Return the integrator and why it was chosen; known after the first ``restart``.

        Raises:
            ValueError: ``restart`` was not called yet.
        """
        return self._control.choice

    @property
    def statistics(self) -> Statistics:
        """Return the cost of the run so far."""
        choice, stepper = self.choice, self.stepper
        now, effort = stepper.progress, stepper.work.effort
        return Statistics(
            method=choice.name,
            reason=choice.reason,
            backend=stepper.backend,
            accepted=now.accepted,
            rejected=now.rejected,
            evaluations=int(effort[0] + effort[LOOKED]),
            factorisations=int(effort[1]),
            solutions=int(effort[2]),
            stalls=int(effort[3]),
            smallest=now.smallest if now.accepted else 0.0,
            largest=now.largest,
            changes=tuple(self._control.changes),
            threads=stepper.inputs.team.record.threads,
            cost=self._control.cost,
        )

    def restart(self, state: State) -> None:
        """Take over a state that was changed from outside, with its time."""
        stepper, control = self.stepper, self._control
        stepper.park(state)
        stepper.inputs.update(state)
        if begins := not control.begun:
            self._begin(state)
        control.yield_to_losses(state)
        stepper.load(state)
        control.equip(state, begins=begins)
        stepper.forget_net()
        self._stale, stepper.segment, self._viewed = False, None, None
        self._loads = Loads.of(stepper.inputs) if self.method.watch_strength else None
        if not stepper.progress.step:
            stepper.update(step=stepper.first_step())

    def _begin(self, state: State, choice: MethodChoice | None = None) -> None:
        """Make the arrays of the run for an integrator; by default, one is chosen."""
        self._control.begin(state, choice)
        self.stepper.begin(state)
        self.stepper.backend = self.backend or default_backend(self.stepper.integrator)

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
                time at which it holds interrupts. It is tested at the start, at the end of each
                step, and within the step that made it true.
            pause: Called now and then between two steps, with the time [s]; True makes this
                return "paused", to be called again with the same ``until``.
            survey: Tells whether the condition may hold at any of several times, given arrays
                of shapes (time,) and (time, node, 3). With it, many steps of a small net are
                examined together, and one by one only where it may hold.
            view: Come back "viewed" as soon as ``look`` can tell the state at this time [s],
                unless something interrupts before it. The steps are the same as without, and
                the state remains where it is.

        Raises:
            ValueError: ``until`` is before the time of the state.
        """
        if self._stale or self.stepper.inputs.state is not state:
            self.restart(state)
        if (failure := self._refusal()) is not None:
            return failure
        if view <= self.viewable:
            return Interruption("viewed", view)
        if until < state.time:
            raise ValueError(f"cannot step back from {state.time:g} s to {until:g} s")
        segment = self.stepper.segment
        resumed = segment is not None and self.stepper.progress.time < segment
        if not resumed and (early := self._at_once(state, watch)) is not None:
            return early
        with np.errstate(all="ignore"):
            result = self._advance(state, until, watch, pause, survey, view)
        self._control.book_cost()  # before events change what a step costs
        if result.kind == "viewed":
            return result
        self.stepper.synchronise(state)
        self.stepper.flush()
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
        return (
            self.stepper.inputs.positions(x),
            self.stepper.inputs.outwards(v),
            ledger,
        )

    @property
    def viewable(self) -> float:
        """Return the latest time of a state from ``look`` [s]; minus infinity without any."""
        if self._viewed is None:
            return -np.inf
        within, found = self._viewed
        return within.end if found is None else found.time

    def take_over(self, state: State) -> None:
        """Go on to the end of a viewed step, so that its samples are recorded.

        ``look`` remains possible, and so is a checkpoint then, unless something interrupts in
        the step: samples up to there are recorded when the run continues.
        """
        if self._viewed is None or self._viewed[1] is not None:
            return
        while self.stepper.progress.pending:
            self.stepper.call(0, evaluations=0)
            self.stepper.flush()
        self.stepper.synchronise(state)

    @property
    def has_begun(self) -> bool:
        """Return whether ``restart`` was called."""
        return self._control.begun

    def remember_motion(self, origin: Floats, displacement: float) -> None:
        """Relate errors to the motion of a whole run, of which this steps a later part.

        Args:
            origin: Positions of all nodes where it began [m], shape (node, 3).
            displacement: The largest one so far [m].
        """
        stepper = self.stepper
        stepper.work.origin[:] = stepper.inputs.inwards(origin)
        stepper.update(displacement=displacement, displacement_before=displacement)

    def finish(self, state: State) -> None:
        """Record the sample at the final time, after every event there."""
        self.stepper.record_end(state)

    def sample(self, state: State) -> Samples:
        """Return the present state as a batch of one sample."""
        return self.stepper.sample(state)

    def checkpoint(self) -> dict[str, Any] | None:
        """Return numbers and arrays to resume from, with the state; None within a step."""
        if self.stepper.progress.pending:
            return None
        return saved_engine(self.stepper, self._control)

    def restore(self, state: State, saved: Mapping[str, Any]) -> None:
        """Resume from a checkpoint and the state that belongs to it.

        The next call of ``advance`` must have the same end as the one that was interrupted; the
        run then gives the same bytes as without interruption.
        """
        self._begin(state, saved_choice(saved))
        self.restart(state)
        restore_stepper(self.stepper, state, saved)
        self.stepper.backend = self.backend or self.stepper.backend
        restore_control(self._control, saved)

    def _refusal(self) -> Interruption | None:
        """Return why the tolerance cannot be kept at all, or the net not be stepped, if so."""
        stepper, tolerance = self.stepper, self.method.tolerance
        if stepper.integrator.implicit:
            for block in stepper.inputs.state.present_blocks:
                if what := block.field.unsolved:
                    reason = f"{self.choice.name} does not support {what}"
                    return Interruption("stuck", stepper.progress.time, message=reason)
        if self.method.step is None and tolerance is not None and tolerance < FINEST_TOLERANCE:
            return Interruption(
                "stuck",
                stepper.progress.time,
                message=f"a tolerance of {tolerance:g} is finer than rounding errors "
                f"({FINEST_TOLERANCE:g})",
            )
        return None

    def _at_once(self, state: State, watch: Watch | None) -> Interruption | None:
        """Return the interruption at the start, before any step."""
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
        stepper = self.stepper
        self._closely = self._densely = -np.inf
        stepper.task = stepper.task._replace(viewed=view)
        if (found := self._leave_viewed()) is not None:
            return found
        while True:
            if stepper.segment is None or stepper.progress.time >= stepper.segment:
                if stepper.progress.time >= until:
                    return Interruption("reached", stepper.progress.time)
                stepper.begin_segment(stepper.inputs.next_knot(stepper.progress.time, until))
            self._control.contend(state)
            reason = self._called(watch, survey)
            if reason is None:
                continue
            if reason in (HELD, SURPASSED, VIEWED):
                self._viewed = first_interruption(
                    stepper, watch, self._loads, surpassed=reason == SURPASSED
                )
                if view <= self.viewable:
                    return Interruption("viewed", view)
                if (found := self._leave_viewed()) is not None:
                    return found
            elif reason not in (REACHED, PAUSED) and not self._goes_on(reason, state):
                return failures.explain(reason, stepper.work, stepper.progress, stepper.inputs)
            if not stepper.progress.pending:
                stepper.asked = stepper.evaluations
                if pause is not None and pause(stepper.progress.time):
                    return Interruption("paused", stepper.progress.time)

    def _called(self, watch: Watch | None, survey: Survey | None) -> int | None:
        """Call the loop over steps as ``_call``; return to its start if a step gives way."""
        stepper = self.stepper
        if not stepper.integrator.implicit:
            return self._call(watch, survey)
        kept = self._standpoint()
        try:
            return self._call(watch, survey)
        except Halted:
            kept.bring_back(stepper)
            return stepper.call(0, 0)  # to the next moment at which a run can pause

    def _call(self, watch: Watch | None, survey: Survey | None) -> int | None:
        """Call the loop over steps; return why it returned, or None to call it again.

        With a survey, or without any condition, many steps are made at once, and made again one
        by one if a condition may hold in them, or an element break.
        """
        stepper = self.stepper
        limit = stepper.call_limit(self._control.evaluations_in(PAUSE))
        if self._control.is_free:
            limit = min(limit, self._control.trial.look)
        if watch is None and self._loads is None:
            return stepper.call(0, limit)
        # Breaking elements are seen between states at equal distances.
        is_sparse = self._loads is None and stepper.progress.time >= self._densely
        spacing = self.method.spacing if is_sparse else 0.0
        together = 1
        if watch is None or survey is not None:
            together = min(self._together, steps_together(stepper))
        if together == 1 or stepper.progress.time < self._closely:
            return stepper.call(1, limit)
        kept = self._standpoint()
        reason = stepper.call(together, limit, spacing)
        if may_happen(stepper, survey, self._loads, kept):
            if together > FIRST_TOGETHER:
                self._together = FIRST_TOGETHER
            elif spacing:
                self._densely = stepper.progress.end
            else:
                self._closely = stepper.progress.end
            kept.bring_back(stepper)
            return None
        self._together = min(2 * self._together, MOST_TOGETHER)
        if reason not in (SURPASSED, VIEWED):
            stepper.update(glanced=0)
        return None if reason == HELD else reason

    def _standpoint(self) -> Standpoint:
        """Return the present state of the stepper."""
        if self._kept is None or self._kept.work is not self.stepper.work:
            self._kept = Standpoint(self.stepper)
        else:
            self._kept.take(self.stepper)
        return self._kept

    def _goes_on(self, reason: int, state: State) -> bool:
        """Do what lets the loop over steps continue, if possible; return whether it does."""
        stepper = self.stepper
        if reason == FULL:
            stepper.synchronise(state)
            stepper.flush()
        elif reason == ROAMED or (reason == STRAYED and stepper.list_anew()):
            stepper.show(self.follow)
        elif reason == OUTSIZE and failures.is_flight(
            stepper.work, stepper.progress, stepper.inputs
        ):
            stepper.task = stepper.task._replace(bound=1e3 * stepper.task.bound)
        else:
            return self._control.rescue(reason, state)
        return True

    def _leave_viewed(self) -> Interruption | None:
        """Leave a step that could be examined; return what interrupts in it, if anything."""
        if self._viewed is None:
            return None
        (within, found), self._viewed = self._viewed, None
        if found is not None:
            cut_step(self.stepper, within, found.time)
        return found
