"""Statics: equilibria by Newton's method, along a path of adaptive load steps.

From one equilibrium the next follows as held nodes and loads move on. While the path is smooth,
nothing is lost on it: the work of all that acts is the change of the energy. A step whose work,
by the trapezoidal rule, differs from that is repeated as two halves. Where it differs however
small the step, there is no equilibrium near the one before (a limit point): the net snaps to
another, and what it loses is booked as dissipated and remarked. Ruptures and conditions are
closed in on in the same way.

Newton's method begins where the path leads, on the straight line through the last two states.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core.units import ENERGY, PRESSURE, TIME, show
from tissuec.engine.method import Interruption
from tissuec.engine.quasistatic import QuasiStatic
from tissuec.engine.step_events import Watch
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.settling import Remark, Unsettled, settle
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.script.plan import EQUILIBRIUM

ALLOWED = 2e-2  # of the energies of the run: what work by the rule may differ from them in all
SMOOTH = 0.1  # of what a step may differ by: below, the next one is twice as long
FINEST = 1e-6  # of the duration: steps that are not divided any more
NOISE = 1e2  # times the rounding of the energy: differences that are none
NEARLY = 1.5  # times that: steps that are as short but for rounding
MOST_REMARKS = 8


class Past(Struct, frozen=True, eq=False):
    """An equilibrium, and the one before it.

    Attributes:
        position: [m], shape (node, 3).
        before: Likewise.
        span: Time between both [s].
    """

    position: Floats
    before: Floats
    span: float


class Equilibria(QuasiStatic):
    """Steps one run; see the module."""

    name = EQUILIBRIUM
    _size = np.inf  # of the next step, at most [s]
    _usual = np.inf  # the same where no jump is closed in on
    _waits = False  # whether the next step is not longer than this one
    _ahead = np.inf  # when something happens that is closed in on [s]
    _scale = 0.0  # largest energy or work so far [J]
    _past: Past | None = None

    def restart(self, state: State) -> None:
        """Take over a state; see ``Engine.restart``."""
        super().restart(state)
        self._past, self._ahead = None, np.inf

    def finish(self, state: State) -> None:
        """Record the sample at the final time, in equilibrium after every event there."""
        if self._stale and self._go(state, state.time, None) is not None:
            self.remarks.append("there is no equilibrium after what happens at the end")
        super().finish(state)

    def checkpoint(self) -> dict[str, Any]:
        """Return the numbers that ``restore`` continues from."""
        past = self._past
        kept = {} if past is None else {"position": past.position, "before": past.before}
        span = 0.0 if past is None else past.span
        path = np.array(
            [self._size, self._usual, float(self._waits), self._ahead, self._scale, span]
        )
        return {**super().checkpoint(), **kept, "path": path}

    def restore(self, state: State, saved: Mapping[str, Any]) -> None:
        """Continue from a checkpoint."""
        super().restore(state, saved)
        self._size, self._usual, waits, self._ahead, self._scale, span = map(
            float, saved["path"]
        )
        self._waits = bool(waits)
        if "before" in saved:
            self._past = Past(saved["position"], saved["before"], span)

    @property
    def _finest(self) -> float:
        """Return the size of steps that are not divided any more [s]."""
        return FINEST * self.method.duration

    def _go(self, state: State, time: float, watch: Watch | None) -> Interruption | None:
        while True:
            target = self._target(state.time, time)
            found = self._step(state, target, watch)
            if found is not None or state.time >= time:
                return found
            if self._pause is not None and self._pause(state.time):
                return Interruption("paused", state.time)

    def _target(self, now: float, time: float) -> float:
        """Return the end of the next step [s], at most ``time``."""
        until = min(time, self._ahead)
        size = min(until - now, max(self._size, self._finest))
        if self._ahead <= time and until - now > NEARLY * self._finest:
            size = min(size, 0.5 * (until - now))
        return now + size if until - now > size + 0.5 * self._finest else until

    def _step(self, state: State, target: float, watch: Watch | None) -> Interruption | None:
        """Go to an equilibrium at a time [s], or back to the state if that is too far."""
        start, position, velocity = state.time, state.position.copy(), state.velocity.copy()
        before = self._look(state)
        span = self._arrive(state, target)
        divides = span > NEARLY * self._finest
        guess = self._guess(span)
        everything = np.ones(self.network.node_count, dtype=bool)
        failure: Unsettled | None = None
        remarks: tuple[Remark, ...] = ()
        found: Interruption | None = None
        work = lost = 0.0
        self._evaluations += 1
        try:
            remarks = settle(state, everything, guess, patiently=not divides)
        except Unsettled as refusal:
            failure = refusal
        else:
            work, lost = before.until(self._look(state))
            found = self._happens(state, watch)
        allowed = ALLOWED * self._scale_with(work, before.energy) * span / self.method.duration
        allowed += NOISE * self._rounding(state)
        jumps = failure is None and abs(lost) > allowed
        if divides and (failure is not None or jumps or found is not None):
            state.time = start
            state.place_held()
            state.position[:], state.velocity[:] = position, velocity
            self._rejected += 1
            if failure is not None or jumps:
                self._size, self._waits = 0.5 * span, True
            else:
                self._ahead = target
            return None
        if failure is not None:
            message = self._limit(state, target) if self._past else failure.message
            return Interruption("stuck", target, node=failure.node, message=message)
        self._count(span)
        self._book(*((work, lost) if jumps else (work - lost, 0.0)))
        if target >= self._ahead:
            self._ahead = np.inf
        if span > 0.0:
            self._note(target, [r.message for r in remarks], lost if jumps else 0.0)
            self._lengthen(span, smooth=abs(lost) < SMOOTH * allowed, jumped=jumps)
        self._past = None if jumps or not span else Past(state.position.copy(), position, span)
        return found

    def _lengthen(self, span: float, *, smooth: bool, jumped: bool) -> None:
        """Choose the largest size of the next step after one that is accepted [s]."""
        if jumped:
            self._size, self._waits = self._usual, False
        elif self._waits:
            self._waits = False
        elif smooth:
            self._size = self._usual = max(self._size, 2.0 * span)

    def _limit(self, state: State, time: float) -> str:
        """Return that the net has lost its equilibrium at a time [s], and under which load."""
        loads = [
            f"a pressure of {show(float(each.pressure(time)), PRESSURE)} on {each.name}"
            for each in state.pressures
        ]
        under = f" under {' and '.join(loads)}" if loads else ""
        return (
            f"no equilibrium is near the one before{under}; prescribe a motion or a volume "
            "instead of a force or pressure, or use a dynamic method"
        )

    def _guess(self, span: float) -> Floats | None:
        """Return where the path leads after a time [s], shape (node, 3) [m], if known."""
        past = self._past
        if past is None or span <= 0.0:
            return None
        return past.position + (span / past.span) * (past.position - past.before)

    def _rounding(self, state: State) -> float:
        """Return the scale of the rounding errors of the energy [J]."""
        balance = Balance(state, ~state.held)
        return float(balance.energy(balance.start, balance.bars(balance.start))[1])

    def _scale_with(self, work: float, energy: float) -> float:
        """Return the scale of energies of the run until now [J]."""
        self._scale = max(self._scale, abs(work), abs(self._work + work), abs(energy))
        return self._scale

    def _note(self, time: float, messages: Sequence[str], lost: float) -> None:
        """Remark what is new about an equilibrium, and energy [J] that a jump to it lost."""
        said = [f"{message} (first at {show(time, TIME)})" for message in messages]
        if lost:
            said.append(
                f"at {show(time, TIME, digits=6)} the net snapped to another equilibrium, "
                f"because none was near the one before; {show(lost, ENERGY)} were dissipated"
            )
        for text in said:
            known = text.rpartition(" (first at ")[0]
            if len(self.remarks) < MOST_REMARKS and not any(
                known and other.startswith(known) for other in self.remarks
            ):
                self.remarks.append(text)
