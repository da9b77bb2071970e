"""``cut``: springs that are removed."""

from typing import ClassVar, Protocol, Self

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import VERBS, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.blade import ON_PLANE, Blade, plane, strip, stroke
from tissuec.script.verbs.holding import sentence
from tissuec.script.verbs.motion import schedule


@VERBS.member("cut")
class Cut(Struct, frozen=True):
    """Removes springs permanently: those of a set, or those of a body that a blade crosses now.

    ``along plane`` is an infinite plane. ``along stroke`` is the parallelogram that the edge
    between two points sweeps by a vector. ``along line`` is a strip of the plane that faces the
    given direction: the part between both ends of the line, infinite at right angles to it. A
    node on the blade counts as in front of it. Without ``along``, all springs of the set are
    cut. The tool after ``with`` must be scissors and is recorded in the event log. If no spring
    crosses the blade, nothing changes, and a note says so.

    Over an interval, the blades close along the line, or along the edge of the stroke, from its
    first point to its second. Springs are cut in the order of their positions at the beginning
    of the cut; the remaining ones at its end.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "cut SET",
        "cut BODY along plane through POINT facing VECTOR",
        "cut BODY along stroke from POINT to POINT by VECTOR",
        "cut BODY along line from POINT to POINT facing VECTOR",
        "cut BODY along plane through POINT facing VECTOR with TOOL",
        "cut BODY along line from POINT to POINT facing VECTOR using PROFILE",
    )
    group: Group
    blade: Blade | None
    profile: TimeProfile | None  # of the closing blades, None where all is cut at once
    duration: float | None  # [s]
    span: Span

    @classmethod
    def read(cls, order: Order) -> Self:
        group = order.springs()
        order.tool("with", kinds=("scissors",))
        blade = _read_blade(order) if order.has("along") else None
        if blade is None and not order.names_springs():
            order.reject(
                "TIS304",
                '"cut" needs "along", except for a set of springs',
                hint="for example: along plane through (10, 0, 0) mm facing (1, 0, 0)",
            )
        if order.duration is None:
            return cls(group, blade, None, None, order.span)
        if blade is None or not blade.limited[0]:
            order.reject(
                "TIS306",
                "a cut over an interval needs a line or a stroke",
                hint="write at T: cut …, or: cut … along line from … to … facing …",
            )
        profile = order.profiles(default="constant speed")[0]
        return cls(group, blade, profile, order.duration, order.span)

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if self.profile is not None:
            return self._begin(self.profile, state, queue)
        springs, _ = self.found(state)
        if not len(springs):
            text = f"{sentence(self.span)}: no spring to cut"
            return (LoggedEvent("note", (), text, self.span),)
        return (sever(state, springs, self.span),)

    def _begin(
        self, profile: TimeProfile, state: State, queue: EventQueue
    ) -> tuple[LoggedEvent, ...]:
        (begun,), stop = schedule(queue, (profile,), state.time, self.duration)
        shares = np.unique(np.append(self.found(state)[1], 1.0))
        for time in np.unique([when(begun, share, state.time, stop) for share in shares]):
            queue.add(float(time), BladeClosing(self, begun, stop))
        text = f"start of: {sentence(self.span)}"
        return (LoggedEvent("stroke", (), text, self.span),)

    def found(self, state: State) -> tuple[Indices, Floats]:
        """Return the intact springs that the blade crosses, and where along its edge.

        Returns:
            Indices of springs, and shares of the edge (0 to 1, dimensionless), shape (n,) each.
        """
        springs = self.group.indices[state.alive[self.group.indices]]
        if self.blade is None:
            return springs, np.zeros(len(springs))
        first, second = state.position[state.springs.ends[springs]].swapaxes(0, 1)
        across, share = self.blade.crosses(first, second, state.network.extent)
        return springs[across], share[across]


class BladeClosing(Struct, frozen=True, eq=False):
    """Closing blades that have come so far along their edge."""

    cut: Cut
    profile: TimeProfile
    stop: float  # [s]

    @property
    def span(self) -> Span:
        return self.cut.span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        springs, share = self.cut.found(state)
        come = 1.0 if state.time >= self.stop else self.profile.at(state.time)[0]
        reached = springs[share <= come + ON_PLANE]
        return (sever(state, reached, self.span),) if len(reached) else ()


def sever(state: State, springs: Indices, span: Span) -> LoggedEvent:
    """Remove springs for good and return the event.

    Args:
        state: Changed in place.
        springs: Indices, shape (n,).
        span: The sentence.
    """
    state.alive = state.alive.copy()
    state.alive[springs] = False
    return LoggedEvent("cut", tuple(springs.tolist()), sentence(span), span)


def when(profile: TimeProfile, share: float, start: float, stop: float) -> float:
    """Return the time at which a profile that rises from 0 to 1 reaches a share [s].

    The time is found by bisection.

    Args:
        profile: The profile.
        share: Value to be reached, 0 to 1.
        start: Time before it [s].
        stop: Time after it [s].
    """
    for _ in range(60):
        middle = 0.5 * (start + stop)
        start, stop = (middle, stop) if profile.at(middle)[0] < share else (start, middle)
    return stop


def _read_blade(order: Order) -> Blade:
    shape = order.text("along").lower()
    if shape not in _BLADES:
        hint = alternatives(shape, _BLADES, what="shapes of a cut")
        order.reject("TIS305", f'a cut cannot go along "{shape}"', hint=hint, word="along")
    return _BLADES[shape](order)


class PlaneWords(Protocol):
    """What of a sentence says where its plane is; see ``Order``."""

    def vector(self, word: str, dimension: units.Dimension) -> Floats:
        """Return the vector behind a word, in SI units, shape (3,)."""
        ...

    def direction(self, word: str) -> Floats:
        """Return the unit vector behind a word, shape (3,)."""
        ...


def read_plane(order: PlaneWords) -> Blade:
    """Return the plane of a sentence with "through" and "facing"."""
    return plane(order.vector("through", units.LENGTH), order.direction("facing"))


def _read_stroke(order: Order) -> Blade:
    ends = (order.vector(word, units.LENGTH) for word in ("from", "to", "by"))
    blade = stroke(*ends)
    if blade is None:
        order.reject(
            "TIS306",
            "this stroke does not sweep any area",
            hint="the two points must differ, and the motion must not be parallel to the "
            "line between them",
            word="by",
        )
    return blade


def _read_strip(order: Order) -> Blade:
    start, stop = (order.vector(word, units.LENGTH) for word in ("from", "to"))
    blade = strip(start, stop, order.direction("facing"))
    if blade is None:
        order.reject(
            "TIS306",
            "this line is not in the plane that faces the given direction",
            hint="the points must differ, and the direction must be perpendicular to the line",
            word="facing",
        )
    return blade


_BLADES = {"plane": read_plane, "stroke": _read_stroke, "line": _read_strip}
