"""Blades that divide solids: which elements they divide, when, and what that takes.

An element is divided as a whole: if at least half of its section lies within the blade. While
blades close, it is divided when they reach the middle of its section. Heights of nodes above
the blade are those at the beginning, so that the surfaces of neighbours adjoin.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.geometry.blade_sections import SectionWidths, met_edges, shares_of_polygons
from tissuec.geometry.cut_cells.cutting import DividedCells, cut, near_heights
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.mechanics.cutting import CutBody, Division, NotDivisible, carry_out, divided
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
#: Of the section of a cell, what a blade has to cover; half of it, to rounding. Below, the cell
#: stays whole.
LEAST_SHARE = 0.5 - 1e-9


class BladeWay(Struct, frozen=True, eq=False):
    """A blade through a solid.

    Attributes:
        body: Name of the solid.
        heights: Of all nodes above the blade at its beginning [m], shape (node,).
        entities: Elements that it meets, ascending, shape (n,).
        reach: Share of its edge at which it divides each, shape (n,).
        divides: Which of them are divided, shape (n,).
        areas: Of the sections within the blade, as drawn [m²], shape (n,).
        energies: That these take [J], shape (n,).
        surface: Of all sections.
    """

    body: str
    heights: Floats
    entities: Indices
    reach: Floats
    divides: Bools
    areas: Floats
    energies: Floats
    surface: CutSurface

    @classmethod
    def of(cls, state: "State", body: str, blade: Blade) -> "BladeWay | None":
        """Return a blade as the solid lies now; None if it divides nothing."""
        heights = (state.position - blade.origin) @ blade.normal
        before = CutBody.of(state, body)
        near = near_heights(before.parts, state.position)
        heights = np.where(np.abs(heights) < near, 0.0, heights)
        found = [
            _met(parts, entities, heights, state.position, blade)
            for parts, entities in zip(before.parts, before.entities, strict=True)
        ]
        entities, reach, covered = (np.concatenate(each) for each in zip(*found, strict=True))
        order = np.argsort(entities)
        entities, reach, covered = entities[order], reach[order], covered[order]
        divides = covered >= LEAST_SHARE
        if not divides.any():
            return None
        # What is left whole is entered with what is divided.
        reach = np.minimum(reach, reach[divides].max())
        found = cut(before.parts, heights, _among(before, entities[covered > 0.0]), near)
        if not len(found.copied):
            return None
        surface, former = _surface(state, body, before, found, blade)
        place = np.searchsorted(entities, former)
        areas, energies = (
            np.bincount(place, each, len(entities))
            for each in (surface.areas, surface.energies)
        )
        return cls(body, heights, entities, reach, divides, areas, energies, surface)

    def until(self, state: "State", share: float) -> Division | None:
        """Return the division of what exists now, up to a share of its edge.

        Raises:
            NotDivisible: The reserve of the body is exhausted.
        """
        reached = self.entities[self.divides & (self.reach <= share)]
        body = CutBody.of(state, self.body)
        return divided(state, self.body, self.heights, _among(body, reached))

    def divide(self, state: "State", division: Division) -> "tuple[BladeWay, Indices]":
        """Divide elements; return the rest of the way, and what is lost, shape (n,)."""
        heights = self.heights.copy()
        heights[division.copies] = heights[division.copied]
        carry_out(state, division)
        network, lost = state.network, division.lost
        edges = bare_edges(network, state.alive, lost)
        ahead = heights[network.line_ends[edges]] >= 0.0
        edges = edges[ahead.any(axis=1) & ~ahead.all(axis=1)]
        state.alive[edges] = False
        return replace(self, heights=heights), np.union1d(lost, edges)


def _among(body: CutBody, entities: Indices) -> tuple[Bools, ...]:
    """Return which elements of a body are some, shape (part,) each."""
    return tuple(np.isin(each, entities) for each in body.entities)


def _met(
    parts: CellParts, entities: Indices, heights: Floats, position: Floats, blade: Blade
) -> tuple[Indices, Floats, Floats]:
    """Return which elements of a shape a blade meets, where along its edge, and how much.

    Returns:
        Entities, shares of the edge, and shares of their sections, shape (n,) each.
    """
    corners = parts.nodes[:, : len(parts.division.corners)]
    ahead, on = heights[corners] >= 0.0, heights[corners] == 0.0
    per_metre = np.linalg.pinv(blade.spans)
    crossed = np.flatnonzero(ahead.any(axis=1) & ~ahead.all(axis=1))
    own = corners[crossed]
    met = met_edges(position[own], parts.division.edges, heights[own], blade.normal, 0.0)
    plain = (met.mixed(position[own]) - blade.origin) @ per_metre
    covered, middles = np.ones(len(crossed)), np.zeros(len(crossed))
    if any(blade.limited) and len(crossed):
        covered = shares_of_polygons(plain, blade.limited)
        middles = plain[:, :, 0].mean(axis=1)
    # Where the blade lies between two elements, both count by the middle of their face.
    is_one = ahead.all(axis=1) | ~ahead.any(axis=1)
    touching = np.flatnonzero((on.sum(axis=1) >= 3) & is_one)
    beside = on[touching, :, None] * position[corners[touching]]
    middle = beside.sum(axis=1) / on[touching].sum(axis=1)[:, None]
    centre = (middle - blade.origin) @ per_metre
    inside = ~((np.abs(centre - 0.5) > 0.5) & blade.limited).any(axis=1)
    chosen = np.concatenate([crossed, touching])
    reach = np.concatenate([middles, centre[:, 0]])
    part = np.concatenate([covered, inside.astype(float)])
    return entities[chosen], np.clip(reach, 0.0, 1.0) * blade.limited[0], part


def _surface(
    state: "State", body: str, before: CutBody, found: DividedCells, blade: Blade
) -> tuple[CutSurface, Indices]:
    """Return the surface of a cut, triangle by triangle, and the element that each was in.

    Areas are as drawn, of what lies within the blade.
    """
    network, triangles = state.network, found.cut
    resistance, former = list[Floats](), list[Indices]()
    for field, parts, entities, source in zip(
        network.elements_of(body), found.groups, before.entities, found.source, strict=True
    ):
        known = None
        if network.cutting is not None:
            known = network.cutting.elements.get(field.block.name)
        resistance.append(np.zeros(len(parts)) if known is None else known[parts.cell])
        former.append(entities[source])
    areas = triangles.sizes(found.groups, found.with_copies(network.position))
    places = triangles.places(found.groups, found.with_copies(state.position))
    plain = (places - blade.origin) @ np.linalg.pinv(blade.spans)
    if any(blade.limited):
        areas = areas * shares_of_polygons(plain, blade.limited)
    energies = areas * np.concatenate(resistance)[triangles.parts].mean(axis=1)
    of = np.concatenate(former)[triangles.parts[:, 1]]
    if not blade.limited[0]:
        return CutSurface.even(areas, energies, 0.0, 1.0), of
    widths = SectionWidths.of(plain, blade.limited)
    return CutSurface.of_widths(areas, energies, widths), of


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
        shares = np.round(way.reach[way.divides], 9)
        surface = None if state.network.cutting is None else way.surface
        return (begin_closing(self, self.profile, shares, surface, state, queue),)

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
        if division is None:
            return way, ()
        reached = way.reach <= share
        area, energy = (float(each[reached].sum()) for each in (way.areas, way.energies))
        left = replace(way, areas=way.areas * ~reached, energies=way.energies * ~reached)
        rest, lost = left.divide(state, division)
        return rest, (cut_event(self.span, lost, area, energy),)
