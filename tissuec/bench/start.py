"""The state at the start of a run, after the orders of 0 s."""

from tissuec.bench.frames import PositionRecorder
from tissuec.bench.problem import BenchProblem
from tissuec.engine.execution.event_handler import EventHandler
from tissuec.engine.execution.run_state import RunState
from tissuec.mechanics.state import State


def state_at_start(problem: BenchProblem) -> State:
    """Return the state after the events of 0 s."""
    frames = PositionRecorder(problem)
    run_state = RunState.begin(problem.network, problem.plan, frames.memory)
    EventHandler(problem.network, problem.plan, frames, run_state).begin()
    return run_state.state
