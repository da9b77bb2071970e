"""Detects threads that have passed into a body in spite of contact."""

from collections.abc import Iterator

from tissuec.engine.execution.run_state import RunState
from tissuec.geometry.intersections import crossings
from tissuec.geometry.nearest import TRIANGLE
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats
from tissuec.script.verbs import LoggedEvent


def crossed_surfaces(run_state: RunState) -> Iterator[LoggedEvent]:
    """Yield a note for each thread and each body whose surface it goes through, once a run.

    A thread that a joint sews to a body goes into it on purpose.
    """
    state, network = run_state.state, run_state.state.network
    threads = [body for body in network.bodies if body.thread is not None]
    if state.contact is None or not threads:
        return
    told = {logged_event.cause for _, logged_event in run_state.logged_events}
    for body in network.bodies:
        if body.thread is not None:
            continue
        surface = _surface(state, body)
        for thread in threads:
            text = (
                f"{thread.name} passes through the surface of {body.name}: contact cannot "
                "hold it back there; use more pieces, or a larger thickness or contact "
                "stiffness"
            )
            if text in told or network.are_joined(thread, body):
                continue
            if len(crossings(_pieces(state, thread), surface)):
                yield LoggedEvent("note", (), text, thread.span)


def _pieces(state: State, thread: BodyPart) -> Floats:
    """Return the ends of the pieces that are whole [m], shape (piece, 2, 3)."""
    assert thread.thread is not None
    pieces = thread.thread.pieces
    ends = state.network.ends[pieces][state.alive[pieces]]
    return state.position[ends]


def _surface(state: State, body: BodyPart) -> Floats:
    """Return the corners of the triangles that touch [m], shape (triangle, 3, 3)."""
    contact = state.touching
    assert contact is not None
    is_face = contact.kind[: len(contact.radius)] == TRIANGLE
    if contact.whole is not None:
        is_face &= contact.whole
    corners = contact.points[: len(is_face)][is_face]
    first = corners[:, 0]
    return state.position[corners[(first >= body.nodes.start) & (first < body.nodes.stop)]]
