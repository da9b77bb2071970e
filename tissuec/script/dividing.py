"""Blades that divide solids: which elements they divide, when, and what that takes.

An element is divided as a whole when a blade reaches it, and its section is tied where the
blade has not parted it (``mechanics.tying``). Heights of nodes above the blade, and where they
are along it, are those at its beginning, so that the surfaces of neighbours adjoin. While
blades close, they proceed in steps of a quarter of a section.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.geometry.blade_sections import (
    SectionWidths,
    beyond,
    met_edges,
    shares_of_polygons,
)
from tissuec.geometry.cut_cells.cutting import DividedCells, cut, near_heights
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_surfaces import NotDivisible
from tissuec.mechanics.cutting import Division, carry_out, divided
from tissuec.mechanics.tying import TiedSections, put_ties
from tissuec.model.edges import bare_edges
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import ActionFailed, EventQueue, LoggedEvent
from tissuec.script.verbs.closing import begin_closing, cut_event
from tissuec.script.verbs.cut_surface import Blade, CutSurface
from tissuec.script.verbs.holding import sentence

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
#: Of the section of a cell, what a blade has to cover, and of its edge, how far it has to be
#: beyond where a section begins: above rounding.
LEAST_SHARE = 1e-9
#: Of the size of an element: how far a blade may be from a tied section that it continues.
CONTINUED = 0.1
ON_SURFACE = 1e-3  # of the size of an element: how far triangles of a surface are from it
STEPS = 4  # of a blade that closes, on the length of a section
MOST_STEPS = 4096


class BladeWay(Struct, frozen=True, eq=False):
    """A blade through a solid.

    Attributes:
        body: Name of the solid.
        blade: As ordered.
        heights: Of all nodes above the blade at its beginning [m], shape (node,).
        plain: p and q of all nodes at its beginning, shape (node, 2).
        entities: Elements that it divides, shape (n,).
        begin, end: Between which shares of its edge each is, shape (n,).
        sections: p and q of the corners of triangles of all sections, shape (triangle, 3, 2).
        areas: Of these, as drawn [m²], shape (triangle,).
        resistance: Energy per area of these [J/m²], shape (triangle,).
        reached: Share of its edge up to which it has cut.
    """

    body: str
    blade: Blade
    heights: Floats
    plain: Floats
    entities: Indices
    begin: Floats
    end: Floats
    sections: Floats
    areas: Floats
    resistance: Floats
    reached: float = 0.0

    @classmethod
    def of(cls, state: "State", body: str, blade: Blade) -> "BladeWay | None":
        """Return a blade as the solid lies now; None if it divides nothing."""
        before = CutBody.of(state, body)
        per_metre = np.linalg.pinv(blade.spans)
        plain = (state.position - blade.origin) @ per_metre
        heights = (state.position - blade.origin) @ blade.normal
        tied = state.tied.get(body)
        if tied is not None:
            heights = _continued(tied.existing(before), before, heights)
        near = near_heights(before.parts, state.position)
        heights = np.where(np.abs(heights) < near, 0.0, heights)
        found = [
            _met(parts, entities, heights, state.position, blade)
            for parts, entities in zip(before.parts, before.entities, strict=True)
        ]
        entities, begin, end, covered = (
            np.concatenate(each) for each in zip(*found, strict=True)
        )
        divides = covered > LEAST_SHARE
        entities, begin, end = entities[divides], begin[divides], end[divides]
        parted = cut(before.parts, heights, _among(before, entities), near)
        if not len(parted.copied) and tied is None:
            return None
        triangles = parted.cut
        groups, drawn = parted.groups, state.network.position
        at = triangles.places(groups, parted.with_copies(plain))
        areas = triangles.sizes(groups, parted.with_copies(drawn))
        resistance = _resistance(state, body, before, parted)
        way = cls(
            body, blade, heights, plain, entities, begin, end, at, areas, resistance
        )  # fmt: skip
        frees = tied is not None and len(way.parting(tied, before, 1.0)) != len(tied)
        return way if frees or len(parted.copied) else None

    @property
    def steps(self) -> Floats:
        """Return shares of its edge at which it divides elements and parts sections, (n,)."""
        length = self.end - self.begin
        length = length[length > 0.0]
        if not len(length):
            return np.ones(1)
        count = int(np.clip(np.ceil(STEPS / np.median(length)), 1, MOST_STEPS))
        first = int(np.floor(count * (self.begin.min() + LEAST_SHARE)))
        last = int(np.ceil(count * (self.end.max() - LEAST_SHARE)))
        return np.arange(first + 1, last + 1) / count

    @property
    def surface(self) -> CutSurface:
        """Return what of the sections is within the blade, triangle by triangle."""
        limited = self.blade.limited
        areas = self.areas
        if any(limited):
            areas = areas * shares_of_polygons(self.sections, limited)
        energies = areas * self.resistance
        if not limited[0]:
            return CutSurface.even(areas, energies, 0.0, 1.0)
        return CutSurface.of_widths(areas, energies, SectionWidths.of(self.sections, limited))

    def taken(self, share: float) -> tuple[float, float]:
        """Return the area [m²] and energy [J] of what lies up to a share of the edge."""
        limited, areas = self.blade.limited, self.areas
        if share <= 0.0:
            return 0.0, 0.0
        if any(limited):
            scaled = self.sections / [share, 1.0]
            areas = areas * shares_of_polygons(scaled, limited)
        return float(areas.sum()), float((areas * self.resistance).sum())

    def until(self, state: "State", share: float) -> Division | None:
        """Return the division of what exists now, up to a share of its edge.

        Raises:
            NotDivisible: The reserve of the body is exhausted.
        """
        reached = self.entities[self.begin + LEAST_SHARE <= share]
        body = CutBody.of(state, self.body)
        return divided(state, self.body, self.heights, _among(body, reached))

    def divide(
        self, state: "State", division: Division | None, share: float
    ) -> "tuple[BladeWay, Indices]":
        """Divide elements and part sections; return the rest of the way, and what is lost.

        What is lost has the shape (n,).
        """
        way, lost = self, np.zeros(0, dtype=np.int64)
        tied = state.tied.get(self.body)
        if division is not None:
            heights, plain = self.heights.copy(), self.plain.copy()
            heights[division.copies] = heights[division.copied]
            plain[division.copies] = plain[division.copied]
            way = replace(self, heights=heights, plain=plain)
            carry_out(state, division)
            lost = np.union1d(division.lost, _parted_edges(state, division.lost, heights))
            after = division.body, division.triangles
            new = TiedSections.of(state.network, self.body, *after, heights)
            none = TiedSections.none(len(heights))
            tied = (division.tied or none).followed_by(new, division.body)
        if tied is not None:
            body = CutBody.of(state, self.body)
            put_ties(state, self.body, way.parting(tied.existing(body), body, share))
        return replace(way, reached=share), lost

    def parting(self, tied: TiedSections, body: CutBody, share: float) -> TiedSections:
        """Return what of tied sections the blade leaves tied up to a share of its edge."""
        away = np.abs(tied.linear(body, self.heights)).max(axis=(1, 2))
        own = np.flatnonzero(away < ON_SURFACE * tied.size)
        if not len(own):
            return tied
        mine = tied.some(own)
        plain = mine.values(body, self.plain).mean(axis=1)
        which, shares = beyond(plain, self.blade.limited, share)
        stays = np.ones(len(tied), dtype=bool)
        stays[own] = False
        left = mine.parts_of(which, shares)
        return tied.some(stays).followed_by(left, body)


def _continued(tied: TiedSections, body: CutBody, heights: Floats) -> Floats:
    """Return heights above a blade that continues the surface of tied sections close to it.

    Args:
        body: Elements that exist.
        heights: Of all nodes above the blade [m], shape (node,).
    """
    if not len(tied):
        return heights
    away = np.abs(tied.values(body, heights[:, None])[..., 0].mean(axis=1)).max(axis=1)
    is_near = away < CONTINUED * tied.size
    nodes = tied.nodes(body)
    far = np.unique(tied.entities[~is_near])
    own = nodes[is_near & ~np.isin(tied.entities, far).any(axis=1)]
    own = np.unique(own[own >= 0])
    known = tied.heights[own]
    facing = 1.0 if (known * heights[own]).sum() >= 0.0 else -1.0
    found = heights.copy()
    found[own] = facing * known
    return found


def _parted_edges(state: "State", lost: Indices, heights: Floats) -> Indices:
    """Remove edges that a blade crosses and no element has any more; return them."""
    network = state.network
    edges = bare_edges(network, state.alive, lost)
    ahead = heights[network.line_ends[edges]] >= 0.0
    edges = edges[ahead.any(axis=1) & ~ahead.all(axis=1)]
    state.alive[edges] = False
    return edges


def _among(body: CutBody, entities: Indices) -> tuple[Bools, ...]:
    """Return which elements of a body are some, shape (part,) each."""
    return tuple(np.isin(each, entities) for each in body.entities)


def _met(
    parts: CellParts, entities: Indices, heights: Floats, position: Floats, blade: Blade
) -> tuple[Indices, Floats, Floats, Floats]:
    """Return which elements of a shape a blade meets, where along its edge, and how much.

    Returns:
        Entities, shares of the edge at which their sections begin and end, and shares of the
        sections within the blade, shape (n,) each.
    """
    corners = parts.nodes[:, : len(parts.division.corners)]
    ahead, on = heights[corners] >= 0.0, heights[corners] == 0.0
    # Where the blade lies between two elements, both have their face as a section.
    touches = ahead.all(axis=1) & (on.sum(axis=1) >= 3)
    crossed = np.flatnonzero((ahead.any(axis=1) & ~ahead.all(axis=1)) | touches)
    own, side = corners[crossed], np.where(touches[crossed], -1.0, 1.0)[:, None]
    met = met_edges(position[own], parts.division.edges, side * heights[own], blade.normal, 0.0)
    plain = (met.mixed(position[own]) - blade.origin) @ np.linalg.pinv(blade.spans)
    covered, ends = np.ones(len(crossed)), np.zeros((2, len(crossed)))
    if any(blade.limited) and len(crossed):
        covered = shares_of_polygons(plain, blade.limited)
    if blade.limited[0] and len(crossed):
        along = np.clip(plain[:, :, 0], 0.0, 1.0)
        ends = np.stack([along.min(axis=1), along.max(axis=1)])
    return entities[crossed], ends[0], ends[1], covered


def _resistance(state: "State", body: str, before: CutBody, found: DividedCells) -> Floats:
    """Return the energy per area of the triangles of a cut [J/m²], shape (triangle,)."""
    network = state.network
    each = list[Floats]()
    for field, parts in zip(network.elements_of(body), found.groups, strict=True):
        known = None
        if network.cutting is not None:
            known = network.cutting.elements.get(field.block.name)
        each.append(np.zeros(len(parts)) if known is None else known[parts.cell])
    return np.concatenate(each)[found.cut.parts].mean(axis=1)


class SolidCut(Struct, frozen=True, eq=False):
    """A cut through a solid; see ``verbs.cut.Cut``.

    Attributes:
        body: Name of the solid.
        time: When it begins [s].
        profile: Of blades that close; None where all is cut at once.
        duration: Of their closing [s]; None where it is not given.
    """

    body: str
    time: float
    blade: Blade
    profile: TimeProfile | None
    duration: float | None
    span: Span
    tool: str

    @property
    def way(self) -> str:
        """Return the key of its ``BladeWay`` in the state, while blades close."""
        return f"{self.span.place} {self.time!r}"

    def apply(self, state: "State", queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Carry out the cut, or begin it.

        Raises:
            ActionFailed: The reserve of the body is exhausted.
        """
        way = BladeWay.of(state, self.body, self.blade)
        if way is None:
            note = f"{sentence(self.span)}: no element to divide"
            return (LoggedEvent("note", (), note, self.span),)
        if self.profile is None:
            return self._divide(state, way, 1.0)[1]
        state.blades = {**state.blades, self.way: way}
        surface = None if state.network.cutting is None else way.surface
        return (begin_closing(self, self.profile, way.steps, surface, state, queue),)

    def until(self, state: "State", share: float) -> tuple[LoggedEvent, ...]:
        """Divide what there is up to a share of the edge.

        Raises:
            ActionFailed: The reserve of the body is exhausted.
        """
        way = state.blades.get(self.way)
        if way is None:  # all of it has been divided
            return ()
        rest, events = self._divide(state, way, share)
        state.blades = {key: one for key, one in state.blades.items() if key != self.way}
        if share < 1.0:
            state.blades[self.way] = rest
        return events

    def _divide(
        self, state: "State", way: BladeWay, share: float
    ) -> tuple[BladeWay, tuple[LoggedEvent, ...]]:
        """Divide elements; return the rest of the way, and the event if there are any."""
        try:
            division = way.until(state, share)
        except NotDivisible as error:
            raise ActionFailed(str(error), None, self.span) from error
        before, after = way.taken(way.reached), way.taken(share)
        area, energy = after[0] - before[0], after[1] - before[1]
        rest, lost = way.divide(state, division, share)
        if division is None and area == 0.0:
            return rest, ()
        return rest, (cut_event(self.span, lost, area, energy),)
