"""The bending of walls that blades have divided.

A triangle stores the energy of its folds (``surfaces.plates``). A part of it with the share f
of its area stores f times as much, by the folds at the edges where it holds together with parts
of neighbours. Such a part may be small: where it has the share g < f of its triangle, it holds
on to the edge only as far as h = g/f, otherwise h = 1. With the flexibility S = K⁻¹ of the
whole triangle, a part has

    K' = f (S + diag c)⁻¹,    c_i = (1/h_i - 1) S_ii,

springs in series with the folds. An edge that holds on to nothing, h = 0, is free, and has no
moment. K'_ii is at most 2 min(f, g) K_ii, so that stiffness is small where mass is. If several
parts of a neighbour share an edge with one, it stores the mean of the energies with each of
them, by the lengths that they share. (Derived here.)
"""

from typing import NamedTuple

import numpy as np

from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.forces.surfaces.membranes import Membranes
from tissuec.forces.surfaces.plates import Plates
from tissuec.geometry.cut_cells.joining import PartFaces, part_faces
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices


class _Holds(NamedTuple):
    """Where parts hold together at an edge of the first.

    Attributes:
        part: Ascending, shape (hold,).
        beside: The other part, shape (hold,).
        tip: Its node that is not on the edge, shape (hold,).
        share: Of the length that the part shares with others at this edge, shape (hold,).
    """

    part: Indices
    beside: Indices
    tip: Indices
    share: Floats

    @classmethod
    def at(cls, edge: int, parts: CellParts, joins: PartFaces) -> "_Holds":
        """Return those at the edge opposite to a corner of parts."""
        pair, end = np.nonzero(joins.faces == edge)
        part, beside = joins.parts[pair, end], joins.parts[pair, 1 - end]
        order = np.argsort(part, kind="stable")
        tip = parts.nodes[beside, joins.faces[pair, 1 - end]]
        total = np.bincount(part, joins.fraction[pair], len(parts))
        every = part, beside, tip, joins.fraction[pair] / total[part]
        return cls(*(each[order] for each in every))


def plates_beside_cuts(
    plates: Plates, wall: Membranes, parts: CellParts, entities: Indices, lost: Indices
) -> FieldBlock | None:
    """Return the bending of triangles whose drawn plates no longer act; None without any.

    Args:
        plates: Of the drawn wall.
        wall: Its triangles.
        parts: Triangles and parts that exist after a cut.
        entities: Of these parts, shape (part,).
        lost: Plates that act no longer, ascending, shape (n,).
    """
    item = np.flatnonzero(np.isin(parts.cell, _divided(plates, wall, parts, lost)))
    near = np.isin(parts.nodes, parts.nodes[item]).any(axis=1)
    joins = part_faces([parts], [near])
    share, tips = parts.fractions[item], parts.nodes[item]
    beside = np.full((len(item), 3), -1)
    for edge in range(3):
        holds = _Holds.at(edge, parts, joins)
        first = np.searchsorted(holds.part, item)
        count = np.searchsorted(holds.part, item, side="right") - first
        # Where more than two triangles meet, there is no hinge as drawn.
        count *= plates.is_hinge[parts.cell[item], edge]
        copies = np.maximum(count, 1)
        again = np.repeat(np.arange(len(item)), copies)
        own = (first[again] + counted_up(copies))[count[again] > 0]
        has = np.flatnonzero(count[again])
        item, share, tips, beside = item[again], share[again], tips[again], beside[again]
        tips[has, edge], beside[has, edge] = holds.tip[own], holds.beside[own]
        share[has] *= holds.share[own]
    kept = (beside >= 0).any(axis=1)
    item, share, tips, beside = (each[kept] for each in (item, share, tips, beside))
    if not len(item):
        return None
    cell, is_held = parts.cell[item], beside >= 0
    held = np.where(is_held, parts.fractions[beside], 0.0)
    every = np.column_stack([item, beside])
    there = every >= 0
    made = replace(
        plates.only(cell), walls=entities[every[there]], walled=np.nonzero(there)[0],
        nodes=np.concatenate([parts.nodes[item], tips], axis=1),
        stiffness=held_stiffness(plates.stiffness[cell], share, held),
    )  # fmt: skip
    return replace(plates.block, name=f"{plates.block.name} beside cuts", field=made)


def held_stiffness(stiffness: Floats, share: Floats, held: Floats) -> Floats:
    """Return K' of parts of triangles [N m], shape (part, 3, 3).

    Args:
        stiffness: K of the triangles [N m], zero for edges without a neighbour, shape
            (part, 3, 3).
        share: f, dimensionless, shape (part,).
        held: g at each edge, 0 where there is nothing, shape (part, 3).
    """
    hold, every = np.minimum(held / share[:, None], 1.0), np.arange(3)
    none = stiffness[:, every, every] == 0.0
    soft = stiffness.copy()
    soft[:, every, every] += none
    soft = np.linalg.inv(soft)
    soft[:, every, every] /= np.where(hold > 0.0, hold, 1.0)
    is_held = (hold > 0.0) & ~none
    both = is_held[:, :, None] & is_held[:, None, :]
    soft = np.where(both | np.eye(3, dtype=bool), soft, 0.0)
    return share[:, None, None] * np.where(both, np.linalg.inv(soft), 0.0)


def _divided(plates: Plates, wall: Membranes, parts: CellParts, lost: Indices) -> Indices:
    """Return the lost plates whose triangles are all there, or parts of them, ascending."""
    there = np.zeros(wall.item_count, dtype=bool)
    there[parts.cell] = True
    triangle = plates.walls - wall.walls[0]
    own = triangle >= 0  # others are edges
    bare = plates.walled[own][~there[triangle[own]]]
    return np.setdiff1d(lost, bare)
