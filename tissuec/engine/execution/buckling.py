"""Detects a net that rests in an unstable equilibrium because of symmetry."""

from tissuec.core.source import Span
from tissuec.engine.execution.failure_messages import of_body
from tissuec.engine.execution.run_state import RunState
from tissuec.mechanics.rest import is_stable, rests_pressed
from tissuec.script.verbs import LoggedEvent

MOST_LOOKS = 8  # in a run: each may factorise a matrix


def unstable_rest(run_state: RunState, span: Span) -> LoggedEvent | None:
    """Return a note for the event log if the net rests at an unstable equilibrium now.

    After the first such note, or ``MOST_LOOKS`` looks, nothing is looked for.

    Args:
        span: Of the note.
    """
    if run_state.looks >= MOST_LOOKS or not rests_pressed(run_state.state):
        return None
    run_state.looks += 1
    if is_stable(run_state.state):
        return None
    from tissuec.mechanics import stability  # SciPy: only where it is needed

    node = stability.unstable_node(run_state.state)
    if node is None:
        return None
    run_state.looks = MOST_LOOKS
    network = run_state.state.network
    where = f"node {network.node_ids[node]}{of_body(network, node)}"
    text = (
        "the net is at rest in an unstable equilibrium: any disturbance makes it buckle, "
        f"mainly at {where}; `settle` finds the buckled shape"
    )
    return LoggedEvent("note", (), text, span)
