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

from collections.abc import Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from tissuec import autodiff
from tissuec.autodiff import Numbers, Potential, Vector
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.potentials import TracedItem
from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.enclosed.pressed_faces import PressedFaces
from tissuec.forces.enclosed.pressed_sides import enclosed
from tissuec.forces.enclosed.rims import Rims
from tissuec.forces.fields import SECONDS, Items
from tissuec.forces.grouped_items import GroupedItems, inputs
from tissuec.forces.pooled_fields import GroupedField
from tissuec.model.blocks import FieldBlock
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix

    from tissuec.compiled.loops.tables import ItemTable
    from tissuec.forces.potential_kernels import PotentialKernels


def _pressed(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the power that a pressure supplies to a triangle."""
    turned = autodiff.cross(x[1] - x[0], x[2] - x[0])
    share = p.amount * p.weight / 6.0
    return Potential(0.0, supply=share * autodiff.dot(turned, v[0] + v[1] + v[2]))


class SurfacePressure(GroupedField, frozen=True, dict=True):
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
        drawn: The faces before cuts have divided elements of a solid; None before any.
    """

    key: str
    name: str
    faces: PressedFaces
    caps: Rims
    openings: Rims
    amount: float
    profile: TimeProfile
    span: Span
    drawn: PressedFaces | None = None

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
        rims, count, item = self.openings, len(position), traced_triangle()
        values = inputs({"weight": rims.weight})
        values |= rims.middles.inputs("x", rims.fans, position)
        values["a.0"] = self.pressure(time)
        pushes = np.stack(evaluate(item.forces, values), axis=-1).reshape(-1, 3, 3)
        every = np.arange(count)
        wide = np.zeros((count + rims.count, 3))
        np.subtract.at(wide, rims.middles.numbers(rims.fans, every, count), pushes)
        found = rims.middles.follow(every, count).T @ wide.ravel()
        return np.asarray(found).reshape(-1, 3)

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return the symmetric part of minus the derivative of the forces [N/m].

        It may be negative definite, so that it is left out where it is not ``exact``.
        """
        from scipy.sparse import csc_matrix

        if not exact or not self.pressure(time):
            return csc_matrix((3 * size, 3 * size))
        blocks, items = self._blocks(time, position), self.grouped
        even = 0.5 * (blocks + blocks.transpose(0, 3, 4, 1, 2))
        return csc_matrix(items.points.assembled(even, items.corners, number, size))

    def slopes(self, time: float, position: Floats, number: Indices, size: int) -> "csr_matrix":
        """Return minus the derivative of the forces [N/m], shape (3 size, 3 size).

        Without open rims it is symmetric.
        """
        from scipy.sparse import csr_matrix

        items, blocks = self.grouped, self._blocks(time, position)
        return csr_matrix(items.points.assembled(blocks, items.corners, number, size))

    def _blocks(self, time: float, position: Floats) -> Floats:
        """Return minus the derivative of the forces of each item, (item, 3, 3, 3, 3)."""
        x = np.ascontiguousarray(self.grouped.points.and_nodes(position), float)
        kernels, table = self._recorder(len(x))
        found = kernels.recorded("turning", x.reshape(-1), np.zeros(0), table)
        return float(self.profile.at(time)[0]) * found.reshape(-1, 3, 3, 3, 3)

    @kept_on_owner(1)
    def _recorder(self, count: int) -> "tuple[PotentialKernels, ItemTable]":
        """Return the kernels of triangles where the profile is 1, and their table.

        Args:
            count: Of nodes and carried points.
        """
        from tissuec.forces.potential_kernels import kernels_of  # which costs time

        items, kernels = self.grouped, kernels_of("surfacepressure", _steady_triangle())
        weight = np.asarray(items.numbers["weight"])
        columns = np.stack([weight, np.full_like(weight, self.amount)])
        return kernels, kernels.table(items.corners % count, columns)

    # --- tears --------------------------------------------------------------------------------

    def lost_items(self, alive: NDArray[np.bool_]) -> Indices:
        """Return torn faces, and the caps beside these, ascending; see ``Field``."""
        torn = self.faces.torn(alive)
        if not len(torn):
            return torn
        return np.append(torn, self.faces.triples.count + self._at(self.caps, torn))

    def with_parts(
        self, parts: PartTriangles, alive: NDArray[np.bool_], elements: Indices
    ) -> Self:
        """Return the pressure on a solid after cuts.

        Args:
            parts: Triangles that bound the parts of its elements.
            alive: Entities that are there, shape (entity,).
            elements: Of the skin as drawn, see ``Network.skin_elements``.
        """
        drawn = self.drawn or self.faces
        of = elements[drawn.rows]
        lost = (of >= 0) & ~alive[of]
        if not lost.any():
            return self
        faces = drawn.with_parts(lost, parts)
        rims = [set(faces.rims.nodes_of(rim).tolist()) for rim in range(faces.rims.count)]
        closing = [k for k in range(self.caps.count) if set(self.caps.nodes_of(k)) in rims]
        made = self._on(faces, self.caps.some(np.array(closing, dtype=np.int64)))
        return replace(made, drawn=drawn)

    def intact(self, alive: NDArray[np.bool_]) -> Self:
        """Return the pressure on intact faces; ``alive`` as in ``Field``."""
        torn = self.faces.torn(alive)
        if not len(torn):
            return self
        faces = self.faces.some(np.delete(np.arange(self.faces.triples.count), torn))
        lost = self._at(self.caps, torn)
        return self._on(faces, self.caps.some(np.delete(np.arange(self.caps.count), lost)))

    def _on(self, faces: PressedFaces, caps: Rims) -> Self:
        """Return the pressure on other faces, with caps on some of their rims."""
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

    @cached_property
    def grouped(self) -> GroupedItems:
        """Return the triangles of faces and caps as one group, of which there are no sums."""
        corners = np.concatenate([self.faces.triples.corners, self.caps.fans])
        first, seen = np.array([0, len(corners)]), corners.max(keepdims=True, initial=0)[0]
        weight = np.concatenate([self.faces.triples.weight, self.caps.weight])
        return GroupedItems(corners, first, seen, self.caps.middles, {"weight": weight}, {})

    @property
    def _kernels(self) -> "PotentialKernels":
        from tissuec.forces.pooled_kernels import kernels_of  # which costs time

        carries = ("x", "v") if self.caps.count else ()
        return kernels_of("surfacepressure", traced_triangle(), None, carries)

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


@cache
def traced_triangle() -> TracedItem:
    """Return a triangle; points for a group without sums follow its corners."""
    return TracedItem(_pressed, 3, {"weight": 1}, seen=2, changes=True)


@cache
def _steady_triangle() -> TracedItem:
    """Return a triangle whose pressure is a number of its own."""
    return TracedItem(_pressed, 3, {"weight": 1, "amount": 1})
