"""Where a run starts: the situation behind the orders of 0 s."""

from tissuec.bench.frames import Frames
from tissuec.bench.problem import Problem
from tissuec.engine.execution.actions import Stage
from tissuec.engine.execution.run_state import Standing
from tissuec.mechanics.situation import Situation


def situation_at_start(problem: Problem) -> Situation:
    """Return the situation after the events of 0 s."""
    frames = Frames(problem)
    standing = Standing.begin(problem.network, problem.plan, frames.memory)
    Stage(problem.network, problem.plan, frames, standing).begin()
    return standing.situation
