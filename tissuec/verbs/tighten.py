"""``tighten`` and ``loosen``: threads that are drawn in or paid out."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tissuec.core import units
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.courses import Course
from tissuec.network import Indices, Network
from tissuec.situation import Situation
from tissuec.threads import Reeling
from tissuec.verbs import VERBS, Action, Agenda, Failed, Group, Happening, Order
from tissuec.verbs.holding import sentence
from tissuec.verbs.motion import schedule


@dataclass(frozen=True, slots=True)
class Reel:
    """Another length for a thread, by shares of the lengths that its pieces have."""

    group: Group
    length: float  # [m]
    shorter: bool  # whether it is to become so
    course: Course
    duration: float | None  # [s]
    span: Span

    def flaw(self, network: Network) -> str:
        """Return why it cannot be done, empty if it can."""
        return no_thread(network, self.group.name)

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        pieces = intact_pieces(situation, self.group.name)
        situation.stop_reeling(self.group.indices)
        rest = situation.rest[pieces]
        present = float(rest.sum())
        if present <= 0.0:
            message = f"nothing is left of {self.group.name} that could change its length"
            raise Failed(message, _first_node(situation, self.group.name), self.span)
        text = sentence(self.span)
        if (self.length < present) != self.shorter:
            note = f"{text}: its length is {show(present, LENGTH)} already"
            return (Happening("note", (), note, self.span),)
        change = rest * (self.length / present - 1.0)
        if self.course.kind == "constant":
            situation.rest = situation.rest.copy()
            situation.rest[pieces] += change
            return (Happening("reel", (), text, self.span),)
        (course,), stop = schedule(agenda, (self.course,), situation.time, self.duration)
        reeling = Reeling(pieces, rest, change, course, self.span)
        situation.reelings = {**situation.reelings, self.group.name: reeling}
        if np.isfinite(stop):
            agenda.add(stop, EndReel(self.group.name, self.span, stop))
        return (Happening("reel", (), text, self.span),)


@dataclass(frozen=True, slots=True)
class EndReel:
    """The end of drawing in or paying out, unless another order took its place."""

    thread: str
    span: Span
    stop: float  # [s]

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        reeling = situation.reelings.get(self.thread)
        if reeling is None or reeling.course.stop > self.stop:
            return ()
        rest = situation.rest.copy()
        rest[reeling.springs] = reeling.rest(self.stop)
        situation.reelings = {
            name: other for name, other in situation.reelings.items() if other is not reeling
        }
        situation.rest = rest
        return (Happening("end", (), f"end of: {sentence(self.span)}", self.span),)


@VERBS.member("tighten")
class Tighten:
    """Draws a thread in until it is as long as is written, within the interval or at once.

    The length is that without tension, of all pieces that are whole and of a tied knot: of a
    sling, its circumference once it is slack. All pieces become shorter in proportion, as when
    a sling is drawn through its knot while it slides on what it holds. ``using`` a course says
    how (otherwise evenly). A thread that is shorter already is left as it is, which is noted.
    """

    forms: ClassVar[tuple[str, ...]] = (
        "tighten THREAD to LENGTH",
        "tighten THREAD to LENGTH using COURSE",
    )

    @classmethod
    def read(cls, order: Order) -> Action:
        return _read(order, shorter=True)


@VERBS.member("loosen")
class Loosen:
    """Pays a thread out until it is as long as is written: the opposite of ``tighten``."""

    forms: ClassVar[tuple[str, ...]] = (
        "loosen THREAD to LENGTH",
        "loosen THREAD to LENGTH using COURSE",
    )

    @classmethod
    def read(cls, order: Order) -> Action:
        return _read(order, shorter=False)


def _read(order: Order, *, shorter: bool) -> Reel:
    length = order.number("to", units.LENGTH)
    if length <= 0.0:
        order.reject("TIS308", "the length of a thread is above 0", word="to")
    default = "constant" if order.duration is None else "ramp"
    course = order.courses(default=default)[0]
    return Reel(order.nodes(), length, shorter, course, order.duration, order.span)


def no_thread(network: Network, name: str) -> str:
    """Return that something is no thread, empty if it is one."""
    return "" if name in network.threads else f"{name} is no body of mesh thread"


def intact_pieces(situation: Situation, name: str) -> Indices:
    """Return the springs along a thread that are there, with that of its knot, ascending."""
    thread = situation.network.threads[name]
    every = np.append(np.arange(thread.pieces.start, thread.pieces.stop), thread.hold)
    return np.unique(every[situation.alive[every]])


def _first_node(situation: Situation, name: str) -> int:
    hold = situation.network.threads[name].hold
    return int(situation.network.ends[hold, 0])
