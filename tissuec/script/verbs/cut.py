"""``cut``: springs that are removed."""

from typing import Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import LENGTH
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.profiles import TimeProfile
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    BODY,
    Cases,
    Lasting,
    ProfileClause,
    Springs,
    SubjectPart,
    ToolClause,
    VectorClause,
    direction,
    point,
)
from tissuec.script.verbs import VERBS, Action, EventQueue, Group, LoggedEvent, Order
from tissuec.script.verbs.closing import begin_closing, cut_event
from tissuec.script.verbs.cut_surface import Blade, cut_surface, plane, strip, stroke
from tissuec.script.verbs.holding import sentence

OfBody = Annotated[Group, SubjectPart("springs", (BODY,))]
SCISSORS = "scissors"  # the kind of tool whose blades close
With = Annotated[str | None, ToolClause("with", SCISSORS, what="tool")]
Closing = Annotated[TimeProfile | None, ProfileClause(None, "constant speed")]


class PlaneWords(VerbSentence, frozen=True):
    """Where a plane is: ``through POINT facing VECTOR``."""

    through: Annotated[Floats, point("through")]
    facing: Annotated[Floats, direction("facing", "(1, 0, 0)")]

    @property
    def plane(self) -> Blade:
        """The plane."""
        return plane(self.through, self.facing)


class CutSet(VerbSentence, frozen=True):
    """A cut of all springs of a set, or by the edge of a scalpel."""

    group: Springs
    tool: Annotated[str | None, ToolClause("with", "cutting", what="tool")]
    duration: Lasting

    def action(self, order: Order) -> Action:
        if not order.names_springs():
            if self.tool is not None and self.duration is not None:
                from tissuec.script.edge_cut import EdgeCut  # where there is a scalpel

                return EdgeCut(self.group.name, self.tool, self.duration, self.span)
            along = "along plane through (10, 0, 0) mm facing (1, 0, 0)"
            hint = f"for example: {along}"
            if self.tool is not None:
                hint = f"write {along}, or for a scalpel: from … to …: {order.span.text}"
            order.reject(
                "TIS304", '"cut" needs "along", except for a set of springs', hint=hint
            )
        _refuse_interval(self.duration, order)
        return Cut(self.group, None, None, None, self.span, self.tool or "")


class CutPlane(VerbSentence, frozen=True):
    """A cut of the springs that cross a plane."""

    group: OfBody
    through: Annotated[Floats, point("through")]
    facing: Annotated[Floats, direction("facing", "(1, 0, 0)")]
    scissors: With
    duration: Lasting

    def action(self, order: Order) -> Action:
        _refuse_interval(self.duration, order)
        blade = plane(self.through, self.facing)
        return Cut(self.group, blade, None, None, self.span, self.scissors or "")


class CutStroke(VerbSentence, frozen=True):
    """A cut of the springs that an edge crosses while it moves."""

    group: OfBody
    start: Annotated[Floats, point("from", "(10, -9, 0) mm")]
    stop: Annotated[Floats, point("to")]
    by: Annotated[
        Floats,
        VectorClause("by", LENGTH, what="vector of the stroke", example="by (0, 0, -5) mm"),
    ]
    scissors: With
    profile: Closing
    duration: Lasting

    def action(self, order: Order) -> Action:
        blade = stroke(self.start, self.stop, self.by)
        if blade is None:
            order.reject(
                "TIS306",
                "this stroke does not sweep any area",
                hint="the two points must differ, and the motion must not be parallel to the "
                "line between them",
                word="by",
            )
        return Cut(
            self.group, blade, self.profile, self.duration, self.span, self.scissors or ""
        )  # fmt: skip


class CutLine(VerbSentence, frozen=True):
    """A cut of the springs that cross a strip of a plane."""

    group: OfBody
    start: Annotated[Floats, point("from", "(10, -9, 0) mm")]
    stop: Annotated[Floats, point("to")]
    facing: Annotated[Floats, direction("facing", "(1, 0, 0)")]
    scissors: With
    profile: Closing
    duration: Lasting

    def action(self, order: Order) -> Action:
        blade = strip(self.start, self.stop, self.facing)
        if blade is None:
            order.reject(
                "TIS306",
                "this line is not in the plane that faces the given direction",
                hint="the points must differ, and the direction must be perpendicular to the "
                "line",
                word="facing",
            )
        return Cut(
            self.group, blade, self.profile, self.duration, self.span, self.scissors or ""
        )  # fmt: skip


