"""The state after the events of the script at 0 s."""

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import SimulationError
from tissuec.engine.execution.failure_messages import explain_action
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.script.verbs import Action, ActionFailed, LoggedEvent
from tissuec.script.verbs.settle import Settle


def state_at_start(compiled: Compiled, *, settles: bool = False) -> State:
    """Return the state after the events of the script at 0 s.

    Args:
        settles: Whether bodies under "settle" do so; otherwise they stay as drawn.

    Raises:
        SimulationError: It ``settles``, and a run would end here.
    """
    plan = compiled.plan
    state = plan.start(compiled.network)
    for event in plan.events:
        if event.time > 0.0 or (isinstance(event.action, Settle) and not settles):
            continue
        try:
            event.action.apply(state, _InitialQueue())
        except ActionFailed as failure:  # a run reports it in its own words
            if settles:
                raise SimulationError(explain_action(failure, state)) from failure
    return state


class _InitialQueue:
    """A queue for the events at 0 s only."""

    def add(self, time: float, action: Action) -> None:
        pass

    def land(self, times: Floats) -> None:
        pass

    def end(self, ended: LoggedEvent) -> None:
        pass
