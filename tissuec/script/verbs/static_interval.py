"""``from … to …: settle``: an interval in which the whole scene is static."""

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.script.verbs import ActionFailed, EventQueue, LoggedEvent
from tissuec.script.verbs.holding import sentence


class EndStaticInterval(Struct, frozen=True):
    """The end of the interval; the scene moves again from its last equilibrium."""

    stop: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if state.still_until != self.stop:
            return ()  # another interval lasts longer
        state.still_until = -np.inf
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


class StaticInterval(Struct, frozen=True):
    """The start of an interval in which the engine goes from one equilibrium to the next."""

    duration: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Begin the interval.

        Raises:
            ActionFailed: The net relaxes or yields, which takes time.
        """
        text = sentence(self.span)
        if state.network.relaxes:
            message = f"{text}: what relaxes or yields cannot settle over an interval"
            raise ActionFailed(message, None, self.span)
        state.velocity[~state.held] = 0.0
        stop = state.time + self.duration
        state.still_until = max(state.still_until, stop)
        queue.add(stop, EndStaticInterval(stop, self.span))
        return (LoggedEvent("settle", (), text, self.span),)
