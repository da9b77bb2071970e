"""Relative motion of jaws."""

import re
from collections.abc import Iterator

import numpy as np

from tissuec.core import units
from tissuec.core.errors import Edit, Hint
from tissuec.core.source import Span
from tissuec.forces.load import LoadTerm
from tissuec.mechanics.state import State
from tissuec.model.network import Indices, Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import ActionFailed, EventQueue, LoggedEvent, Mover, Order
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import EndMotion, schedule, set_off
from tissuec.script.verbs.move import refuse_jump

JAWS = ("upper jaw", "lower jaw")


def read_jaws(order: Order) -> tuple[str, float, TimeProfile]:
    """Return the forceps named behind the verb, how far they go [m], and the profile."""
    tool, way = order.mover().name, order.number("by", units.LENGTH)
    if way <= 0.0:
        hint = Hint(
            "for the opposite direction, write close instead of open, or open instead of close",
            *_turned_round(order),
        )
        order.reject(
            "TIS308", "the length of a motion of jaws must be above 0", hint=hint, word="by"
        )
    profiles = order.profiles(default="")
    refuse_jump(order, profiles)
    return tool, way, profiles[0]


def _turned_round(order: Order) -> list[Edit]:
    """Return the edit that writes the other verb and a length above 0, if one is negative."""
    verb, _, rest = order.span.text.partition(" ")
    other = {"open": "close", "close": "open"}.get(verb.lower())
    way, count = re.subn(r"\bby\s*-\s*(?=[0-9])", "by ", rest)
    return [Edit(f"{other} {way}", order.span)] if other and count == 1 else []


def flaw_of_jaws(network: Network, tool: str) -> str:
    """Return why a tool has no jaws, empty if it has."""
    if jaws_of(network, tool) is not None:
        return ""
    return f"{tool} has no jaws: it needs radius, upper and lower"


def jaws_of(network: Network, tool: str) -> tuple[Indices, Indices] | None:
    """Return the nodes of both jaws of forceps, shape (n,) each; None for any other tool."""
    return next((part.jaws for part in network.tools if part.name == tool), None)


def drive_jaws(
    state: State,
    queue: EventQueue,
    tool: str,
    way: float,
    profile: TimeProfile,
    duration: float | None,
    span: Span,
) -> Iterator[LoggedEvent]:
    """Move both jaws by half of a distance each, and yield the event.

    Args:
        state: Changed in place.
        queue: Takes the end of the motion.
        tool: Name of the forceps.
        way: Distance [m]; apart if positive.
        profile: Course of the motion.
        duration: Of the order [s]; None if it ends with the profile.
        span: The sentence.

    Raises:
        ActionFailed: The forceps are moving as a whole.
    """
    if tool in state.motions:
        node = int(state.motions[tool].nodes[0])
        raise ActionFailed(f"{tool} cannot open or close while it is moved", node, span)
    jaws = jaws_of(state.network, tool)
    assert jaws is not None, "told before the run"
    upper, lower = (state.position[jaw].mean(axis=0) for jaw in jaws)
    apart = (upper - lower) / np.linalg.norm(upper - lower)
    begun, stop = schedule(queue, (profile,), state.time, duration)
    for name, jaw, sign in zip(JAWS, jaws, (0.5, -0.5), strict=True):
        mover = Mover(f"{tool} {name}", jaw)
        set_off(state, mover, span, shifts=(LoadTerm(sign * way * apart, begun[0]),))
        if np.isfinite(stop):
            queue.add(stop, EndMotion(mover.name, stop, span))
    yield LoggedEvent(span.text.split()[0].lower(), (), sentence(span), span)
