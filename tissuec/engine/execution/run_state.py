"""The state of a run: everything beside network and plan that is needed to resume it."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from msgspec import Struct, field
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec.engine.execution.checkpoint import read_state, write_state
from tissuec.engine.execution.event_queue import ActionQueue
from tissuec.engine.execution.expectations import ExpectationMemory
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.script.plan import Plan
from tissuec.script.verbs import LoggedEvent


class RunState(Struct, eq=False):
    """A run between two of its steps.

    Attributes:
        queue: What is still to come.
        waiting: Triggers that have not fired, by their places in the plan.
        ruptured: Which springs broke by themselves, shape (spring,).
        memory: What the recorder must know.
        initial, switched: Of the energy ledger [J].
        logged_events: The event log so far, each entry with its time [s].
        looks: How often the net was examined for an unstable equilibrium that it rests in.
        engine: What the engine keeps; set for a checkpoint only.
    """

    state: State
    queue: ActionQueue
    waiting: list[int]
    ruptured: NDArray[np.bool_]
    memory: ExpectationMemory
    initial: float = 0.0
    switched: float = 0.0
    logged_events: list[tuple[float, LoggedEvent]] = field(
        default_factory=list[tuple[float, LoggedEvent]]
    )
    looks: int = 0
    engine: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @classmethod
    def begin(cls, network: Network, plan: Plan, memory: ExpectationMemory) -> Self:
        """Return the state of a run at 0 s, before the events of that time.

        Args:
            network: The network.
            plan: The plan.
            memory: The state of the recorder.
        """
        return cls(
            plan.start(network),
            ActionQueue.of(plan),
            list(range(len(plan.triggers))),
            np.zeros(network.spring_count, dtype=bool),
            memory,
        )

    def write(self, network: Network, plan: Plan) -> dict[str, Any]:
        """Return this as text and arrays for a file."""
        return write_state(self, _known(network, plan))


def read_run_state(saved: Mapping[str, Any], network: Network, plan: Plan) -> RunState:
    """Return the state that :meth:`RunState.write` wrote for the same network and plan.

    Args:
        saved: The text and arrays.
        network: The network.
        plan: The plan.

    Raises:
        ValueError: The state is not the checkpoint of a run.
    """
    run_state = read_state(saved, _known(network, plan))
    if not isinstance(run_state, RunState):
        raise ValueError("this is not the checkpoint of a run")
    return run_state


def _known(network: Network, plan: Plan) -> list[object]:
    """Return the arrays that a checkpoint need not contain, always in the same order."""
    arrays: list[object] = [*astuple(network), *astuple(network.springs)]
    actions = [event.action for event in plan.every_event]
    spans = [action.span for action in actions] + [trigger.span for trigger in plan.triggers]
    blocks = [*network.blocks, *(block.field for block in network.blocks)]
    memory = network.springs.inelastic
    springs = [network.springs, *([] if memory is None else [memory])]
    spans += [block.span for block in network.blocks if block.span is not None]
    spans += [plan.simulation.span, *(part.span for part in network.parts)]
    spans += [origin.span for part in network.provenance.values() for origin in part.origins]
    sources = {id(span.source): span.source for span in spans}.values()
    arrays = [array for array in arrays if isinstance(array, np.ndarray)]
    return [network, *arrays, *actions, *blocks, *springs, *sources]