def _refuse_interval(duration: float | None, order: Order) -> None:
    """Refuse a cut that has no edge along which blades could close."""
    if duration is not None:
        order.reject(
            "TIS306",
            "a cut over an interval needs a line or a stroke",
            hint="write at T: cut …, or: cut … along line from … to … facing …",
        )


@VERBS.member("cut")
class Cut(Struct, frozen=True):
    """Cuts springs of a set, or what a blade crosses of a body now, permanently.

    Springs are removed. Elements are divided where the blade is. Breakable ones of bodies
    without rupture by faces are removed if an edge of them is cut.

    ``along plane`` is an infinite plane. ``along stroke`` is the parallelogram that the edge
    between two points sweeps by a vector. ``along line`` is a strip of the plane that faces the
    given direction: the part between both ends of the line, infinite at right angles to it. A
    node on the blade counts as in front of it. Without ``along``, all springs of the set are
    cut. The tool after ``with`` is recorded in the event log; after ``along …``, it must be
    scissors. If nothing crosses the blade, nothing changes, and a note says so.

    Over an interval, ``cut BODY with`` a scalpel cuts a solid where its edge moves.

    Over an interval, the blades close along the line, or along the edge of the stroke, from its
    first point to its second. Springs are cut, and elements divided, in the order of their
    positions at the beginning of the cut; springs that get in the way later are cut at its end.
    Within elements, blades advance by a quarter of an element at a time. The force that this
    needs acts on the scissors.
    """

    meant: ClassVar[str] = "slice incise transect divide sever snip resect"
    cases: ClassVar = Cases(
        "along",
        {"": CutSet, "plane": CutPlane, "stroke": CutStroke, "line": CutLine},
        'a cut cannot go along "{}"',
        what="shapes of a cut",
    )

    group: Group
    blade: Blade | None
    profile: TimeProfile | None  # of the closing blades, None where all is cut at once
    duration: float | None  # [s]
    span: Span
    tool: str = ""

    def lines_within(self, network: Network) -> Indices:
        """Return the springs and edges that it may cut, shape (n,)."""
        return self.group.indices

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        name, blade = self.group.name, self.blade
        if blade is not None and state.network.phantoms_of(name) is not None:
            from tissuec.script.dividing import ElementCut  # where there are elements

            known = blade, self.profile, self.duration, self.span, self.tool
            return ElementCut(name, state.time, *known).apply(state, queue)
        if self.profile is not None:
            return self._begin(self.profile, state, queue)
        lines, _ = self.found(state)
        if not len(lines):
            text = f"{sentence(self.span)}: no spring to cut"
            return (LoggedEvent("note", (), text, self.span),)
        return (sever(state, lines, self),)

    def _begin(
        self, profile: TimeProfile, state: State, queue: EventQueue
    ) -> tuple[LoggedEvent, ...]:
        lines, shares = self.found(state)
        resists = state.network.cutting is not None
        surface = cut_surface(state, lines, self.blade) if resists else None
        return (begin_closing(self, profile, shares, surface, state, queue),)

    def until(self, state: State, share: float) -> tuple[LoggedEvent, ...]:
        """Cut what is there now up to a share of the edge, and return the event if any."""
        lines, at = self.found(state)
        reached = lines[at <= share]
        return (sever(state, reached, self),) if len(reached) else ()

    def found(self, state: State) -> tuple[Indices, Floats]:
        """Return the intact lines that the blade crosses, and where along its edge.

        Returns:
            Numbers of springs and edges of elements, and shares of the edge of the blade (0 to
            1, dimensionless), shape (n,) each.
        """
        lines = self.group.indices[state.alive[self.group.indices]]
        if self.blade is None:
            return lines, np.zeros(len(lines))
        first, second = state.position[state.network.line_ends[lines]].swapaxes(0, 1)
        across, share = self.blade.crosses(first, second, state.network.extent)
        return lines[across], share[across]


def sever(state: State, lines: Indices, cut: Cut) -> LoggedEvent:
    """Remove lines for good and return the event, with its area and energy if it takes any.

    Args:
        state: Changed in place.
        lines: Springs and edges of elements, shape (n,).
    """
    area = energy = 0.0
    if state.network.cutting is not None:
        surface = cut_surface(state, lines, cut.blade)
        area, energy = surface.area, surface.energy
    state.lose(lines)
    return cut_event(cut.span, lines, area, energy)
