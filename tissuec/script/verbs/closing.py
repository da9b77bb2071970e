"""Blades that close along their edge, and the events of cuts."""

from typing import Protocol

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import ENERGY, show, show_in
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import EventQueue, LoggedEvent
from tissuec.script.verbs.cut_surface import ON_PLANE, Blade, CutSurface
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule


class GradualCut(Protocol):
    """A cut that can proceed along the edge of its blade."""

    @property
    def blade(self) -> Blade | None: ...

    @property
    def duration(self) -> float | None:
        """Return how long blades close [s]; None where it is not given."""
        ...

    @property
    def span(self) -> Span: ...

    @property
    def tool(self) -> str: ...

    def until(self, state: State, share: float) -> tuple[LoggedEvent, ...]:
        """Cut what lies up to a share of the edge.

        Raises:
            ActionFailed: It cannot be done; the state is as it was.
        """
        ...


class ClosingBlades(Struct, frozen=True, eq=False):
    """Blades that have closed up to some place of their edge.

    Attributes:
        cut: What they cut.
        profile: Of their way, from 0 to 1.
        stop: When they are closed [s].
    """

    cut: GradualCut
    profile: TimeProfile
    stop: float

    @property
    def span(self) -> Span:
        """Return the sentence."""
        return self.cut.span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Cut what they have reached."""
        is_closed = state.time >= self.stop
        share = 1.0 if is_closed else self.profile.at(state.time)[0]
        events = self.cut.until(state, share + ON_PLANE)
        if is_closed:
            state.closing = tuple(one for one in state.closing if one.profile.stop > self.stop)
        return events


def begin_closing(
    cut: GradualCut,
    profile: TimeProfile,
    shares: Floats,
    surface: CutSurface | None,
    state: State,
    queue: EventQueue,
) -> LoggedEvent:
    """Let the blades of a cut close from now on, and return the event of their start.

    Args:
        profile: Of their way, written to begin at 0 s.
        shares: Of the edge, 0 to 1, where there is something to cut, dimensionless, shape (n,).
        surface: Of what resists; None if nothing does.
        state: Changed in place.
        queue: Takes the times at which they reach the shares [s].
    """
    (begun,), stop = schedule(queue, (profile,), state.time, cut.duration)
    if surface is not None and cut.blade is not None:
        state.closing = (*state.closing, surface.force(cut.tool, cut.blade, begun))
    every = np.unique(np.append(shares, 1.0))
    times = np.unique([when(begun, share, state.time, stop) for share in every])
    for time in times.tolist():
        queue.add(time, ClosingBlades(cut, begun, stop))
    return LoggedEvent("stroke", (), f"start of: {sentence(cut.span)}", cut.span)


def cut_event(span: Span, entities: Indices, area: float, energy: float) -> LoggedEvent:
    """Return the event of a cut, with its area and energy if it takes any.

    Args:
        entities: What is cut, shape (n,).
        area: As drawn [m²].
        energy: [J].
    """
    text = sentence(span)
    if energy > 0.0:
        text = f"{text} ({show_in(area, 'mm^2')}, {show(energy, ENERGY)})"
    return LoggedEvent("cut", tuple(entities.tolist()), text, span)


def when(profile: TimeProfile, share: float, start: float, stop: float) -> float:
    """Return the time at which a profile that rises from 0 to 1 reaches a share [s].

    The time is found by bisection.

    Args:
        share: Value to be reached, 0 to 1.
        start: Time before it [s].
        stop: Time after it [s].
    """
    for _ in range(60):
        middle = 0.5 * (start + stop)
        start, stop = (middle, stop) if profile.at(middle)[0] < share else (start, middle)
    return stop
