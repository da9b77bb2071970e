"""The engine as a solver: the run of a plan with frames in memory only."""

import time as clock
from dataclasses import dataclass, field

from tissuec.bench.frames import Frames
from tissuec.bench.problem import Problem
from tissuec.bench.trial import Deadline, Failed, OutOfTime, Trial
from tissuec.engine.method import Tier
from tissuec.engine.tiers import forced_tier
from tissuec.running.run import run

AUTOMATIC = "automatic"


@dataclass(frozen=True, slots=True, eq=False)
class EngineSolver:
    """A method of the engine, or its own choice.

    Attributes:
        method: "automatic" or a member of ``INTEGRATORS``.
        tier: None lets the engine choose.
    """

    problem: Problem
    method: str
    tier: Tier | None = field(default_factory=lambda: forced_tier() or "compiled")
    ours: bool = True

    @property
    def name(self) -> str:
        return self.method

    def solve(self, tolerance: float, deadline: Deadline) -> Trial:
        """Return a run at a tolerance; see ``Solver``."""
        problem, frames = self.problem, Frames(self.problem)
        started = clock.process_time()
        outcome = run(
            problem.network,
            problem.by(self.method, tolerance),
            frames,
            interrupt=lambda: deadline.is_over,
            tier=self.tier,
        )
        seconds, statistics = clock.process_time() - started, outcome.statistics
        if outcome.kind == "interrupted":
            raise OutOfTime("the budget of time was used up")
        if outcome.kind != "done":
            raise Failed(outcome.message)
        if self.method not in (AUTOMATIC, statistics.method):
            raise Failed(f"{statistics.method} took over: {statistics.reason}")
        return Trial(seconds, statistics.evaluations, frames.position)
