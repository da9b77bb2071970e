"""Cavities in solids that blades have divided: which faces of cuts their fluid wets, and leaks.

Free faces of cuts that join each other at edges bound a *way*. It may meet the wall of a
cavity, the outer surface, or the wall of another cavity. A fluid fills the ways that meet its
cavity alone; their faces belong to its wall. Where a way leads further, the cavity leaks. There
is no way between faces that are still tied together.
"""

from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.forces.enclosed.fluids import FluidCavities
from tissuec.forces.enclosed.pressed_faces import PressedFaces
from tissuec.mechanics.cut_faces import CutFaces
from tissuec.mechanics.cut_surfaces import part_triangles
from tissuec.model.cut_cells import PartTriangles, solid_entities
from tissuec.model.network import Floats, Indices, numbers_in
from tissuec.model.topology import pieces

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
SAME_PLACE = 1e-9  # of weights: riding points of several elements that are one point


class HeldVolumes(NamedTuple):
    """Volumes of cavities before a division.

    Attributes:
        fluid: The cavities.
        every: Volumes [m³], shape (cavity,).
        within: Those within walls, without what is in cuts [m³], shape (cavity,).
    """

    fluid: FluidCavities
    every: Floats
    within: Floats

    @classmethod
    def of(cls, state: "State", fluid: FluidCavities) -> Self:
        """Return the present volumes of cavities."""
        return cls(fluid, fluid.volumes(state.position), _volumes_within(state, fluid))

    def keep_pressures(self, state: "State") -> None:
        """Change drawn volumes as a division has changed present ones, in place.

        Of walls that are curved or warped, parts are flat.
        """
        more = _volumes_within(state, self.fluid) - self.within
        drawn = self.fluid.drawn * (1.0 + more / self.every)
        state.put(replace(self.fluid, drawn=drawn).block)


def _volumes_within(state: "State", fluid: FluidCavities) -> Floats:
    """Return volumes within walls, which caps close beside cuts [m³], shape (cavity,)."""
    if state.cut_cells is not None:
        parts = _of_solids(state, part_triangles(state))
        fluid = fluid.bounded_by(state.network, *_walls(state, fluid, parts))
    return fluid.volumes(state.position)


def cavities_on_parts(
    state: "State", fluid: FluidCavities, parts: PartTriangles
) -> FluidCavities:
    """Return cavities after cuts, with faces of cuts that they wet; those that leak are torn.

    Args:
        fluid: The cavities, each of which held its fluid before.
        parts: Triangles that bound the parts of all solids.
    """
    cells, skin = state.cut_cells, state.network.skin
    assert cells is not None
    parts = _of_solids(state, parts)
    faces, cavity = _walls(state, fluid, parts)
    cut = parts.chosen(parts.cuts != 0)
    rest = parts.chosen((parts.skin >= 0) & ~np.isin(parts.skin, fluid.faces.rows))
    others = ~_are_divided(state)
    others[fluid.faces.rows] = False
    around = np.concatenate([faces.corners, skin[others].astype(np.int64), rest.corners])
    beside = np.append(cavity, np.full(len(around) - len(cavity), -1))
    way, met = _ways(cut.corners, _are_free(state, parts)[parts.cuts != 0], around, beside)
    filled = np.array([each[0] if len(each) == 1 else -1 for each in met], dtype=np.int64)
    torn = [
        (one, entity)
        for number, each in enumerate(met)
        if len(each) > 1
        for one in each[each >= 0]
        for entity in np.unique(cells.wholes_of(cut.parts[way == number]))
    ]
    wets = filled[way]
    own = wets >= 0
    return fluid.bounded_by(
        state.network, faces.joined_with(cut.chosen(own)), np.append(cavity, wets[own]),
        np.array(torn, dtype=np.int64).reshape(-1, 2),
    )  # fmt: skip


def _walls(
    state: "State", fluid: FluidCavities, parts: PartTriangles
) -> tuple[PressedFaces, Indices]:
    """Return the walls of cavities without faces of cuts, and the cavity of each triangle."""
    return fluid.wall_on(parts, _are_divided(state))


def _are_divided(state: "State") -> Bools:
    """Return which triangles of the skin of solids have parts, shape (triangle,)."""
    assert state.cut_cells is not None
    elements = state.network.skin_elements
    assert elements is not None, "solids that are cut have them"
    wholes = state.cut_cells.wholes
    return np.isin(elements, wholes[np.isin(wholes, solid_entities(state.network))])


def _of_solids(state: "State", parts: PartTriangles) -> PartTriangles:
    """Return triangles of parts of solids, with common corners where they meet.

    A wall that is divided leaks in any case.
    """
    assert state.cut_cells is not None
    wholes = state.cut_cells.wholes_of(parts.parts)
    own = parts.chosen(np.isin(wholes, solid_entities(state.network)))
    return replace(own, corners=_shared_corners(state)[own.corners])


def _shared_corners(state: "State") -> Indices:
    """Return each node, riders at one point by the first of them, shape (node,)."""
    cells, riders = state.cut_cells, state.riders
    assert cells is not None
    assert riders is not None
    found = np.arange(state.network.node_count)
    points = cells.points.some(riders >= 0)
    if not len(points):
        return found
    riders, place = riders[riders >= 0], counted_up(points.counts)
    hosts = np.full((len(points), int(points.counts.max())), -1)
    weights = np.zeros(hosts.shape, dtype=np.int64)
    hosts[points.owners, place] = points.hosts
    weights[points.owners, place] = np.round(points.weights / SAME_PLACE)
    keys = np.concatenate([hosts, weights], axis=1)
    _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    found[riders] = riders[first[same.reshape(-1)]]
    return found


def _are_free(state: "State", parts: PartTriangles) -> Bools:
    """Return which corners of faces of cuts no tie holds, shape (triangle, 3)."""
    found = np.zeros(parts.corners.shape, dtype=bool)
    for body in state.cut_bodies:
        phantoms, faces = state.network.phantoms_of(body), CutFaces.of(state, body)
        assert phantoms is not None
        assert faces is not None
        own = (parts.cuts != 0) & np.isin(parts.parts, numbers_in(phantoms.elements))
        found[own] = faces.are_free
    return found


def _ways(
    corners: Indices, are_free: Bools, around: Indices, beside: Indices
) -> tuple[Indices, list[Indices]]:
    """Return the way that each face of a cut bounds, and what each way meets, ascending.

    A way leads across an edge of a face one of whose ends is free.

    Args:
        corners: Of faces of cuts, shape (face, 3).
        are_free: Which of these no tie holds, shape (face, 3).
        around: Corners of the skin, shape (triangle, 3).
        beside: The cavity whose wall each of these is, -1 of none, shape (triangle,).
    """
    both = np.concatenate([corners, around])
    pairs = np.sort(np.stack([both, np.roll(both, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    _, edge = np.unique(pairs, axis=0, return_inverse=True)
    edge = edge.reshape(-1, 3)
    leads = are_free | np.roll(are_free, -1, axis=1)
    count = len(corners)
    links = np.stack([np.nonzero(leads)[0], count + edge[:count][leads]], axis=1)
    piece = pieces(count + int(edge.max(initial=-1)) + 1, links.astype(np.int32))
    number, way = np.unique(piece[:count], return_inverse=True)
    met = np.stack([piece[count + edge[count:].ravel()], np.repeat(beside, 3)], axis=1)
    met = np.unique(met, axis=0)
    first, last = (np.searchsorted(met[:, 0], number, side) for side in ("left", "right"))
    ends = zip(first.tolist(), last.tolist(), strict=True)
    return way.reshape(-1), [met[one:other, 1] for one, other in ends]
