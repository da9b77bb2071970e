"""Sentences about failed runs, with springs, nodes, time and line."""

from typing import TYPE_CHECKING

from tissuec.core.units import MASS, STIFFNESS, TIME, show
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.results.recording import body_of
from tissuec.script.verbs import ActionFailed

if TYPE_CHECKING:
    from tissuec.engine.method import Interruption


def explain(failure: "Interruption", state: State) -> str:
    """Return a message: what went wrong, where and when.

    Args:
        failure: With the culprit's number in the network, if there is one.
        state: The last good state.
    """
    verb = "diverged" if failure.kind == "diverged" else "stopped"
    parts = [f"the run {verb} at {show(failure.time, TIME, digits=6)}"]
    if failure.message:
        parts.append(failure.message)
    if failure.spring is not None:
        parts.append(describe_spring(state, failure.spring))
    elif failure.node is not None:
        parts.append(describe_node(state, failure.node))
    return "; ".join(parts)


def explain_action(failure: ActionFailed, state: State, torn: str = "") -> str:
    """Return which order could not be carried out, where, when and why.

    Args:
        failure: The order.
        state: At that time.
        torn: What broke the springs of the failure before, beginning with a semicolon.
    """
    time = show(state.time, TIME, digits=6)
    parts = [
        f"the run stopped at {time}",
        f"{failure.message}{torn}",
        *([] if failure.node is None else [describe_node(state, failure.node)]),
        f"requested in {failure.span.place}",
    ]
    return "; ".join(parts)


def describe_spring(state: State, spring: int) -> str:
    """Return a spring by the author's numbers, with its constant and where that is from."""
    network = state.network
    first, second = (
        _named(network, int(node), spring) for node in network.springs.ends[spring]
    )
    constant = show(float(state.springs.stiffness[spring]), STIFFNESS)
    return (
        f"spring {network.springs.ids[spring]} of {network.owner(spring).name} between "
        f"the nodes {first} and {second}, with a spring constant of {constant}"
        f"{_origin(network, 'stiffness', spring)}"
    )


def _named(network: Network, node: int, spring: int) -> str:
    """Return the end of a spring by its number, with its body where the spring has none."""
    is_joint = spring >= network.body_springs
    return f"{network.node_ids[node]}{of_body(network, node) if is_joint else ''}"


def describe_node(state: State, node: int) -> str:
    """Return a node by the author's number, with its mass and where that is from."""
    network = state.network
    mass = show(float(state.mass[node]), MASS)
    return (
        f"node {network.node_ids[node]}{of_body(network, node)}, "
        f"with a mass of {mass}"
        f"{_origin(network, 'mass', node)}"
    )


def of_body(network: Network, node: int) -> str:
    """Return " of BODY" for a node, nothing for one of a tool."""
    name = body_of(network, node)
    return f" of {name}" if name else ""


def _origin(network: Network, array: str, entry: int) -> str:
    found = network.provenance.get(array)
    return f" ({found[entry].span.place})" if found is not None else ""
