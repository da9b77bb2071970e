"""Runs that are stepped by somebody who looks and acts in between.

Looking changes nothing: states are evaluated inside the steps that the run makes anyway. An
action changes where steps end, from the last scheduled event before it on, as a run that knows
of it from the start would have it: the run goes back to that event and comes again. So a motion
is that of the same actions written into the script, to the last bit.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from copy import copy
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core.signals import Halted, asked_to_stop, interruption
from tissuec.core.structs import replace
from tissuec.engine.execution.event_queue import SAME
from tissuec.engine.execution.memory_recorder import MemoryRecording, RecordedRows
from tissuec.engine.execution.recorder import Part, Recorder, RecorderState
from tissuec.engine.execution.run import Kind, RunLoop
from tissuec.model.network import Floats, Network
from tissuec.results.recording import Event
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs import may_break

DIGITS = 12  # of times at which somebody looks or acts


def rounded(time: float) -> float:
    """Return a time [s] as it is written, so that sums of steps are times in a text."""
    return float(f"{time:.{DIGITS}g}")


class RestorePoint(Struct, frozen=True, eq=False):
    """The state from which a run continues; it can be pickled.

    Attributes:
        time: [s].
        state: As of a checkpoint in a file; None before the events of 0 s.
        actions: How many of the orders it knows of.
        recorder: What the recorder knew.
        rows: What was recorded.
    """

    time: float
    state: Mapping[str, Any] | None
    actions: int = 0
    recorder: RecorderState | None = None
    rows: RecordedRows | None = None


class SavedRun(Struct, frozen=True, eq=False):
    """A run between two looks; it can be pickled.

    Attributes:
        time: At which it is observed [s].
        actions: What was ordered, with the times.
        bases: Where the run can go back to; the last one is after the last scheduled event.
        ahead: The end of the step in which the time lies; None where events interrupt it.
        looked: Positions [m] and velocities [m/s], shape (node, 3) each, and the ledger [J],
            shape (2,), at the time; None where the state itself is at that time.
        ending: How the run ended, if it has.
    """

    time: float
    actions: tuple[ScheduledAction, ...]
    bases: tuple[RestorePoint, ...]
    ahead: RestorePoint | None
    looked: tuple[Floats, Floats, Floats] | None
    ending: tuple[Kind, str] | None


class StepwiseRun:
    """A run under way.

    Args:
        network, plan: Of the run; trajectories and surfaces are not recorded.
        threads: See ``Method``.
        saved: Where it begins; at 0 s by default.

    Attributes:
        time: At which the run is observed [s].
        actions: What was ordered so far, in this order.
    """

    def __init__(
        self, network: Network, plan: Plan, *, threads: int = 1, saved: SavedRun | None = None
    ):
        self.network, self._plan, self._threads = network, plan, threads
        self._near = SAME * plan.simulation.duration
        self._new: list[ScheduledAction] = []
        self._is_torn = False  # whether a step or an event was left in its middle
        self._start()
        if saved is None:
            self.time, self.actions = 0.0, list[ScheduledAction]()
            self._bases = [RestorePoint(0.0, None)]
            self._looked: tuple[Floats, Floats, Floats] | None = None
            self._loop.begin()
            self._keep()
        else:
            self.restore(saved)

    @property
    def ending(self) -> tuple[Kind, str] | None:
        """Return how the run ended by the present time, and a sentence about it."""
        self._carry_out()
        return self._loop.ending if self._looked is None else None

    @property
    def snapshot(self) -> Snapshot:
        """Return the net at the present time, with energies if they are kept."""
        self._carry_out()
        handler = self._loop.handler
        if self._looked is None:
            snapshot, sums = handler.snapshot(), self._loop.sums()
        else:
            x, v, sums = self._looked
            snapshot = handler.snapshot_at(self.time, x, v)
        return self._recorder.scaled(handler.with_ledger(snapshot, *map(float, sums)))

    @property
    def events(self) -> tuple[Event, ...]:
        """Return the events so far."""
        self._carry_out()
        return tuple(self._recording.events)

    def rows(self, log: str) -> tuple[Floats, Floats]:
        """Return times [s], shape (row,), and rows of a log up to now, shape (row, column).

        Raises:
            KeyError: The scene has no such log.
        """
        self._carry_out()
        if self._looked is not None:
            self._loop.engine.take_over(self._loop.run_state.state)
        times, rows = self._recording.log_arrays(log)
        count = int(np.searchsorted(times, self.time, side="right"))
        return times[:count], rows[:count]

    def step_to(self, time: float) -> None:
        """Step to a time, or to the end of the run if that comes first.

        Args:
            time: [s], not before the present one.

        Raises:
            ValueError: The time is before the present one.
            KeyboardInterrupt: A signal arrived; the run can continue from where it is.
        """
        if time < self.time:
            raise ValueError(f"cannot step back from {self.time:g} s to {time:g} s")
        self._carry_out()
        self._advance(min(time, self._plan.simulation.duration))

    @property
    def order_time(self) -> float:
        """Return the time of what is ordered now [s]: the present one, or what it is meant for.

        What comes within rounding of something that happens anyway, happens with it.
        """
        coming = self._loop.run_state.queue.next
        return coming if abs(coming - self.time) <= self._near else self.time

    def order(self, actions: Sequence[ScheduledAction]) -> None:
        """Let actions happen, now or later; they are carried out when somebody looks.

        Args:
            actions: In the order in which they are written; times are not before
                ``order_time``.
        """
        self._new += actions

    def save(self) -> SavedRun:
        """Return the present state, to which this or another run can be restored."""
        self._carry_out()
        loop, ahead = self._loop, None
        if self._looked is not None:
            loop.engine.take_over(loop.run_state.state)
            ahead = self._checkpoint() if loop.engine.checkpoint() is not None else None
        return SavedRun(
            self.time, tuple(self.actions), tuple(self._bases), ahead, self._looked, self.ending
        )

    def restore(self, saved: SavedRun) -> None:
        """Go back, or over, to a saved state of a run of the same network and plan."""
        self._new.clear()
        self._watch_strength(saved.actions)
        self.actions = list(saved.actions)
        self._bases = list(saved.bases)
        self._go_back(saved.ahead or saved.bases[-1])
        self.time, self._looked = saved.time, saved.looked
        if saved.ahead is None:
            self._advance(saved.time)

    # --- continuing ---------------------------------------------------------------------------

    def _advance(self, time: float) -> None:
        """Step to a time [s] with what was ordered so far."""
        loop = self._loop
        if self._is_torn or loop.run_state.state.time > max(time, loop.engine.viewable):
            self._is_torn = False
            self._go_back(self._bases[-1])  # restored at the end of a step that is not known
            loop = self._loop
        with asked_to_stop() as stop, suppress(Halted):
            self._is_torn = True
            while loop.ending is None and loop.run_state.state.time != time:
                reason = loop.advance(lambda now: stop(), view=time)
                if reason.kind == "viewed":
                    self.time, self._looked = time, loop.engine.look(time)
                    self._is_torn = False
                    return
                if reason.kind == "paused":
                    break
                loop.handle(reason)
                if reason.kind == "reached":  # other times depend on what is ordered later
                    self._keep()
            self._is_torn = False
        self.time, self._looked = loop.run_state.state.time, None
        if stop.answered:
            raise interruption(stop.signal)

    def _keep(self) -> None:
        """Keep the state after scheduled events, at which the run was whatever comes later."""
        if self._loop.ending is None:
            self._bases.append(self._checkpoint())
            while len(self._bases) > 2 and self._bases[1].time < self._bases[-1].time:
                del self._bases[0]

    def _checkpoint(self) -> RestorePoint:
        parts: Mapping[str, Any] = self._loop.checkpoint()
        saved = {name: copy(value) for name, value in parts.items()}
        time = self._loop.run_state.state.time
        known = len(self.actions)
        return RestorePoint(time, saved, known, self._recorder.state(), self._recording.rows())

    # --- going back ---------------------------------------------------------------------------

    def _start(self) -> None:
        """Make a new loop, recorder and recording."""
        self._recording = MemoryRecording()
        self._recorder = _Unframed(self.network, self._plan, self._recording)
        self._loop = RunLoop(self.network, self._plan, self._recorder, self._threads)

    def _watch_strength(self, actions: Sequence[ScheduledAction]) -> None:
        """Have springs looked after that may break because of actions."""
        if not self._plan.breakable and any(
            may_break(one.action, self.network) for one in actions
        ):
            self._plan = replace(self._plan, breakable=True)
            self._start()

    def _go_back(self, base: RestorePoint) -> None:
        """Go to a checkpoint, and forget what was recorded since."""
        self._looked = None
        self._loop.ending = None
        if base.state is None or base.recorder is None or base.rows is None:
            self._start()
            self._loop.begin(self.actions)
            self._keep()
            return
        self._recording.bring_back(base.rows)
        self._loop.resume(base.state)
        self._recorder.bring_back(base.recorder)
        self._loop.run_state.queue.write(self.actions[base.actions :])

    def _carry_out(self) -> None:
        """Carry out what was ordered at the present time, in a motion that knows of it."""
        if not self._new:
            return
        now, new = self.order_time, list(self._new)
        self._new.clear()
        self._watch_strength(new)
        self.actions += new
        while self._bases[-1].state is not None and self._bases[-1].time >= now - self._near:
            self._bases.pop()
        self._go_back(self._bases[-1])
        self._advance(now)


class _Unframed(Recorder):
    """A recorder without trajectory and surfaces, at the same times."""

    def write_frames(self, part: Part) -> None:
        """Write nothing, ``part`` being what there is."""

    def write_surfaces(self, part: Part) -> None:
        """Write nothing, ``part`` being what there is."""
