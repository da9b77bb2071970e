"""The state of a run: what is needed to resume it, and how it is stored.

Structs of this package and of plug-ins, tuples, lists, dictionaries, numbers, texts and arrays
are written out; what network and plan hold anyway (``known``) is only referred to. Numbers come
back to the last bit. Reading makes nothing but such values: a file cannot run anything.
"""

import json
from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Any, Self, cast

import numpy as np
from msgspec import Struct, field
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec.core.plugins import packages
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
        ruptured: Which entities broke by themselves, shape (entity,).
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
            memory: The state of the recorder.
        """
        return cls(
            plan.start(network),
            ActionQueue.of(plan),
            list(range(len(plan.triggers))),
            np.zeros(network.entity_count, dtype=bool),
            memory,
        )

    def write(self, network: Network, plan: Plan) -> dict[str, Any]:
        """Return this as text and arrays for a file."""
        return write_state(self, _known(network, plan))


def read_run_state(saved: Mapping[str, Any], network: Network, plan: Plan) -> RunState:
    """Return the state that :meth:`RunState.write` wrote for the same network and plan.

    Args:
        saved: The text and arrays.

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


TEXT = "text"


def write_state(value: object, known: Iterable[object]) -> dict[str, str | NDArray[Any]]:
    """Return a value as one text and numbered arrays of any shape, in their own units.

    Args:
        value: Made of what the module names, at any depth.
        known: Objects that are referred to by their place in this sequence.

    Raises:
        TypeError: The value contains something else.
    """
    places = {id(item): place for place, item in enumerate(known)}
    arrays: list[NDArray[Any]] = []

    def plain(value: Any) -> Any:
        if id(value) in places:
            return {"known": places[id(value)]}
        match value:
            case None | bool() | str():
                return value
            case np.generic():
                number = cast("np.generic[Any]", value)
                return number.item()
            case int() | float():
                return value
            case np.ndarray():
                arrays.append(cast("NDArray[Any]", value))
                return {"array": len(arrays) - 1}
            case tuple():
                items = cast("tuple[Any, ...]", value)
                return {"tuple": [plain(item) for item in items]}
            case list():
                listed = cast("list[Any]", value)
                return [plain(item) for item in listed]
            case Mapping():
                named = cast("Mapping[Any, Any]", value)
                return {"pairs": [[plain(key), plain(item)] for key, item in named.items()]}
            case _:
                return _plain_record(value)

    def _plain_record(value: object) -> Any:
        kind = type(value)
        if not isinstance(value, Struct) or kind.__module__.partition(".")[0] not in packages():
            raise TypeError(f"a checkpoint cannot hold {kind.__module__}.{kind.__qualname__}")
        content = {name: plain(getattr(value, name)) for name in value.__struct_fields__}
        return {"record": f"{kind.__module__}:{kind.__qualname__}", "fields": content}

    text = json.dumps(plain(value))
    return {TEXT: text} | {f"array {number}": array for number, array in enumerate(arrays)}


def read_state(state: Mapping[str, Any], known: Iterable[object]) -> Any:
    """Return the value that :func:`write_state` was given, with the same ``known`` objects.

    Raises:
        ValueError: The text is not one that was written there.
    """
    places = list(known)

    def value(data: Any) -> Any:
        match data:
            case list():
                listed = cast("list[Any]", data)
                return [value(item) for item in listed]
            case {"known": place}:
                return places[place]
            case {"array": number}:
                return np.array(state[f"array {number}"])
            case {"tuple": items}:
                return tuple(value(item) for item in items)
            case {"pairs": pairs}:
                return {value(key): value(item) for key, item in pairs}
            case {"record": name, "fields": content}:
                return _record_class(name)(
                    **{key: value(item) for key, item in content.items()}
                )
            case dict():
                raise ValueError("this is not the checkpoint of a run")
            case _:
                return data

    return value(json.loads(state[TEXT]))


def _record_class(name: str) -> Any:
    """Return a class of this package, or of a plug-in, by ``module:name``."""
    module, _, qualified = name.partition(":")
    if module.partition(".")[0] not in packages():
        raise ValueError(f'"{name}" is not a record of tissuec or a plug-in')
    found = getattr(import_module(module), qualified, None)
    if not isinstance(found, type) or not issubclass(found, Struct):
        raise ValueError(f'"{name}" is not a record of tissuec or a plug-in')
    return found
