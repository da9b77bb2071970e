"""Runs that are static for some intervals, and dynamic before and after them.

While a state is to be in equilibrium (``State.still_until``), it goes from one to the
next (``engine.equilibria``); a new engine continues from the last one, whose free nodes have no
velocity. The ledger is that of the whole run.
"""

from collections.abc import Callable, Mapping
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import replace

from tissuec.engine.engine import Engine
from tissuec.engine.equilibria import Equilibria
from tissuec.engine.method import Follow, Interruption, MethodChange, Pause, Samples, Statistics
from tissuec.engine.step_events import Survey, Watch
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.script.plan import EQUILIBRIUM, LOAD_STEPS

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
            self._now.remember_motion(self._network.position, self._reach)

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
        """Pass samples on, with the ledger of the whole run."""
        moved = np.linalg.norm(samples.position - self._network.position, axis=2)
        self._reach = max(self._reach, float(moved.max(initial=0.0)))
        work, lost = self._ledger
        self._record(
            samples._replace(work=samples.work + work, dissipated=samples.dissipated + lost)
        )
