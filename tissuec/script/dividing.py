"""Blades that divide elements: which of them they divide, when, and what that takes.

An element is divided as a whole when a blade reaches it, and its section is tied where the
blade has not parted it (``mechanics.tying``). Heights of nodes above the blade, and where they
are along it, are those at its beginning, so that the surfaces of neighbours adjoin. While
blades close, they proceed in steps of a quarter of a section. Sections of solids are triangles;
those of walls are lines, and as thick as the wall.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import SAME_PLACE
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.geometry.blade_sections import (
    beyond,
    met_edges,
    parts_of_lines,
    shares_of_polygons,
)
from tissuec.geometry.cut_cells.cutting import cut, near_heights
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.geometry.cut_cells.sections import CutFacets
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_effects import put_ties
from tissuec.mechanics.cut_fields import facet_areas
from tissuec.mechanics.cutting import Division, carry_out_tied, divided
from tissuec.mechanics.tearing import set_limits
from tissuec.mechanics.tying import TiedSections
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.profiles import TimeProfile
from tissuec.model.topology import pieces
from tissuec.script.verbs import EventQueue, LoggedEvent, stopping
from tissuec.script.verbs.closing import begin_closing, cut_event
from tissuec.script.verbs.cut_surface import (
    Blade,
    CutSurface,
    surface_of_lines,
    surface_of_polygons,
)
from tissuec.script.verbs.holding import sentence

if TYPE_CHECKING:
    from tissuec.forces.surfaces.membranes import Membranes
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
#: Least share of a section that a blade must cover, and by which it must have passed its
#: beginning on the edge: above rounding.
LEAST_SHARE = 1e-9
#: Of the size of an element: how far a blade may be from a tied section that it continues.
CONTINUED = 0.1
STEPS = 4  # of a blade that closes, on the length of a section
MOST_STEPS = 4096


class WallLines(Struct, frozen=True, eq=False):
    """Properties of sections that only walls have.

    Attributes:
        ends: Numbers of the ends of lines, equal ones in equal places, shape (line, 2).
        thickness: [m], shape (line,).
    """

    ends: Indices
    thickness: Floats

    @classmethod
    def of(cls, wall: "Membranes", facets: CutFacets, parts: CellParts) -> Self:
        """Return those of a cut through a wall."""
        part = facets.parts[:, 0]
        nodes = parts.drawn[part[:, None], facets.roots[:, 0]]
        # Ends are on edges, at the same part of them in both triangles.
        shares = np.round(facets.shares[:, 0] / SAME_PLACE).astype(np.int64)
        nodes = np.where(shares > 0, nodes[:, None], -1)
        order = np.argsort(nodes, axis=2)
        both = [np.take_along_axis(each, order, axis=2) for each in (nodes, shares)]
        rows = np.concatenate(both, axis=2).reshape(2 * len(part), 2 * nodes.shape[-1])
        ends = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1, 2)
        return cls(ends, wall.thickness[parts.cell[part]])


class BladeWay(Struct, frozen=True, eq=False):
    """A blade through a solid or a wall.

    Attributes:
        name: Of the cut.
        body: Its name.
        blade: As ordered.
        heights: Of all nodes above the blade at its beginning [m], shape (node,).
        plain: p and q of all nodes at its beginning, shape (node, 2).
        entities: Elements that it divides, shape (n,).
        begin, end: Shares of its edge between which each lies, shape (n,).
        sections: p and q of the corners of triangles of all sections, shape (triangle, 3, 2),
            or of lines, shape (line, 2, 2).
        areas: Of these, as drawn [m²], shape (triangle,).
        resistance: Energy per area of these [J/m²], shape (triangle,).
        lines: Of walls; None in a solid.
        reached: Share of its edge up to which it has cut.
    """

    name: str
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
    lines: WallLines | None
    reached: float = 0.0

    @classmethod
    def of(cls, state: "State", name: str, body: str, blade: Blade) -> "BladeWay | None":
        """Return a blade as the body lies now; None if it divides nothing."""
        before = CutBody.of(state, body)
        plain, heights = blade.plain(state.position), blade.heights(state.position)
        tied = state.tied.get(body)
        if tied is not None:
            heights = continued(tied.existing(before), before, heights)
        near = near_heights(before.parts, state.position)
        heights = np.where(np.abs(heights) < near, 0.0, heights)
        found = [
            met_sections(parts, entities, heights, state.position, blade)
            for parts, entities in zip(before.parts, before.entities, strict=True)
        ]
        entities, begin, end, covered = (
            np.concatenate(each) for each in zip(*found, strict=True)
        )
        divides = covered > LEAST_SHARE
        entities, begin, end = entities[divides], begin[divides], end[divides]
        parted = cut(before.parts, heights, among(before, entities), near)
        if not len(parted.copied) and tied is None:
            return None
        facets, groups, fields = parted.cut, parted.groups, state.network.elements_of(body)
        at = facets.places(groups, parted.with_copies(plain))
        drawn = parted.with_copies(state.network.position)
        areas, lines = facet_areas(fields, groups, facets, drawn), None
        if groups[0].division.dimension == 2:
            lines = WallLines.of(fields[0], facets, groups[0])
        each = resistances(state.network, body, groups)
        resistance = np.concatenate(each)[facets.parts].mean(axis=1)
        if tied is not None and lines is None:
            at, areas, resistance = (
                np.concatenate(both)
                for both in zip(
                    (at, areas, resistance),
                    _tied_on(state.network, body, before, tied, heights, plain),
                    strict=True,
                )
            )
        way = cls(
            name, body, blade, heights, plain, entities, begin, end, at, areas, resistance,
            lines,
        )  # fmt: skip
        frees = tied is not None and len(way.parting(tied, before, 1.0)) != len(tied)
        return way if frees or len(parted.copied) else None

    @property
    def steps(self) -> Floats:
        """Return shares of its edge at which it divides elements and parts sections.

        They are dimensionless, shape (n,).
        """
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
        """Return the part of the sections within the blade, triangle by triangle."""
        known = self.areas, self.sections
        if (own := self.lines) is not None:
            ends = own.ends, own.thickness
            return surface_of_lines(*known, *ends, self.resistance, self.blade)
        return surface_of_polygons(*known, self.resistance, self.blade)

    def taken(self, share: float) -> tuple[float, float]:
        """Return the area [m²] and energy [J] of what lies up to a share of the edge."""
        limited, areas = self.blade.limited, self.areas
        if share <= 0.0:
            return 0.0, 0.0
        if any(limited):
            areas = areas * _within(self.sections / [share, 1.0], limited)
        return float(areas.sum()), float((areas * self.resistance).sum())

    def until(self, state: "State", share: float) -> Division | None:
        """Return the division of the elements that exist now, up to a share of its edge.

        Raises:
            NotDivisible: The reserve of the body is exhausted.
        """
        reached = self.entities[self.begin + LEAST_SHARE <= share]
        body = CutBody.of(state, self.body)
        return divided(state, self.body, self.heights, self.name, among(body, reached))

    def divide(
        self, state: "State", division: Division | None, share: float
    ) -> "tuple[BladeWay, Indices]":
        """Divide elements and part sections; return the rest of the way, and lost entities.

        The entities have the shape (n,).
        """
        way, lost = self, np.zeros(0, dtype=np.int64)
        tied = state.tied.get(self.body)
        if division is not None:
            plain = self.plain.copy()
            plain[division.copies] = plain[division.copied]
            heights, tied, lost = tied_apart(state, division, self.heights)
            way = replace(self, heights=heights, plain=plain)
        if tied is not None:
            body = CutBody.of(state, self.body)
            put_ties(state, self.body, way.parting(tied.existing(body), body, share))
            set_limits(state, self.body)
        return replace(way, reached=share), lost

    def parting(self, tied: TiedSections, body: CutBody, share: float) -> TiedSections:
        """Return the sections still tied when the blade has come to a share of its edge."""
        are_own = tied.are_on(body, self.heights)
        if not are_own.any():
            return tied
        own = tied.some(are_own)
        each = [own.linear(body, values).mean(axis=1) for values in self.plain.T]
        plain = np.stack(each, axis=-1)
        left = own.parts_of(*beyond(plain, self.blade.limited, share))
        return tied.some(~are_own).followed_by(left, body)


def _tied_on(
    network: Network,
    body: str,
    parts: CutBody,
    tied: TiedSections,
    heights: Floats,
    plain: Floats,
) -> tuple[Floats, Floats, Floats]:
    """Return the tied sections of a solid that lie in a blade.

    Args:
        body: Its name.
        parts: Its elements.
        heights: Of all nodes above the blade [m], shape (node,).
        plain: p and q of all nodes, shape (node, 2).

    Returns:
        p and q of corners, shape (triangle, 3, 2), areas as drawn [m²] and resistances [J/m²],
        shape (triangle,) each.
    """
    own = tied.existing(parts)
    own = own.some(own.are_on(parts, heights))
    each = [own.linear(parts, values).mean(axis=1) for values in plain.T]
    areas = own.areas(network, body, parts)
    found = own.of_parts(parts, resistances(network, body, parts.parts))
    return np.stack(each, axis=-1), areas, found.mean(axis=1)


def continued(tied: TiedSections, body: CutBody, heights: Floats) -> Floats:
    """Return heights above a blade that continues the surface of tied sections close to it.

    Of sections of cuts that adjoin, all are continued or none: a surface that is partly the
    former one would not meet its end.

    Args:
        body: Elements that exist.
        heights: Of all nodes above the blade [m], shape (node,).
    """
    heights = along_interfaces(tied, body, heights)
    tied = tied.some(tied.interface < 0)
    if not len(tied):
        return heights
    away = np.abs(tied.values(body, heights[:, None])[..., 0].mean(axis=1)).max(axis=1)
    is_near = away < CONTINUED * tied.size
    nodes = tied.nodes(body)
    flat = nodes.reshape(len(nodes), -1)
    flat = np.where(flat < 0, flat[:, :1], flat)
    pairs = np.stack(np.broadcast_arrays(flat[:, :1], flat[:, 1:]), axis=-1)
    group = pieces(len(heights), pairs.reshape(-1, 2))
    own = np.setdiff1d(flat, np.flatnonzero(np.isin(group, group[flat[~is_near, 0]])))
    known = tied.heights[own]
    facing = np.bincount(group[own], known * heights[own], len(heights))[group[own]]
    found = heights.copy()
    found[own] = np.where(facing < 0.0, -known, known)
    return found


def along_interfaces(tied: TiedSections, body: CutBody, heights: Floats) -> Floats:
    """Return heights above a blade, 0 at nodes of interfaces that are close to it.

    Args:
        body: Elements that exist.
        heights: Of all nodes above the blade [m], NaN of nodes without, shape (node,).
    """
    tied = tied.some(tied.interface >= 0)
    if not len(tied):
        return heights
    ends = np.take_along_axis(tied.nodes(body), tied.roots, axis=2)
    here = (tied.shares > 0.0).any(axis=2)  # corners of the face
    away = np.where(here, np.abs(heights[ends]), 0.0).max(axis=(1, 2))
    is_near = away < CONTINUED * tied.size
    found = heights.copy()
    found[ends[is_near][here[is_near]]] = 0.0
    return found


def tied_apart(
    state: "State", division: Division, heights: Floats
) -> tuple[Floats, TiedSections, Indices]:
    """Divide elements, all of whose sections are tied; the state is changed in place.

    Args:
        heights: Of all nodes above the surface [m], shape (node,).

    Returns:
        Heights with those of copies, what is tied, which is not in the state yet, and what is
        lost, shape (n,).
    """
    old, new, edges = carry_out_tied(state, division, heights)
    return new.heights, old.followed_by(new, division.body), np.union1d(division.lost, edges)


def among(body: CutBody, entities: Indices) -> tuple[Bools, ...]:
    """Return which elements of a body are some, shape (part,) each."""
    return tuple(np.isin(each, entities) for each in body.entities)


def met_sections(
    parts: CellParts, entities: Indices, heights: Floats, position: Floats, blade: Blade
) -> tuple[Indices, Floats, Floats, Floats]:
    """Return which elements of a shape a blade meets, where along its edge, and how much.

    Args:
        parts: Elements of the shape.
        entities: Of these, shape (part,).
        heights: Of all nodes above the blade [m], shape (node,).
        position: Of all nodes [m], shape (node, 3).

    Returns:
        Entities, shares of the edge at which their sections begin and end, and shares of the
        sections within the blade, shape (n,) each.
    """
    corners = parts.nodes[:, : len(parts.division.corners)]
    ahead, on = heights[corners] >= 0.0, heights[corners] == 0.0
    # Where the blade lies between two elements, both have their face as a section.
    touches = ahead.all(axis=1) & (on.sum(axis=1) >= parts.division.dimension)
    crossed = np.flatnonzero((ahead.any(axis=1) & ~ahead.all(axis=1)) | touches)
    own, side = corners[crossed], np.where(touches[crossed], -1.0, 1.0)[:, None]
    met = met_edges(position[own], parts.division.edges, side * heights[own], blade.normal, 0.0)
    plain = blade.plain(met.mixed(position[own]))
    covered, ends = np.ones(len(crossed)), np.zeros((2, len(crossed)))
    if any(blade.limited) and len(crossed):
        covered = _within(plain, blade.limited)
    if blade.limited[0] and len(crossed):
        along = np.clip(plain[:, :, 0], 0.0, 1.0)
        ends = np.stack([along.min(axis=1), along.max(axis=1)])
    return entities[crossed], ends[0], ends[1], covered


def _within(plain: Floats, limited: tuple[bool, bool]) -> Floats:
    """Return which parts of polygons or lines are within a blade, shape (section,).

    Args:
        plain: p and q of their corners in order, shape (section, corner, 2).
        limited: Whether p and q are limited.
    """
    if plain.shape[1] == 2:
        return np.diff(parts_of_lines(plain, limited), axis=1)[:, 0]
    return shares_of_polygons(plain, limited)


def resistances(network: Network, body: str, groups: Sequence[CellParts]) -> list[Floats]:
    """Return the cutting resistance of parts [J/m²], shape (part,) each.

    Args:
        body: Its name.
        groups: Parts of its cells, those of each shape.
    """
    found = list[Floats]()
    for field, parts in zip(network.elements_of(body), groups, strict=True):
        known = None
        if network.cutting is not None:
            known = network.cutting.elements.get(field.block.name)
        found.append(np.zeros(len(parts)) if known is None else known[parts.cell])
    return found


class ElementCut(Struct, frozen=True, eq=False):
    """A cut through elements; see ``verbs.cut.Cut``.

    Attributes:
        body: Name of the solid or wall.
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
        """Return the name of the cut, the key of its ``BladeWay`` while blades close."""
        return f"{self.span.place} {self.time!r}"

    def apply(self, state: "State", queue: EventQueue) -> tuple[LoggedEvent, ...]:
        """Carry out the cut, or begin it.

        Raises:
            ActionFailed: The reserve of the body is exhausted.
        """
        way = BladeWay.of(state, self.way, self.body, self.blade)
        if way is None:
            note = f"{sentence(self.span)}: no element to divide"
            return (LoggedEvent("note", (), note, self.span),)
        if self.profile is None:
            return self._divide(state, way, 1.0)[1]
        state.blades = {**state.blades, self.way: way}
        surface = None if state.network.cutting is None else way.surface
        return (begin_closing(self, self.profile, way.steps, surface, state, queue),)

    def until(self, state: "State", share: float) -> tuple[LoggedEvent, ...]:
        """Divide elements up to a share of the edge.

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
        before, after = way.taken(way.reached), way.taken(share)
        area, energy = after[0] - before[0], after[1] - before[1]
        with stopping(self.span):
            division = way.until(state, share)
            rest, lost = way.divide(state, division, share)
        if division is None and area == 0.0:
            return rest, ()
        return rest, (cut_event(self.span, lost, area, energy),)
