"""The surface of a cut: its area as drawn, the energy that it takes, and the force of blades.

Springs account for their sections, see ``model.cutting``; elements for the part of the blade
that lies within them. A blade p, q meets the edges of a solid element in the corners of a
polygon, and a triangle of a wall in a line, which is as thick as the wall. Points on edges are
as far along them when drawn, so that the ratio of drawn to present area is known.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from tissuec.geometry.blade_sections import (
    met_edges,
    polygon_areas,
    shares_of_lines,
    shares_of_polygons,
)
from tissuec.mechanics.state import State
from tissuec.model.cutting import ClosingForce
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs.blade import ON_PLANE, Blade

if TYPE_CHECKING:
    from tissuec.forces.elements import SolidElements
    from tissuec.forces.membranes import Membranes

SHORTEST = 1e-9  # share of a line over which a part of a cut is spread


class CutSurface(Struct, frozen=True, eq=False):
    """Parts of a cut through matter with a resistance.

    Attributes:
        areas: As drawn [m²], shape (part,).
        energies: That they take [J], shape (part,).
        low, high: Between which shares of the edge of the blade they lie, shape (part,).
    """

    areas: Floats
    energies: Floats
    low: Floats
    high: Floats

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
            blade: The blade.
            profile: Of its way, from 0 to 1.
        """
        middle = np.clip(0.5 * (self.low + self.high), 0.0, 1.0)
        low = np.minimum(np.clip(self.low, 0.0, 1.0), middle - SHORTEST)
        high = np.maximum(np.clip(self.high, 0.0, 1.0), middle + SHORTEST)
        return ClosingForce(tool, blade.spans[0], profile, self.energies, low, high)


def cut_surface(state: State, springs: Indices, blade: Blade | None) -> CutSurface:
    """Return the surface that is made when springs are cut.

    Args:
        state: Before the cut.
        springs: That a blade crosses, shape (n,).
        blade: None where springs are removed without one.
    """
    parts = [_of_springs(state, springs, blade)]
    alive = state.alive.copy()
    alive[springs] = False
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
    return surface.areas, surface.energies, surface.low, surface.high


def _of_springs(state: State, springs: Indices, blade: Blade | None) -> CutSurface:
    resistance = state.network.cutting
    assert resistance is not None
    own = springs[resistance.springs[springs] > 0.0]
    first, second = state.position[state.springs.ends[own]].swapaxes(0, 1)
    areas, low, high = resistance.areas[own], np.zeros(len(own)), np.ones(len(own))
    is_net = resistance.means[own] < 1.0
    if blade is None:
        areas = areas * np.where(is_net, resistance.means[own], 1.0)
    else:
        way = second - first
        length = np.linalg.norm(way, axis=1)
        cosine = np.abs(way @ blade.normal) / np.where(length > 0.0, length, 1.0)
        areas = areas * np.where(is_net, cosine, 1.0)
        if blade.limited[0]:
            share = blade.crosses(first, second, state.network.extent)[1]
            half = 0.5 * length / np.linalg.norm(blade.spans[0])
            low, high = share - half, share + half
    return CutSurface(areas, areas * resistance.springs[own], low, high)


def _of_elements(
    state: State,
    field: "SolidElements | Membranes",
    items: Indices,
    each: Floats,
    blade: Blade | None,
) -> CutSurface:
    """Return the surface of elements.

    Args:
        field: The elements.
        items: Which of them, shape (n,).
        each: Their resistance [J/m²], shape (n,).
        blade: None for cracks through whole elements.
    """
    from tissuec.forces.elements import SolidElements  # where there are any
    from tissuec.forces.membranes import EDGES

    if blade is None:
        areas = field.crack_areas[items]
        return CutSurface(areas, each * areas, np.zeros(len(items)), np.ones(len(items)))
    nodes = field.nodes[items]
    corners, drawn = state.position[nodes], state.network.position[nodes]
    height = (corners - blade.origin) @ blade.normal
    edges = field.shape.edges if isinstance(field, SolidElements) else EDGES
    met = met_edges(corners, edges, height, blade.normal, -ON_PLANE * state.network.extent)
    points = met.mixed(drawn)
    plain = (met.mixed(corners) - blade.origin) @ np.linalg.pinv(blade.spans)
    low, high = plain[..., 0].min(axis=1), plain[..., 0].max(axis=1)
    if isinstance(field, SolidElements):
        areas, inside = polygon_areas(points), np.ones(len(items))
        if any(blade.limited):
            inside = shares_of_polygons(plain, blade.limited)
    else:
        lengths = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        areas, inside = field.thickness[items] * lengths, shares_of_lines(plain, blade.limited)
        if blade.limited[0]:  # a wall that faces the blade is not cut at one moment
            least = np.sqrt(field.area[items]) / np.linalg.norm(blade.spans[0])
            middle, half = 0.5 * (low + high), 0.5 * np.maximum(high - low, least)
            low, high = middle - half, middle + half
    areas = areas * inside
    return CutSurface(areas, each * areas, low, high)
