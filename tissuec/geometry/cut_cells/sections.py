"""Facets of cut surfaces, which belong to a part in front and to one behind.

Those of cuts through solids are triangles, those of cuts through walls lines.

Where the surface is a face between two cells, these are parts of different cells.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from tissuec.geometry.cut_cells.clipping import are_flat
from tissuec.geometry.cut_cells.joining import LEAST_SHARED, PartFaces, sides_fit
from tissuec.geometry.cut_cells.overlaps import offsets, overlaps, turned_areas
from tissuec.geometry.cut_cells.parts import CellParts, Sides, functions_at
from tissuec.geometry.cut_cells.roots import CellDivision, parity
from tissuec.model.network import Floats, Indices


class CutFacets(Struct, frozen=True, eq=False):
    """Facets of a cut.

    Triangles turn to the left as seen from the front; lines have it on their right.

    Attributes:
        parts: In front and behind, shape (facet, 2).
        roots: Corners of the cells of both that are those of a root, shape
            (facet, 2, corner of the root).
        shares: Of these in each corner, of the same points of matter, shape
            (facet, 2, corner, corner of the root).
    """

    parts: Indices
    roots: Indices
    shares: Floats

    def __len__(self) -> int:
        return len(self.parts)

    @classmethod
    def none(cls, division: CellDivision) -> "CutFacets":
        """Return no facets in cells of a shape."""
        size, index = division.dimension, np.zeros((0, 2), dtype=np.int64)
        roots = np.zeros((0, 2, size + 1), dtype=np.int64)
        return cls(index, roots, np.zeros((0, 2, size, size + 1)))

    @classmethod
    def together(cls, some: "Sequence[CutFacets]") -> "CutFacets":
        """Return all of some facets."""
        names = ("parts", "roots", "shares")
        return cls(*(np.concatenate([getattr(each, name) for each in some]) for name in names))

    def shifted(self, by: int) -> "CutFacets":
        """Return facets whose parts have higher numbers."""
        return CutFacets(self.parts + by, self.roots, self.shares)

    def places(self, groups: Sequence[CellParts], position: Floats, side: int = 0) -> Floats:
        """Return the places of corners [m], shape (facet, corner, 3).

        Args:
            groups: Parts of cells, those of each shape.
            position: Of the nodes of parts, in the numbers of ``CellParts.nodes`` [m], shape
                (node, 3).
            side: 0 for those in front, 1 for those behind.
        """
        found = np.zeros((len(self), self.shares.shape[2], position.shape[1]))
        first = offsets(groups)
        for each, low, high in zip(groups, first[:-1], first[1:], strict=True):
            own = np.flatnonzero((self.parts[:, side] >= low) & (self.parts[:, side] < high))
            corners = each.division.corners[self.roots[own, side]]
            xi = self.shares[own, side] @ corners
            weights = functions_at(each.shape, xi).values
            found[own] = weights @ position[each.nodes[self.parts[own, side] - low]]
        return found

    def sizes(self, groups: Sequence[CellParts], position: Floats) -> Floats:
        """Return areas of triangles [m²], or lengths of lines [m], shape (facet,).

        Args:
            groups, position: As of ``places``.
        """
        return facet_sizes(self.places(groups, position))


def facet_sizes(places: Floats) -> Floats:
    """Return areas of triangles [m²], or lengths of lines [m], shape (facet,).

    Args:
        places: Of their corners [m], shape (facet, corner, 3).
    """
    first, *others = places.swapaxes(0, 1)
    if len(others) == 1:
        return np.asarray(np.linalg.norm(others[0] - first, axis=1))
    return 0.5 * np.linalg.norm(np.cross(*(each - first for each in others)), axis=1)


def facing_facets(groups: Sequence[CellParts], faces: PartFaces, sign: Sides) -> CutFacets:
    """Return the facets of faces which lie in a level.

    Args:
        groups: Parts of cells, those of each shape.
        faces: Those of parts on different sides.
        sign: Of all parts: 1 in front, -1 behind, shape (part,).
    """
    first = offsets(groups)
    chosen = np.zeros(first[-1], dtype=bool)
    chosen[faces.parts] = True
    found = overlaps(groups, np.split(chosen, first[1:-1]))
    opposed = sign[found.parts[:, 0]] * sign[found.parts[:, 1]] < 0
    kept = np.flatnonzero(
        opposed & sides_fit(groups, found.parts) & (found.fraction > LEAST_SHARED)
    )
    parts, shares, roots = found.parts[kept], found.shares[kept], found.roots[kept]
    back_first = (sign[parts[:, 0]] < 0)[:, None]
    pair = np.where(back_first, parts[:, ::-1], parts)
    roots = np.where(back_first[..., None], roots[:, ::-1], roots)
    behind = np.where(back_first[:, 0], 0, 1)
    face = found.faces[kept, behind]
    # As seen from outside of the cell behind, which is from the front.
    turn = np.zeros(len(kept), dtype=np.int64)
    for each, low, high in zip(groups, first[:-1], first[1:], strict=True):
        own = np.flatnonzero((pair[:, 1] >= low) & (pair[:, 1] < high))
        ring = each.division.faces[face[own]]
        place = (ring[:, None, :] == roots[own, 1][..., None]).argmax(axis=2)
        turn[own] = parity(np.argsort(place, axis=1))
    return _fans(pair, roots, shares, turn)


def _fans(pair: Indices, roots: Indices, shares: Floats, turn: Indices) -> CutFacets:
    """Return the facets of polygons in roots of faces, with another corner of no share."""
    left = turn * turned_areas(shares) < 0.0
    shares = np.where(left[:, None, None], shares[:, ::-1], shares)
    size, count = shares.shape[2], shares.shape[1]
    fans = np.array([[0, *range(k, k + size - 1)] for k in range(1, count - size + 2)])
    every = shares[:, fans.reshape(-1, size)]
    of, which = np.nonzero(~are_flat(every))
    padded = np.concatenate([every[of, which], np.zeros((len(of), size, 1))], axis=2)
    corners = np.concatenate([roots[of], roots[of][..., :1]], axis=2)
    return CutFacets(pair[of], corners, np.repeat(padded[:, None], 2, axis=1))
