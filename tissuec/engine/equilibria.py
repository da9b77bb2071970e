"""Statics: equilibria by Newton's method along load steps, also in single intervals of a run.

Held nodes and loads change step by step, and each equilibrium is found from the one before.
While the path is smooth, no energy is lost: the work of all forces is the change of the energy.
A step whose work, by the trapezoidal rule, differs from that is repeated as two halves. Where
it differs even in the smallest step, there is no equilibrium near the one before (a limit
point): the net snaps to another, and the energy that it loses is booked as dissipated and
reported. Ruptures and conditions are located in the same way. Where forces only begin to grow,
as at a first touch, the difference falls with the square of the step; there a step is accepted
as soon as that is seen.

Newton's method begins where the path leads: on the straight line through the last two states,
and in the first step where the tangent leads if held nodes move.

Runs that are static for some intervals, and dynamic before and after them.

While a state is to be in equilibrium (``State.still_until``), it goes from one to the
next (``engine.equilibria``); a new engine continues from the last one, whose free nodes have no
velocity. The ledger is that of the whole run.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np

from tissuec.core.structs import replace
from tissuec.core.units import ENERGY, TIME, show
from tissuec.engine.causes import under
from tissuec.engine.engine import Engine
from tissuec.engine.method import Follow, Interruption, MethodChange, Pause, Samples, Statistics
from tissuec.engine.quasistatic import Look, QuasiStatic
from tissuec.engine.step_events import Survey, Watch
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.settling import Remark, Unsettled, settle
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.script.plan import EQUILIBRIUM, LOAD_STEPS

ALLOWED = 2e-2  # of energies or work: what work by the rule may differ from changes of energy
FALLS = 0.35  # of what a step differed by: what its half does at most if nothing jumps
SMOOTH = 0.1  # of what a step may differ by: below, the next one is longer
LONGER = 8.0  # times as long, at most
NOISE = 1e2  # times the rounding of the energy: smaller differences count as zero
FINEST = 1e-6  # of the duration: steps that are not divided any more
NEARLY = 1.5  # times that: steps up to this are as short, since times are rounded
MOST_REMARKS = 8
# Equilibria that are lost, in each part of the duration: about five jumps are closed in on.
MOST_LOST, PARTS = 120, 20


class Attempt(NamedTuple):
    """The outcome of a step.

    Attributes:
        failure: Why there is no equilibrium at its end; None if there is one.
        remarks: On the equilibrium.
        found: The interruption there.
        seen: The energies there; None if there is no equilibrium.
        work, lost: Work in the step, and its part that energies lack [J].
    """

    failure: Unsettled | None = None
    remarks: tuple[Remark, ...] = ()
    found: Interruption | None = None
    seen: Look | None = None
    work: float = 0.0
    lost: float = 0.0


class Equilibria(QuasiStatic):
    """Steps one run; see the module."""

    name = EQUILIBRIUM
    solver = "Newton's method"
    _size = np.inf  # of the next step, at most [s]
    _usual = np.inf  # the same where no jump is closed in on
    _waits = False  # whether the next step is not longer than this one
    _ahead = np.inf  # when something happens that is closed in on [s]
    _scale = 0.0  # largest energy or work so far [J]
    _doubtful = -np.inf, 0.0  # end of the step halved last [s], and what it differed by [J]
    _before: Floats | None = None  # positions in the equilibrium before this one [m]
    _span = 0.0  # time between both [s]
    _seen: Look | None = None  # of this equilibrium
    _part = 0, 0  # number of the present part of the duration, and equilibria lost in it

    def restart(self, state: State) -> None:
        """Take over a state; see ``Engine.restart``."""
        super().restart(state)
        self._before, self._seen, self._ahead = None, None, np.inf
        self._doubtful = -np.inf, 0.0

    def finish(self, state: State) -> None:
        """Record the sample at the final time, in equilibrium after every event there."""
        if self._stale and self._go(state, state.time, None, None) is not None:
            self.remarks.append("there is no equilibrium after the events at the end")
        super().finish(state)

    def checkpoint(self) -> dict[str, Any]:
        """Return the numbers that ``restore`` continues from."""
        kept = {} if self._before is None else {"before": self._before}
        sizes = self._size, self._usual, float(self._waits)
        more = self._ahead, *self._doubtful, self._scale, self._span, *self._part
        path = np.array([*sizes, *more])
        return {**super().checkpoint(), **kept, "path": path}

    def restore(self, state: State, saved: Mapping[str, Any]) -> None:
        """Continue from a checkpoint."""
        super().restore(state, saved)
        path = map(float, saved["path"])
        self._size, self._usual, waits, self._ahead, end, differed, *rest = path
        self._doubtful, (self._scale, self._span, *part) = (end, differed), rest
        self._part = int(part[0]), int(part[1])
        self._waits, self._before = bool(waits), saved.get("before")

    @property
    def _finest(self) -> float:
        """Return the size of steps that are not divided any more [s]."""
        return FINEST * self.method.duration

    def _go(
        self, state: State, time: float, watch: Watch | None, pause: Pause | None
    ) -> Interruption | None:
        while True:
            target = self._target(state.time, time)
            found = self._step(state, target, watch)
            if found is not None or state.time >= time:
                return found
            if pause is not None and pause(state.time):
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
        before = self._seen or self._look(state)
        span = self._arrive(state, target)
        divides = span > NEARLY * self._finest
        guess = self._guess(position, span)
        attempt = self._try(state, before, guess, watch, patiently=not divides)
        allowed = self._allowed(state, attempt, before, span)
        jumps = attempt.seen is not None and abs(attempt.lost) > allowed
        jumps = jumps and not self._bends(target, abs(attempt.lost))
        is_lost = attempt.failure is not None or jumps
        if divides and (is_lost or attempt.found is not None):
            state.time = start
            state.place_held()
            state.position[:], state.velocity[:] = position, velocity
            self._rejected += 1
            self._seen = before
            if is_lost:
                if self._strays(start):
                    node = None if attempt.failure is None else attempt.failure.node
                    return Interruption("stuck", start, node=node, message=_often(state))
                self._size, self._waits = 0.5 * span, True
                self._doubtful = target, abs(attempt.lost)
            else:
                self._ahead = target
            return None
        if attempt.failure is not None:
            is_first = self._before is None
            message = attempt.failure.message if is_first else _limit(state)
            return Interruption("stuck", target, node=attempt.failure.node, message=message)
        self._count(span)
        lost = attempt.lost if jumps else 0.0
        self._book(attempt.work if jumps else attempt.work - attempt.lost, lost)
        if target >= self._ahead:
            self._ahead = np.inf
        if span > 0.0:
            self._note(state, attempt.remarks, lost)
            roughness = abs(attempt.lost) / (SMOOTH * allowed) if allowed else np.inf
            self._lengthen(span, roughness, jumped=jumps)
        self._before, self._span = None if jumps or not span else position, span
        self._seen = attempt.seen
        return attempt.found

    def _try(
        self,
        state: State,
        before: Look,
        guess: Floats | None,
        watch: Watch | None,
        *,
        patiently: bool,
    ) -> Attempt:
        """Bring a state to equilibrium.

        Args:
            before: The energies before the step.
            guess: Where the equilibrium may be [m], shape (node, 3).
            watch: Condition that interrupts.
            patiently: As for ``settle``.
        """
        self._evaluations += 1
        everything = np.ones(self.network.node_count, dtype=bool)
        try:
            remarks = settle(
                state, everything, guess, before=before.position, patiently=patiently
            )
        except Unsettled as failure:
            return Attempt(failure)
        seen = self._look(state)
        return Attempt(None, remarks, self._happens(state, watch), seen, *before.until(seen))

    def _allowed(self, state: State, attempt: Attempt, before: Look, span: float) -> float:
        """Return the allowed difference between work and change of energies in a step [J]."""
        sizes = abs(attempt.work), abs(self._work + attempt.work), abs(before.energy)
        self._scale = max(self._scale, *sizes)
        part = span / self.method.duration
        allowed = ALLOWED * max(self._scale * part, abs(attempt.work))
        if abs(attempt.lost) < SMOOTH * allowed:
            return allowed
        balance = Balance(state, state.free)
        _, rounding = balance.energy(balance.start, balance.bars(balance.start))
        return allowed + NOISE * rounding

    def _strays(self, time: float) -> bool:
        """Count an equilibrium lost after a time [s]; return whether that ends the run."""
        part = int(PARTS * time / self.method.duration)
        number, lost = self._part
        self._part = part, lost + 1 if part == number else 1
        return self._part[1] > MOST_LOST

    def _bends(self, target: float, lost: float) -> bool:
        """Return whether a step differs because forces begin to grow in it, and only little.

        Args:
            target: Its end [s].
            lost: What it differs by [J].
        """
        end, before = self._doubtful
        return target <= end and lost < min(FALLS * before, ALLOWED * self._scale)

    def _lengthen(self, span: float, roughness: float, *, jumped: bool) -> None:
        """Choose the largest size of the next step after one that is accepted [s].

        Args:
            roughness: What the step differed by, of what is smooth.
        """
        if jumped:
            self._size, self._waits = self._usual, False
        elif self._waits:
            self._waits = False
        elif roughness < 1.0:
            # What differs grows with the cube of the step, what may differ in proportion to it.
            longer = max(2.0, max(roughness, LONGER**-2) ** -0.5)
            self._size = self._usual = max(self._size, longer * span)

    def _guess(self, position: Floats, span: float) -> Floats | None:
        """Return the extrapolated path after a time, if it is known [m], shape (node, 3).

        Args:
            position: In the present equilibrium [m], shape (node, 3).
            span: Time from there on [s].
        """
        if self._before is None or span <= 0.0:
            return None
        return position + (span / self._span) * (position - self._before)

    def _note(self, state: State, remarks: Sequence[Remark], lost: float) -> None:
        """Add new remarks on an equilibrium, and on energy [J] lost in a jump to it."""
        first = f" (first at {show(state.time, TIME)})"
        said = [
            f"{remark.message}{remark.numbers}{first}"
            for remark in remarks
            if not any(one.startswith(remark.message) for one in self.remarks)
        ]
        if lost:
            said.append(
                f"at {show(state.time, TIME, digits=6)} the net snapped to another "
                f"equilibrium{under(state)}, because none was near the previous one; "
                f"{show(lost, ENERGY)} was dissipated"
            )
        self.remarks = [*self.remarks, *said][:MOST_REMARKS]


def _limit(state: State) -> str:
    """Return a sentence about a net that has lost its equilibrium."""
    return (
        f"there is no equilibrium near the previous one{under(state)}; prescribe a motion or a "
        "volume instead of a force or pressure, or use a dynamic method"
    )


def _often(state: State) -> str:
    """Return a sentence about a net whose equilibria jump again and again."""
    return (
        f"the path of equilibria was lost {MOST_LOST} times within "
        f"{100 / PARTS:g} % of the duration{under(state)}: the net folds or snaps again and "
        "again; end the run earlier, use smaller cells, or use a dynamic method"
    )


REASON = "the script asks for equilibrium"


class Phases:
    """Steps one run; the interface is that of ``Engine``.

    Args:
        first: Steps the run, or has stepped it so far.
        sample_times: When to record [s], ascending without repetitions, shape (sample,).
        record: Called with each batch of samples.
    """

    def __init__(self, first: Engine, sample_times: Floats, record: Callable[[Samples], None]):
        self._network, self._method, self._times = first.network, first.method, sample_times
        self._record, self._ledger = record, np.zeros(2)
        self._past: list[Statistics] = []
        self._begun = self._reach = 0.0
        self._remarks: list[str] = []
        self._now: Engine | Equilibria = first
        self._follow: Follow = first.follow

    @property
    def is_static(self) -> bool:
        """Return whether the present part of the run is static."""
        return isinstance(self._now, Equilibria)

    @property
    def remarks(self) -> list[str]:
        """Return remarks on the equilibria that were found, for the summary of the run."""
        return [*self._remarks, *self._now.remarks]

    @property
    def viewable(self) -> float:
        """Return the latest time of a state from ``look`` [s]; see ``Engine.viewable``."""
        return self._now.viewable

    @property
    def statistics(self) -> Statistics:
        """Return the cost of the run so far."""
        every = [*self._past, self._present]
        dynamic = [each for each in every if each.method != EQUILIBRIUM] or every
        used = [each for each in every if each.accepted] or every
        summed = ("accepted", "rejected", "evaluations", "factorisations", "solutions",
                  "stalls", "cost")  # fmt: skip
        return replace(
            dynamic[-1],
            smallest=min(each.smallest for each in used),
            largest=max(each.largest for each in used),
            changes=tuple(change for each in every for change in each.changes),
            **{name: sum(getattr(each, name) for each in every) for name in summed},
        )

    @property
    def _present(self) -> Statistics:
        """Return the statistics of the present part, with the time at which it began."""
        found = self._now.statistics
        first, *others = found.changes
        reason = REASON if self.is_static else first.reason
        first = MethodChange(self._begun, first.method, reason)
        return replace(found, reason=reason, changes=(first, *others))

    def restart(self, state: State) -> None:
        """Take over a state that was changed from outside; see ``Engine.restart``."""
        wanted = state.still_until > state.time
        if changes := wanted != self.is_static:
            self._leave()
            self._begun = state.time
            self._now = self._static(state) if wanted else self._dynamic()
        self._now.restart(state)
        if changes and isinstance(self._now, Engine):
            self._now.remember_motion(state.drawn, self._reach)

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
            pause: Returns whether to return between two steps.
            survey: As for ``Engine.advance``.
            view: Return "viewed" as soon as the state at this time [s] is known.
        """
        return self._now.advance(state, until, watch, pause, survey, view)

    def look(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return positions [m], velocities [m/s] and the ledger [J] of the whole run.

        The shapes are (node, 3) twice, and (2,); see ``Engine.look``.

        Args:
            time: The viewed time [s].
        """
        position, velocity, ledger = self._now.look(time)
        return position, velocity, ledger + self._ledger

    def take_over(self, state: State) -> None:
        """Continue to the end of a viewed step; see ``Engine.take_over``."""
        self._now.take_over(state)

    def finish(self, state: State) -> None:
        """Record the sample at the final time, after every event there."""
        self._now.finish(state)

    def sample(self, state: State) -> Samples:
        """Return the present state as a batch of one sample."""
        return self._of_whole_run(self._now.sample(state))

    def checkpoint(self) -> dict[str, Any] | None:
        """Return the data that ``restore`` continues from; None within a step."""
        inner = self._now.checkpoint()
        if inner is None:
            return None
        return {
            "inner": inner,
            "ledger": self._ledger + inner["ledger"],
            "before": self._ledger.copy(),
            "past": msgspec.json.encode(self._past).decode(),
            "begun": self._begun,
            "reach": self._reach,
            "remarks": list(self._remarks),
        }

    def restore(self, state: State, saved: Mapping[str, Any]) -> None:
        """Continue from a checkpoint and the state that belongs to it."""
        self._ledger = np.array(saved["before"])
        self._past = msgspec.json.decode(saved["past"], type=list[Statistics])
        self._begun, self._reach = float(saved["begun"]), float(saved["reach"])
        self._remarks = list(saved["remarks"])
        is_static = state.still_until > state.time
        self._now = self._static(state) if is_static else self._dynamic()
        self._now.restore(state, saved["inner"])

    def _leave(self) -> None:
        """Keep the results of the present part of the run, if it has begun."""
        if isinstance(self._now, Engine) and not self._now.has_begun:
            return
        saved = self._now.checkpoint()
        assert saved is not None, "parts of a run end between two steps"
        if isinstance(self._now, Engine):
            self._reach = max(self._reach, float(saved["displacement"]))
        self._past.append(self._present)
        self._ledger = self._ledger + saved["ledger"]
        self._remarks = self.remarks

    def _dynamic(self) -> Engine:
        found = Engine(self._network, self._method, self._times, self._take)
        found.follow = self._follow
        return found

    def _static(self, state: State) -> Equilibria:
        span = min(state.still_until, self._method.duration) - self._begun
        method = replace(
            self._method, name=EQUILIBRIUM, tolerance=None, step=span / LOAD_STEPS,
            duration=span, choices=None,
        )  # fmt: skip
        found = Equilibria(self._network, method, self._times, self._take)
        found.follow = self._follow
        found.skip_samples(self._begun)
        return found

    def _take(self, samples: Samples) -> None:
        """Pass samples on, and note how far nodes are from their first places."""
        moved = np.linalg.norm(self._network.moved(samples.position), axis=2)
        self._reach = max(self._reach, float(moved.max(initial=0.0)))
        self._record(self._of_whole_run(samples))

    def _of_whole_run(self, samples: Samples) -> Samples:
        """Return samples of the present part with the ledger of the whole run."""
        work, lost = self._ledger
        return samples._replace(work=samples.work + work, dissipated=samples.dissipated + lost)
