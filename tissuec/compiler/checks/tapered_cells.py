"""Check of hexahedra that taper alternately, so that bodies of few of them hardly bend.

A cell with half edges A_i along and A_j through a body, and the mode g = Σ ξ_i ξ_j X/8, tapers
towards A_j by m = (g·A_i) / |A_j|². Every element of eight nodes that passes the patch
test is too stiff in bending where neighbours taper to opposite sides (R. H. MacNeal, Finite
Elements in Analysis and Design 11:307, 1992), here by about 2.4 m² / (1 + 0.45 m), which was
measured for m from 0.15 to 5. Of n layers, the m of the whole is that of one over n. Where
neighbours taper alike, as around a ring, the body is curved, and cells are far less stiff.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.arrays import dot
from tissuec.core.errors import Diagnostic
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import pieces

STIFF = 0.25  # part by which bodies that are reported are too stiff, or more


@check
def tapered(compiled: Compiled) -> Iterator[Diagnostic]:
    """W217: bodies that are much too stiff in bending, as their hexahedra taper alternately."""
    network = compiled.network
    parts = {part.name: part for part in network.bodies}
    for one in network.of_kind("elements"):
        if one.shape.name != "hexahedron" or not one.item_count:
            continue
        tapers = Tapers.of(network.position[one.nodes])
        if not (_excess(tapers.size) > STIFF).any():
            continue
        beside = _beside(one.nodes)
        excess = _excess(tapers.alternating(beside).max(axis=1) / _layers(beside))
        if (worst := float(excess.max())) <= STIFF:
            continue
        cell = int(excess.max(axis=1).argmax())
        yield Diagnostic(
            "W217",
            f"cells of {one.name} taper alternately: in bending, as at node "
            f"{network.node_ids[one.nodes[cell, 0]]}, they are about {1.0 + worst:.2g} times "
            "as stiff as the tissue",
            parts[one.name].span,
            "draw them as boxes or parallelograms, use several layers, or quadratic elements",
        )


def _excess(taper: Floats) -> Floats:
    """Return the part by which bodies are too stiff, of the shape of m."""
    return 2.4 * taper**2 / (1.0 + 0.45 * taper)


class Tapers(NamedTuple):
    """How hexahedra taper.

    Attributes:
        edges: A [m], shape (cell, 3, 3), by number and component.
        vector: m A_j / |A_j|² of each i along and j through [1/m], shape (cell, 3, 3, 3); it
            points to where the cell is longer.
    """

    edges: Floats
    vector: Floats

    @classmethod
    def of(cls, corners: Floats) -> "Tapers":
        """Return the tapers of cells with corners [m], shape (cell, 8, 3)."""
        from tissuec.geometry.bent_cells import HEXAHEDRON  # where there are hexahedra

        parts = HEXAHEDRON.shares[:6] @ corners
        edges, modes = parts[:, :3], parts[:, 3:][:, [[0, 2, 1], [2, 0, 0], [1, 0, 0]]]
        square = dot(edges, edges)
        along = np.einsum("nijc,nic->nij", modes, edges) / square[:, None] ** 2
        along[:, range(3), range(3)] = 0.0
        return cls(edges, along[..., None] * edges[:, None])

    @property
    def size(self) -> Floats:
        """Return |m|, shape (cell, 3, 3)."""
        return self._times_thickness(self.vector)

    def _times_thickness(self, vector: Floats) -> Floats:
        return np.sqrt(dot(vector, vector) * dot(self.edges, self.edges)[:, None])

    def alternating(self, beside: Indices) -> Floats:
        """Return half of the dimensionless difference of m from neighbours, shape (cell, 3, 3).

        Args:
            beside: See ``_beside``.
        """
        total, known = np.zeros_like(self.vector), np.zeros(self.vector.shape[:2])
        for side in (0, 1):
            cell, axis = np.divmod(beside[:, :, side], 3)
            for i in range(3):
                some = np.flatnonzero(beside[:, i, side] >= 0)
                other, along = cell[some, i], axis[some, i]
                # Of the neighbour, the direction that is most nearly that through this cell.
                cosine = np.abs(np.einsum("njc,nkc->njk", self.edges[some], self.edges[other]))
                cosine /= np.sqrt(dot(self.edges[other], self.edges[other]))[:, None]
                through = cosine.argmax(axis=2)
                total[some, i] += self.vector[other[:, None], along[:, None], through]
                known[some, i] += 1.0
        mean = total / np.maximum(known, 1.0)[:, :, None, None]
        apart = np.where(known[:, :, None, None] > 0.0, self.vector - mean, 0.0)
        return 0.5 * self._times_thickness(apart)


def _beside(nodes: Indices) -> Indices:
    """Return neighbours across both faces of each direction of cells, shape (cell, 3, 2).

    They are 3 times the number of the cell plus that of its direction there; -1 without one.

    Args:
        nodes: Shape (cell, 8).
    """
    from tissuec.geometry.elements import CUBE  # where there are hexahedra

    sides = [[nodes[:, CUBE[:, k] == side] for side in (-1.0, 1.0)] for k in range(3)]
    faces = np.sort(np.array(sides), axis=3).transpose(2, 0, 1, 3)
    _, face = np.unique(faces.reshape(-1, 4), axis=0, return_inverse=True)
    face = face.ravel()
    order = np.argsort(face, kind="stable")
    same = np.flatnonzero(face[order][1:] == face[order][:-1])
    one, other = order[same], order[same + 1]
    found: Indices = np.full(len(face), -1)
    found[one], found[other] = other // 2, one // 2
    return found.reshape(-1, 3, 2)


def _layers(beside: Indices) -> Floats:
    """Return how many cells lie behind one another in each of their directions, (cell, 3).

    Args:
        beside: See ``_beside``.
    """
    own, other = np.arange(beside.size) // 2, beside.ravel()
    joined = np.stack([own, other], axis=1)[other >= 0]
    column = pieces(beside.size // 2, joined)
    return np.bincount(column)[column].reshape(-1, 3).astype(float)
