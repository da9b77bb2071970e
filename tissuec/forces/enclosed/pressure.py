"""A prescribed pressure that follows the faces of a skin.

The force p n dA acts along the present normal of a face: a follower load. With
T = (x_j - x_i) × (x_k - x_i) of each weighted triangle (see ``pressed_faces``), each of its
three corners gets p w T/6. The same holds for the ends of each edge at the rim of a cap and, by
their shares, for the nodes that carry its middle (see ``rims``).

The pressure is supplied from outside: it stores nothing, and its power is p dV/dt. On a surface
that is closed, by itself or by caps, the force is p ∂V/∂x and its matrix -p ∂²V/∂x∂x. At an
open rim, the force of a cap is missing. Unless the rim is held, the load then has no potential
and its matrix is not symmetric (K. Schweizerhof, E. Ramm, Comput. Struct. 18:1099, 1984);
``matrix`` is the symmetric part, and forces are exact.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.core.arrays import cross, cross_matrices
from tissuec.core.source import Span
from tissuec.forces.enclosed.pressed_faces import PressedFaces
from tissuec.forces.enclosed.pressed_sides import enclosed
from tissuec.forces.enclosed.pressure_kernel import PressureTable, press_faces
from tissuec.forces.enclosed.rims import Rims
from tissuec.forces.fields import SECONDS, Field, Items
from tissuec.forces.matrices import assembled
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix, csr_matrix


class SurfacePressure(Field, frozen=True):
    """A pressure on faces; its items are the faces, followed by the caps.

    Attributes:
        key: Name of the block; no two pressures have the same.
        name: Of the set or body that is pressed.
        faces: Oriented along the push of the pressure.
        caps: Rims that are closed by caps.
        openings: Rims that are open.
        amount: The pressure where the profile is 1 [Pa].
        profile: Of the pressure.
        span: The sentence.
    """

    key: str
    name: str
    faces: PressedFaces
    caps: Rims
    openings: Rims
    amount: float
    profile: TimeProfile
    span: Span

    @classmethod
    def of(
        cls,
        key: str,
        name: str,
        faces: PressedFaces,
        amount: float,
        profile: TimeProfile,
        span: Span,
        *,
        has_caps: bool = False,
    ) -> Self:
        """Return a pressure on faces.

        Args:
            key, name, faces, amount, profile, span: As of the class.
            has_caps: Whether caps close the rims of the faces.
        """
        rims, none = faces.rims, np.zeros(0, dtype=np.int64)
        caps, openings = (rims, rims.some(none)) if has_caps else (rims.some(none), rims)
        return cls(key, name, faces, caps, openings, amount, profile, span)

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(self.key, "pressure", self, self.span)

    def pressure(self, time: Floats | float) -> Floats:
        """Return the pressure [Pa], shape (…)."""
        return np.asarray(self.amount * self.profile.at(time)[0])

    def volume(self, position: Floats) -> Floats:
        """Return the volume between the faces and caps on all rims [m³], shape (…).

        It is positive on the side from which the pressure pushes.

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        faces = self.faces
        rims = self.caps, self.openings
        return enclosed(position, faces.triples, *rims, crossing=faces.crossing)

    # --- forces at rest -----------------------------------------------------------------------

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def potential(self, time: Floats | float, position: Floats) -> Floats:
        """Return -p V with caps on all rims [J], shape (…)."""
        return -self.pressure(time) * self.volume(position)

    def wayward(self, time: float, position: Floats) -> Floats | None:
        """Return minus the forces of caps on open rims [N]; see ``Effect``."""
        if not self.openings.count:
            return None
        rims, found = self.openings, np.zeros_like(position)
        apex = rims.means(position)[rims.of_edge]
        one, other = (position[rims.edges[:, k]] - apex for k in (1, 0))
        push = (float(self.pressure(time)) / 6.0) * rims.weight[:, None] * cross(one, other)
        for end in rims.edges.T:
            np.subtract.at(found, end, push)
        total = np.add.reduceat(push, rims.first[:-1])[rims.of_node]
        np.subtract.at(found, rims.nodes, np.einsum("nij,nj->ni", rims.parts, total))
        return found

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return the symmetric part of minus the derivative of the forces [N/m].

        It may be negative definite, so that it is left out where it is not ``exact``.
        """
        from scipy.sparse import coo_matrix

        if not exact:
            return coo_matrix((3 * size, 3 * size))
        whole = self.slopes(time, position, number, size)
        return coo_matrix(0.5 * (whole + whole.T))

    def slopes(self, time: float, position: Floats, number: Indices, size: int) -> "csr_matrix":
        """Return minus the derivative of the forces [N/m], shape (3 size, 3 size).

        Without open rims it is symmetric.

        Args:
            time: [s].
            position: Of all nodes [m], shape (node, 3).
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
        """
        from scipy.sparse import csr_matrix

        caps = self.caps
        corners, weight = self.faces.triples.corners, self.faces.triples.weight
        share = -float(self.pressure(time)) / 6.0
        total = _turning(position[corners], share * weight, number[corners], size)
        if not caps.count:
            return csr_matrix(total)
        # The middles of caps are unknowns after the others, and follow from those of the rim.
        middles = size + caps.of_edge
        places = np.stack([middles, number[caps.edges[:, 1]], number[caps.edges[:, 0]]], axis=1)
        ends = position[caps.edges[:, ::-1]]
        fans = np.concatenate([caps.means(position)[caps.of_edge][:, None], ends], axis=1)
        wider = _turning(fans, share * caps.weight, places, size + caps.count)
        from scipy.sparse import identity, vstack

        follow = csr_matrix(vstack([identity(3 * size), caps.slopes(number, size)]))
        return csr_matrix(total + follow.T @ wider @ follow)

    # --- tears --------------------------------------------------------------------------------

    def lost_items(self, alive: NDArray[np.bool_]) -> Indices:
        """Return torn faces, and the caps beside these, ascending; see ``Field``."""
        torn = self.faces.torn(alive)
        if not len(torn):
            return torn
        return np.append(torn, self.faces.triples.count + self._at(self.caps, torn))

    def intact(self, alive: NDArray[np.bool_]) -> Self:
        """Return the pressure on intact faces; ``alive`` as in ``Field``."""
        torn = self.faces.torn(alive)
        if not len(torn):
            return self
        faces = self.faces.some(np.delete(np.arange(self.faces.triples.count), torn))
        lost = self._at(self.caps, torn)
        caps = self.caps.some(np.delete(np.arange(self.caps.count), lost))
        rims = faces.rims
        kept = [set(caps.nodes_of(cap).tolist()) for cap in range(caps.count)]
        others = [
            rim for rim in range(rims.count) if set(rims.nodes_of(rim).tolist()) not in kept
        ]
        openings = rims.some(np.array(others, dtype=np.int64))
        return replace(self, faces=faces, caps=caps, openings=openings)

    def _at(self, rims: Rims, faces: Indices) -> Indices:
        """Return the rims that have an edge of some faces, ascending."""
        corners = self.faces.triples.some(faces).corners
        found = [
            rim
            for rim in range(rims.count)
            if (np.isin(corners, rims.nodes_of(rim)).sum(axis=1) > 1).any()
        ]
        return np.array(found, dtype=np.int64)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return press_faces

    @property
    def changes(self) -> Sequence[tuple[float, TimeProfile]]:
        """Return the pressure and its profile."""
        return ((self.amount, self.profile),)

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        return SECONDS * 12 * (len(self.faces.triples.weight) + len(self.caps.weight))

    def items(self, place: Indices) -> Items:
        """Return the nodes of faces and caps."""
        triples = self.faces.triples
        first = np.append(3 * triples.first[:-1], triples.corners.size + self.caps.node_first)
        nodes = np.concatenate([triples.corners.ravel(), self.caps.nodes])
        return Items(place[nodes], first)

    def only(self, items: Indices) -> Self:
        """Return some faces and caps, with the open rims of all."""
        count = self.faces.triples.count
        faces, caps = items[items < count], items[items >= count] - count
        return replace(self, faces=self.faces.some(faces), caps=self.caps.some(caps))

    def table(
        self, place: Indices, acts: BoundaryConditions, position: Floats
    ) -> PressureTable:
        """Return the faces and caps, which are the same at any position."""
        triples, caps = self.faces.triples, self.caps
        return PressureTable(
            acts,
            np.ascontiguousarray(place[triples.corners]),
            triples.weight,
            np.ascontiguousarray(place[caps.edges]),
            caps.weight,
            caps.first,
            np.ascontiguousarray(place[caps.nodes]),
            caps.shares,
            caps.node_first,
            caps.within,
            caps.fixed,
        )


def _turning(corners: Floats, share: Floats, number: Indices, size: int) -> "coo_matrix":
    """Return the derivative of forces c T on the corners of triangles, (3 size, 3 size).

    With [d] e = d × e, it is T = a × b + b × c + c × a, so that ∂T/∂a = [c - b], and so on.

    Args:
        corners: [m], shape (triangle, 3, 3).
        share: c of each [Pa], shape (triangle,).
        number: Of the corners among those that may move, -1 for others, (triangle, 3).
        size: Number of nodes that may move.
    """
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    turns = share[:, None, None, None] * cross_matrices(opposite)  # (triangle, corner, 3, 3)
    blocks = np.broadcast_to(turns.swapaxes(1, 2)[:, None], (len(corners), 3, 3, 3, 3))
    return assembled(blocks, number, size)
