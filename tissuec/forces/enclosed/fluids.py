"""Fluids in cavities: volumes kept by pressure, and a weight that acts on the wall.

A cavity is bounded by faces and caps (see ``pressed_faces``), after cuts into a solid also by
parts of these, and by faces of cuts, whose ends caps close. With the drawn volume V0, the
target volume Vt, the bulk modulus K, and the density ρ of the fluid without pressure, its mass
is m = ρ Vt and it stores

    E = ½ K (V - Vt)²/V0 - m g · c,        c = ∫ x dV / V.

So it has the pressure p + (m/V) g · (x - c) with p = K (Vt - V)/V0 at its centroid, and all of
its forces add up to its weight m g. Of triangles with corners a, b, c and D = a · (b × c),

    V = Σ w D/6,        g · ∫ x dV = Σ w D g · (a + b + c)/24,

as seen from any point, because the surface is closed; where it ends at planes of symmetry, from
any point on these. c is then the centroid of the fluid with its mirror images. The fluid has
weight but no inertia. A pump that increases Vt does the work p - ρ g · c per volume.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Self

import numpy as np
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Vector
from tissuec.core.arrays import counted_up
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.enclosed.kept_volumes import KeptVolumes
from tissuec.forces.enclosed.pressed_faces import PressedFaces, WeightedTriangles
from tissuec.forces.enclosed.pressed_sides import NoSide, components
from tissuec.forces.enclosed.rims import Crossing, Rims
from tissuec.forces.fields import SECONDS
from tissuec.forces.grouped_items import CarriedPoints, GroupedItems
from tissuec.model.blocks import FieldBlock
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import Floats, Indices, Network

NONE_TORN = np.zeros((0, 2), dtype=np.int64)
NONE = 1e-200  # keeps the centroid of a cavity without volume finite [m⁶]


def _triangle(x: Sequence[Vector], p: Numbers) -> Sequence[Number]:
    """Return the volume under a triangle, and its part of g · ∫ x dV."""
    a, b, c = x
    six = p.weight * autodiff.dot(a, autodiff.cross(b, c))
    return [six / 6.0, six * autodiff.dot(p.gravity, a + b + c) / 24.0]


def _cavity(sums: Vector, seen: Vector, p: Numbers) -> Number:
    """Return the energy of a cavity, whose target is V0 (1 + amount)."""
    volume, fall = sums
    due = p.drawn * (1.0 + p.amount)
    height = fall * volume / (volume**2 + NONE) + autodiff.dot(p.gravity, seen)
    return 0.5 * p.modulus / p.drawn * (volume - due) ** 2 - p.density * due * height


class FluidCavities(KeptVolumes, frozen=True):
    """The cavities of a set or body, each with a pressure of its own; its items are cavities.

    Attributes:
        triples: Weighted triangles that face out of the cavities, cavity by cavity; the
            triangles of a cavity are one face of these.
        caps: On their rims, cavity by cavity.
        cap_first: Caps of a cavity, shape (cavity + 1,).
        density: ρ [kg/m³]; 0 of a fluid without weight.
        crossing: Of the planes of symmetry at which the triangles end.
        gravity: g [m/s²], shape (3,).
        faces: The walls as drawn.
        cavity: The cavity of each triangle of these, -1 of one that leaks, shape (triangle,).
    """

    item_shares = staticmethod(_triangle)
    group_energy = staticmethod(_cavity)

    triples: WeightedTriangles
    caps: Rims
    cap_first: Indices
    density: float
    crossing: Crossing
    gravity: Floats
    faces: PressedFaces
    cavity: Indices

    @classmethod
    def of(
        cls,
        network: Network,
        name: str,
        faces: PressedFaces,
        modulus: float,
        density: float,
        span: Span,
        *,
        has_caps: bool,
    ) -> Self:
        """Return the cavities enclosed by faces.

        Args:
            name: Of the set or body.
            faces: They face out of the cavities.
            modulus, density, span: See the classes.
            has_caps: Whether caps close the rims of the faces, which must otherwise be closed.

        Raises:
            NoSide: A cavity is open or encloses nothing.
        """
        rims = faces.rims
        if rims.count and not has_caps:
            ids = network.node_ids[rims.nodes_of(0)]
            raise NoSide(
                f"{name} is open, so that it cannot keep a fluid: its rim leads through the "
                f"nodes {', '.join(map(str, ids[:4].tolist()))}, …",
                "close its open ends: with caps",
            )
        cavity = components(faces.corners)
        none = np.zeros(int(cavity.max()) + 1)
        found = cls(
            *_walls(network, faces, cavity), name, none, modulus, (), span,
            *_bounds(faces, cavity), density, faces.crossing, np.zeros(3), faces, cavity,
        )  # fmt: skip
        drawn = found.volumes(network.position)
        if not (drawn > 0.0).all():
            raise NoSide(
                f"{name} encloses no space that a fluid could fill",
                "name a surface that encloses a space, closed by caps where it is open",
            )
        return replace(found, drawn=drawn)

    def wall_on(
        self, parts: PartTriangles, divided: NDArray[np.bool_]
    ) -> tuple[PressedFaces, Indices]:
        """Return the walls after cuts, and the cavity of each of their triangles, (triangle,).

        Args:
            parts: Triangles that bound the parts of elements.
            divided: Triangles of the skin whose elements are divided, shape (triangle,).
        """
        faces = self.faces.with_parts(divided[self.faces.rows], parts)
        order = np.argsort(self.faces.rows)
        place = np.searchsorted(self.faces.rows[order], faces.rows)
        return faces, self.cavity[order[place]]

    def bounded_by(
        self, network: Network, faces: PressedFaces, cavity: Indices, torn: Indices = NONE_TORN
    ) -> Self:
        """Return the same cavities within other walls.

        Args:
            faces: They face out of the cavities.
            cavity: The cavity of each of their triangles, -1 of none, shape (triangle,).
            torn: Cavities that leak, and elements that are divided there, shape (n, 2).
        """
        own = cavity >= 0
        faces, cavity = faces.some(np.unique(faces.face[own])), cavity[own]
        walls, walled = _walls(network, faces, cavity)
        triples, caps, cap_first = _bounds(faces, cavity)
        return replace(
            self, walls=np.append(walls, torn[:, 1]), walled=np.append(walled, torn[:, 0]),
            triples=triples, caps=caps, cap_first=cap_first,
        )  # fmt: skip

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the fluid in {self.name}", "fluid", self, self.span)

    @property
    def _triangles(self) -> tuple[Indices, Floats, Indices]:
        """Return all triangles, with those of caps, whose middles are the points from 0.

        Returns:
            Corners, shape (triangle, 3), weights and cavities, ascending, shape (triangle,).
        """
        owner = np.repeat(np.arange(self.item_count), np.diff(self.cap_first))
        corners = np.concatenate([self.triples.corners, self.caps.fans])
        weight = np.concatenate([self.triples.weight, self.caps.weight])
        cavity = np.concatenate([self.triples.face, owner[self.caps.of_edge]])
        order = np.argsort(cavity, kind="stable")
        return corners[order], weight[order], cavity[order]

    @cached_property
    def grouped(self) -> GroupedItems:
        """Return the triangles.

        A cavity is seen from a node, or from the point next to this on all planes of symmetry.
        """
        corners, weight, cavity = self._triangles
        count, points = self.item_count, self.caps.middles
        seen, crossing = self.triples.corners[self.triples.first[:-1], 0], self.crossing
        if crossing.is_limited:
            parts, fixed = (np.repeat(each[None], count, 0) for each in astuple(crossing))
            seen, views = (
                -1 - points.count - np.arange(count),
                CarriedPoints(seen, np.arange(count), parts, fixed),
            )
            points = points.joined(views)
        first = np.searchsorted(cavity, np.arange(count + 1)).astype(np.int64)
        own = {"drawn": self.drawn, "modulus": self.modulus, "density": self.density}
        fall = {"gravity": self.gravity[:, None]}
        return GroupedItems(corners, first, seen, points, {"weight": weight} | fall, own | fall)

    def volumes(self, position: Floats) -> Floats:
        """Return the volumes of the cavities [m³], shape (…, cavity)."""
        return self.sums(position)[0]

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        return SECONDS * 24 * (len(self.triples.weight) + len(self.caps.weight))

    def only(self, items: Indices) -> Self:
        """Return some cavities, with the walls of all."""
        counts = np.diff(self.cap_first)[items]
        caps = np.repeat(self.cap_first[items], counts) + counted_up(counts)
        number = np.full(self.item_count + 1, -1)  # of cavities, and of none
        number[items] = np.arange(len(items))
        return replace(
            self,
            triples=self.triples.some(items),
            caps=self.caps.some(caps),
            cap_first=np.append(0, np.cumsum(counts)),
            drawn=self.drawn[items],
            cavity=number[self.cavity],
        )


def _walls(network: Network, faces: PressedFaces, cavity: Indices) -> tuple[Indices, Indices]:
    """Return the edges that hold walls, and the cavity of each, shape (n,) each.

    Parts of divided elements are not torn.

    Args:
        cavity: Of each triangle of the faces, shape (triangle,).
    """
    drawn = np.arange(len(cavity)) if faces.parts is None else np.flatnonzero(faces.parts < 0)
    pairs = faces.corners[drawn][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    walls, which = network.pairs.between(pairs)
    walls, walled = np.unique(np.stack([walls, cavity[drawn][which // 3]]), axis=1)
    return walls, walled


def _bounds(faces: PressedFaces, cavity: Indices) -> tuple[WeightedTriangles, Rims, Indices]:
    """Return ``triples``, ``caps`` on all rims, and ``cap_first`` of cavities.

    Args:
        cavity: Of each triangle of the faces, shape (triangle,).
    """
    triples, rims = _by_cavity(faces, cavity), faces.rims
    owner = np.zeros(int(triples.corners.max()) + 1, dtype=np.int64)
    owner[triples.corners] = triples.face[:, None]
    at = np.array([owner[rims.nodes_of(rim)[0]] for rim in range(rims.count)], dtype=int)
    cap_first = np.searchsorted(np.sort(at), np.arange(triples.count + 1)).astype(np.int64)
    return triples, rims.some(np.argsort(at, kind="stable")), cap_first


def _by_cavity(faces: PressedFaces, component: Indices) -> WeightedTriangles:
    """Return weighted triangles, those of each cavity as one face.

    Args:
        component: The cavity of each triangle of the skin, shape (triangle,).
    """
    of_face = np.empty(faces.triples.count, dtype=np.int64)
    of_face[faces.face] = component
    order = np.argsort(of_face, kind="stable")
    found = faces.triples.some(order)
    first = np.searchsorted(of_face[order][found.face], np.arange(int(component.max()) + 2))
    return WeightedTriangles(found.corners, found.weight, first)
