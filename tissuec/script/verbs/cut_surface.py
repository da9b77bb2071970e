"""Blades of cuts, and the surface of a cut: its area, energy, and the force of blades.

Springs account for their sections, see ``model.resistance``; elements for the part of the blade
that lies within them. A blade p, q meets the edges of a solid element in the corners of a
polygon, and a triangle of a wall in a line, which is as thick as the wall. Points on edges are
as far along them when drawn, so that the ratio of drawn to present area is known. While a blade
closes along p, each polygon takes the energy of its area in proportion to its width at p, so
that the force is that of the width of all tissue at the blade.

A spring is crossed where its ends lie on different sides of the plane and the point in between
lies within the part. A node on the plane, to within a billionth of the size of the scene,
counts as in front of it, so that a plane through a ring of nodes cuts the springs behind the
ring and no others, whatever rounding did to the nodes.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import SAME_PLACE
from tissuec.geometry.blade_sections import (
    SectionWidths,
    met_edges,
    parts_of_lines,
    polygon_areas,
    shares_of_polygons,
    thick_lines,
)
from tissuec.mechanics.state import State
from tissuec.model.edges import without
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.model.resistance import ClosingForce

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.forces.surfaces.membranes import Membranes

ON_PLANE = SAME_PLACE


class Blade(Struct, frozen=True, eq=False):
    """The points origin + p first + q second.

    Attributes:
        origin: [m], shape (3,).
        normal: Unit vector, the front of the blade, shape (3,).
        spans: Two vectors in the plane [m], shape (2, 3).
        limited: Whether p and q are confined to 0…1.
    """

    origin: Floats
    normal: Floats
    spans: Floats
    limited: tuple[bool, bool]

    def heights(self, points: Floats) -> Floats:
        """Return heights of points above its plane [m], shape (…,), of shape (…, 3) [m]."""
        return np.asarray((points - self.origin) @ self.normal)

    def plain(self, points: Floats) -> Floats:
        """Return p and q of points, dimensionless, shape (…, 2), of shape (…, 3) [m]."""
        return np.asarray((points - self.origin) @ np.linalg.pinv(self.spans))

    def crosses(
        self, first: Floats, second: Floats, size: float
    ) -> tuple[NDArray[np.bool_], Floats]:
        """Return which segments the blade goes through, and p there, each of shape (segment,).

        Args:
            first, second: Ends of the segments [m], each of shape (segment, 3).
            size: Largest side of the scene [m].
        """
        ahead, behind = self.heights(first), self.heights(second)
        is_across = (ahead >= -ON_PLANE * size) != (behind >= -ON_PLANE * size)
        step = np.where(is_across, ahead - behind, 1.0)
        fraction = np.clip(ahead / step, 0.0, 1.0)[:, None]
        share = self.plain(first + fraction * (second - first))
        for axis, is_limited in enumerate(self.limited):
            if is_limited:
                is_across &= np.abs(share[:, axis] - 0.5) <= 0.5 + ON_PLANE
        return is_across, share[:, 0]


def plane(through: Floats, facing: Floats) -> Blade:
    """Return a whole plane.

    Args:
        through: A point of it [m], shape (3,).
        facing: Its normal, a unit vector, shape (3,).
    """
    return Blade(through, facing, np.zeros((2, 3)), (False, False))


def stroke(start: Floats, stop: Floats, by: Floats) -> Blade | None:
    """Return the parallelogram that an edge sweeps; None if it has no area.

    Args:
        start: One end of the edge [m], shape (3,).
        stop: The other end [m], shape (3,).
        by: Displacement of the edge [m], shape (3,).
    """
    spans = np.array([stop - start, by])
    normal = np.cross(*spans)
    area = np.linalg.norm(normal)
    if area <= ON_PLANE * np.prod(np.linalg.norm(spans, axis=1)):
        return None
    return Blade(start, normal / area, spans, (True, True))


def strip(start: Floats, stop: Floats, facing: Floats) -> Blade | None:
    """Return the endless strip in the plane facing a direction, between the ends of a line.

    Args:
        start: One end of the line [m], shape (3,).
        stop: The other end [m], shape (3,).
        facing: Normal of the plane, of any length and unit, shape (3,).

    Returns:
        The strip; None where the line has no length or does not lie in such a plane.
    """
    along = stop - start
    length = np.linalg.norm(along)
    if length == 0.0 or abs(along @ facing) > 1e-6 * length:
        return None
    # The line counts exactly; what is left of a slant in the direction is taken out of it.
    facing = facing - (facing @ along) / length**2 * along
    facing = facing / np.linalg.norm(facing)
    return Blade(start, facing, np.array([along, np.cross(facing, along)]), (True, False))


class CutSurface(Struct, frozen=True, eq=False):
    """Parts of a cut through matter with a resistance.

    Attributes:
        areas: As drawn [m²], shape (part,).
        energies: That they take [J], shape (part,).
        shares: Between which shares of the edge of the blade each takes it, shape (piece, 2).
        rates: Energies per share at both ends of the pieces [J], shape (piece, 2).
    """

    areas: Floats
    energies: Floats
    shares: Floats
    rates: Floats

    @classmethod
    def even(
        cls, areas: Floats, energies: Floats, low: Floats | float, high: Floats | float
    ) -> "CutSurface":
        """Return parts that take their energies evenly between two shares of the edge.

        The energy of a part beyond the ends is taken within them.

        Args:
            areas: [m²], shape (part,).
            energies: [J], shape (part,).
            low, high: Shares, low < high, shape (part,).
        """
        low, high = (np.broadcast_to(one, areas.shape) for one in (low, high))
        shares = np.clip(np.stack([low, high], axis=1), 0.0, 1.0)
        way = shares[:, 1] - shares[:, 0]
        rates = np.where(way > 0.0, energies, 0.0) / np.where(way > 0.0, way, 1.0)
        return cls(areas, energies, shares, np.repeat(rates[:, None], 2, axis=1))

    @classmethod
    def of_widths(cls, areas: Floats, energies: Floats, widths: SectionWidths) -> "CutSurface":
        """Return parts that take their energies in proportion to their width at the edge.

        Args:
            areas: [m²], shape (part,).
            energies: [J], shape (part,).
            widths: Of as many polygons.
        """
        whole = widths.areas
        scale = np.where(whole > 0.0, energies, 0.0) / np.where(whole > 0.0, whole, 1.0)
        marks, rates = widths.marks, scale[:, None, None] * widths.widths
        shares = np.stack([marks[:, :-1], marks[:, 1:]], axis=2)
        return cls(areas, energies, shares.reshape(-1, 2), rates.reshape(-1, 2))

    @property
    def energy(self) -> float:
        """Return the energy of all parts [J]."""
        return float(self.energies.sum())

    @property
    def area(self) -> float:
        """Return the area of all parts [m²]."""
        return float(self.areas.sum())

    def force(self, tool: str, blade: Blade, profile: TimeProfile) -> ClosingForce:
        """Return the force of a blade that closes.

        Args:
            tool: The scissors.
            profile: Of its way, from 0 to 1.
        """
        return ClosingForce.of(tool, blade.spans[0], profile, self.shares, self.rates)


def cut_surface(state: State, lines: Indices, blade: Blade | None) -> CutSurface:
    """Return the surface that is made when lines are cut.

    Args:
        state: Before the cut.
        lines: Springs and edges of elements that a blade crosses, shape (n,).
        blade: None where they are removed without one.
    """
    parts = [_of_springs(state, state.network.springs_among(lines), blade)]
    alive = without(state.network, state.alive, lines)
    resistance = state.network.cutting
    assert resistance is not None
    for name, block in state.blocks.items():
        if name not in resistance.elements:
            continue
        field, each = block.field, resistance.elements[name]
        lost = np.setdiff1d(field.lost_items(alive), field.lost_items(state.alive))
        lost = lost[each[lost] > 0.0]
        if len(lost):
            parts.append(_of_elements(state, field, lost, each[lost], blade))
    return CutSurface(*(np.concatenate(one) for one in zip(*map(_columns, parts), strict=True)))


def _columns(surface: CutSurface) -> tuple[Floats, Floats, Floats, Floats]:
    return surface.areas, surface.energies, surface.shares, surface.rates


def _of_springs(state: State, springs: Indices, blade: Blade | None) -> CutSurface:
    resistance = state.network.cutting
    assert resistance is not None
    own = springs[resistance.springs[springs] > 0.0]
    first, second = state.position[state.springs.ends[own]].swapaxes(0, 1)
    areas, low, high = resistance.areas[own], 0.0, 1.0
    if blade is not None and blade.limited[0]:
        length = np.linalg.norm(second - first, axis=1)
        share = blade.crosses(first, second, state.network.extent)[1]
        half = 0.5 * length / np.linalg.norm(blade.spans[0])
        low, high = share - half, share + half
    return CutSurface.even(areas, areas * resistance.springs[own], low, high)


def _of_elements(
    state: State,
    field: "SolidElements | Membranes",
    items: Indices,
    each: Floats,
    blade: Blade | None,
) -> CutSurface:
    """Return the surface of elements.

    Args:
        items: Which of them, shape (n,).
        each: Their resistance [J/m²], shape (n,).
        blade: None for cracks through whole elements.
    """
    from tissuec.forces.solids.elements import SolidElements  # where there are any
    from tissuec.forces.surfaces.membranes import EDGES

    if blade is None:
        areas = field.crack_areas[items]
        return CutSurface.even(areas, each * areas, 0.0, 1.0)
    nodes = field.nodes[items]
    corners, drawn = state.position[nodes], state.network.position[nodes]
    height = blade.heights(corners)
    edges = field.shape.edges if isinstance(field, SolidElements) else EDGES
    met = met_edges(corners, edges, height, blade.normal, -ON_PLANE * state.network.extent)
    drawn_points, points = met.mixed(drawn), met.mixed(corners)
    plain = blade.plain(points)
    if not isinstance(field, SolidElements):
        row = np.arange(len(nodes))[:, None, None]
        pairs = np.sort(nodes[row, met.ends], axis=2).reshape(-1, 2)
        shared = np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1, 2)
        thickness = field.thickness[items]
        areas = thickness * np.linalg.norm(drawn_points[:, 1] - drawn_points[:, 0], axis=1)
        return surface_of_lines(areas, plain, shared, thickness, each, blade)
    return surface_of_polygons(polygon_areas(drawn_points), plain, each, blade)


def surface_of_polygons(areas: Floats, plain: Floats, each: Floats, blade: Blade) -> CutSurface:
    """Return the surface of a cut through a solid.

    Args:
        areas: Of the sections of an unlimited blade, as drawn [m²], shape (polygon,).
        plain: p and q of their corners in order, shape (polygon, corner, 2).
        each: Resistance [J/m²], shape (polygon,).
    """
    if any(blade.limited):
        areas = areas * shares_of_polygons(plain, blade.limited)
    if not blade.limited[0]:
        return CutSurface.even(areas, each * areas, 0.0, 1.0)
    return CutSurface.of_widths(areas, each * areas, SectionWidths.of(plain, blade.limited))


def surface_of_lines(
    areas: Floats,
    plain: Floats,
    shared: Indices,
    thickness: Floats,
    each: Floats,
    blade: Blade,
) -> CutSurface:
    """Return the surface of a cut through a wall, which is as thick as the wall.

    Args:
        areas: Of the sections of an unlimited blade, as drawn [m²], shape (line,).
        plain: p and q of the ends of their middle lines, shape (line, 2, 2).
        shared: Numbers of the ends, equal ones in equal places, shape (line, 2).
        thickness: Of the wall [m], shape (line,).
        each: Its resistance [J/m²], shape (line,).
    """
    part = parts_of_lines(plain, blade.limited)
    areas = areas * (part[:, 1] - part[:, 0])
    if not blade.limited[0]:
        return CutSurface.even(areas, each * areas, 0.0, 1.0)
    # What ends at a limit has no neighbour.
    alone = np.arange(shared.size).reshape(-1, 2) + shared.max(initial=0) + 1
    shared = np.where(part == [0.0, 1.0], shared, alone)
    cut = (plain[:, :1] + part[..., None] * (plain[:, 1:] - plain[:, :1])) @ blade.spans
    first = blade.spans[0] / np.linalg.norm(blade.spans[0])
    across: Floats = np.array([first, np.cross(blade.normal, first)], dtype=float)
    thick = thick_lines(cut, shared, across, thickness) @ np.linalg.pinv(blade.spans)
    widths = SectionWidths.of(thick, (True, False))
    return CutSurface.of_widths(areas, each * areas, widths)
