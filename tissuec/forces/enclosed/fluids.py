"""Fluids in cavities: volumes kept by pressure, and a weight that acts on the wall.

A cavity is bounded by faces and caps (see ``pressed_faces``). With the drawn volume V0, the
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

from collections.abc import Callable
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec.structs import replace

from tissuec.core.arrays import counted_up, cross, cross_matrices
from tissuec.core.source import Span
from tissuec.forces.effects import Resisting
from tissuec.forces.enclosed.fluids_kernel import FluidTable, hold_fluids
from tissuec.forces.enclosed.kept_volumes import KeptVolumes
from tissuec.forces.enclosed.pressed_faces import PressedFaces, WeightedTriangles
from tissuec.forces.enclosed.pressed_sides import NoSide, components
from tissuec.forces.enclosed.rims import Crossing, Rims
from tissuec.forces.enclosed.volume import LARGE
from tissuec.forces.fields import SECONDS, Items
from tissuec.forces.matrices import assembled
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.topology import springs_between

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix, csc_matrix, csr_matrix


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
    """

    triples: WeightedTriangles
    caps: Rims
    cap_first: Indices
    density: float
    crossing: Crossing
    gravity: Floats

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
        component = components(faces.corners)
        triples = _by_cavity(faces, component)
        count = triples.count
        owner = np.zeros(network.node_count, dtype=np.int64)
        owner[triples.corners] = triples.face[:, None]
        at = np.array([owner[rims.nodes_of(rim)[0]] for rim in range(rims.count)], dtype=int)
        cap_first = np.searchsorted(np.sort(at), np.arange(count + 1)).astype(np.int64)
        pairs = faces.corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        walls, which = springs_between(network.springs.ends, pairs)
        walls, walled = np.unique(np.stack([walls, component[which // 3]]), axis=1)
        found = cls(
            walls, walled, name, np.zeros(count), modulus, (), span, triples,
            rims.some(np.argsort(at, kind="stable")), cap_first, density, faces.crossing,
            np.zeros(3),
        )  # fmt: skip
        drawn = found.volumes(network.position)
        if not (drawn > 0.0).all():
            raise NoSide(
                f"{name} encloses no space that a fluid could fill",
                "name a surface that encloses a space, closed by caps where it is open",
            )
        return replace(found, drawn=drawn)

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the fluid in {self.name}", "fluid", self, self.span)

    @property
    def weighs(self) -> bool:
        """Return whether the weight of the fluid acts."""
        return bool(self.density and self.gravity.any())

    # --- volumes and moments ------------------------------------------------------------------

    def _triangles(self) -> tuple[Indices, Floats, Indices]:
        """Return all triangles, with those of caps, whose middles are numbered after all nodes.

        Returns:
            Corners, shape (triangle, 3), of which middles are -1 - cap; weights and cavities,
            shape (triangle,).
        """
        edges, of_edge = self.caps.edges, self.caps.of_edge
        fans = np.column_stack([-1 - of_edge, edges[:, 1], edges[:, 0]])
        owner = np.repeat(np.arange(self.item_count), np.diff(self.cap_first))
        return (
            np.concatenate([self.triples.corners, fans]),
            np.concatenate([self.triples.weight, self.caps.weight]),
            np.concatenate([self.triples.face, owner[of_edge]]),
        )

    def _seen(self, position: Floats) -> tuple[Floats, Floats]:
        """Return a point of each cavity, and the corners of all triangles from there [m].

        It is a node, or the point nearest to this on all planes of symmetry.

        Returns:
            Shapes (…, cavity, 3) and (…, triangle, 3, 3).
        """
        corners, _, cavity = self._triangles()
        node = self.triples.corners[self.triples.first[:-1], 0]
        from_here = self.crossing.at(position[..., node, :])
        wider = position
        if self.caps.count:
            middles = self.caps.means(position)[..., ::-1, :]
            wider = np.concatenate([position, middles], axis=-2)
        return from_here, wider[..., corners, :] - from_here[..., cavity, None, :]

    def _contents(self, position: Floats) -> tuple[Floats, Floats]:
        """Return volumes [m³] and g · c of the centroids [m²/s²], shape (…, cavity) each."""
        _, weight, cavity = self._triangles()
        origin, x = self._seen(position)
        six = weight * np.einsum(
            "...k,...k->...", x[..., 0, :], cross(x[..., 1, :], x[..., 2, :])
        )
        fall = (x.sum(axis=-2) * self.gravity).sum(axis=-1)
        parts = np.stack([six / 6.0, six * fall / 24.0])
        sums = np.zeros((2, *position.shape[:-2], self.item_count))
        for number in range(self.item_count):
            # In order in memory, so that sums do not depend on how many there are.
            sums[..., number] = np.ascontiguousarray(parts[..., cavity == number]).sum(axis=-1)
        volume = sums[0]
        middle = np.divide(sums[1], volume, out=np.zeros_like(volume), where=volume != 0.0)
        return volume, middle + (origin * self.gravity).sum(axis=-1)

    def volumes(self, position: Floats) -> Floats:
        """Return the volumes of the cavities [m³], shape (…, cavity).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return self._contents(position)[0]

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the energy of compression and weight [J], shape (…)."""
        due = self.due(time)
        volume, height = self._contents(position)
        stored = 0.5 * self.modulus * (volume - due) ** 2 / self.drawn
        return np.asarray((stored - self.density * due * height).sum(axis=-1))

    # --- matrices -----------------------------------------------------------------------------

    def _slopes(self, position: Floats) -> tuple[Floats, Floats, Floats]:
        """Return triangles as seen from the centroids [m], and slopes of sums by their corners.

        They are those of six times volumes and of 24 g · ∫ x dV, without weights.

        Returns:
            Shapes (triangle, 3, 3) each.
        """
        _, weight, cavity = self._triangles()
        _, x = self._seen(position)
        six = weight * np.einsum("tk,tk->t", x[:, 0], cross(x[:, 1], x[:, 2]))
        moment = np.zeros((self.item_count, 3))
        np.add.at(moment, cavity, (six / 24.0)[:, None] * x.sum(axis=1))
        total = np.bincount(cavity, six / 6.0, self.item_count)
        # The whole has its centroid on the planes of symmetry.
        x = x - (moment @ self.crossing.within / total[:, None])[cavity, None]
        normal = cross(np.roll(x, -1, axis=1), np.roll(x, -2, axis=1))
        fall = (x.sum(axis=1) * self.gravity).sum(axis=-1)
        triple = np.einsum("tk,tk->t", x[:, 0], normal[:, 0])
        tilt = fall[:, None, None] * normal + triple[:, None, None] * self.gravity
        return x, normal, tilt

    def _ways(self, slopes: Floats, number: Indices, size: int) -> "csr_matrix":
        """Return Σ w slope of each cavity by free coordinates, shape (3 size, cavity)."""
        from scipy.sparse import csr_matrix

        corners, weight, cavity = self._triangles()
        places = self._numbers(corners, number, size)
        rows = 3 * places[..., None] + np.arange(3)
        columns = np.broadcast_to(cavity[:, None, None], rows.shape)
        moves = rows >= 0
        values = (weight[:, None, None] * slopes)[moves]
        wider = csr_matrix(
            (values, (rows[moves], columns[moves])),
            shape=(3 * (size + self.caps.count), self.item_count),
        )
        return csr_matrix(self._follow(number, size).T @ wider)

    def _numbers(self, corners: Indices, number: Indices, size: int) -> Indices:
        """Return the numbers of corners; those of middles follow all others."""
        if not self.caps.count:
            return number[corners]
        return np.where(corners < 0, size - 1 - corners, number[np.maximum(corners, 0)])

    def _follow(self, number: Indices, size: int) -> "csr_matrix":
        """Return the matrix from nodes that move to nodes and middles of caps."""
        from scipy.sparse import csr_matrix, identity, vstack

        return csr_matrix(vstack([identity(3 * size), self.caps.slopes(number, size)]))

    def bending(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> "csr_matrix":
        """Return the geometric stiffness of pressure and weight [N/m].

        It is -Σ p ∂²V/∂x∂x - (m/V) ∂²(g · ∫ x dV)/∂x∂x, as seen from the centroid. Arguments
        and shape are those of ``matrix``.

        Args:
            time: [s].
            position: Of all nodes [m], shape (node, 3).
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
        """
        from scipy.sparse import csr_matrix

        corners, weight, cavity = self._triangles()
        x, normal, _ = self._slopes(position)
        due, volume = self.due(time), self.volumes(position)
        pressure = self.modulus * (due - volume) / self.drawn
        thin = self.density * due / volume
        fall = (x.sum(axis=1) * self.gravity).sum(axis=-1)
        bend = -weight * (pressure[cavity] / 6.0 + thin[cavity] * fall / 24.0)
        turns = np.zeros((len(x), 3, 3, 3, 3))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            # ∂²D/∂x_i∂x_j e = e × x_k, ∂²D/∂x_i∂x_k e = x_j × e.
            turns[:, i, :, j] = -cross_matrices(x[:, k])
            turns[:, i, :, k] = cross_matrices(x[:, j])
        blocks = bend[:, None, None, None, None] * turns
        lean = np.einsum("tix,y->tixy", normal, self.gravity)
        lean = np.broadcast_to(lean[:, :, :, None], blocks.shape)
        both = lean + lean.transpose(0, 3, 4, 1, 2)
        blocks = blocks - (weight * thin[cavity] / 24.0)[:, None, None, None, None] * both
        places = self._numbers(corners, number, size)
        wider = assembled(blocks, places, size + self.caps.count)
        follow = self._follow(number, size)
        return csr_matrix(follow.T @ wider @ follow)

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return the second derivative of the energy [N/m]; see ``Effect``."""
        from scipy.sparse import coo_matrix

        ways, leans = self._rates(time, position, number, size, exact=exact)
        total = ways @ ways.T - leans @ leans.T
        if exact:
            total = total + self.bending(time, position, number, size)
        return coo_matrix(total)

    def split(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "tuple[coo_matrix, Floats]":
        """Return ``matrix`` with large cavities apart, each as one column; see ``Effect``.

        For large cavities, the term subtracted from the square of the column is left out: its
        ratio to the weight is that of the hydrostatic pressure to K.
        """
        from scipy.sparse import coo_matrix

        ways, leans = self._rates(time, position, number, size, exact=exact)
        is_large = np.diff(ways.indptr) > LARGE
        total = ways[:, ~is_large] @ ways[:, ~is_large].T
        if exact:
            small = leans[:, ~is_large]
            total = total - small @ small.T + self.bending(time, position, number, size)
        return coo_matrix(total), ways[:, is_large].toarray()

    def _rates(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool
    ) -> "tuple[csc_matrix, csc_matrix]":
        """Return a ∂V + b ∂A and b ∂A of each cavity, shape (3 size, cavity) each.

        A = g · ∫ x dV as seen from the centroid, a = √(K/V0) and b = m/(V² a): the change of
        pressure adds the square of the first to the matrix, less that of the second.
        """
        from scipy.sparse import csc_matrix, diags

        due, volume = self.due(time), self.volumes(position)
        root = np.sqrt(self.modulus / self.drawn)
        tilt = self.density * due / (volume * volume * root) if exact else 0.0 * root
        _, normal, lean = self._slopes(position)
        grows = self._ways(normal / 6.0, number, size) @ diags(root)
        leans = self._ways(lean / 24.0, number, size) @ diags(tilt)
        return csc_matrix(grows + leans), csc_matrix(leans)

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the stiffness of volumes, Σ K/V0 ∂V/∂x ∂V/∂xᵀ [N/m]; see ``Field``."""
        count = len(position)
        _, normal, _ = self._slopes(position)
        ways = self._ways(normal / 6.0, np.arange(count), count)
        modulus = self.modulus / self.drawn

        def resist(moved: Floats, to: Floats) -> None:
            to += (ways @ (modulus * (ways.T @ moved.ravel()))).reshape(-1, 3)

        return resist

    def spread(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of the energy [J]; see ``Effect``."""
        volume, height = self._contents(position)
        own = np.abs(self.pressures(time, position)) * self.drawn
        return float((own + self.density * volume * np.abs(height)).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of forces [N]; see ``Effect``."""
        _, normal, _ = self._slopes(position)
        return self.modulus * float(np.abs(normal).max()) / 6.0

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return hold_fluids

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        return SECONDS * 24 * (len(self.triples.weight) + len(self.caps.weight))

    def items(self, place: Indices) -> Items:
        """Return the nodes of the cavities; those of rims are among them."""
        return Items(place[self.triples.corners].ravel(), 3 * self.triples.first)

    def only(self, items: Indices) -> Self:
        """Return some cavities, with the walls of all."""
        counts = np.diff(self.cap_first)[items]
        caps = np.repeat(self.cap_first[items], counts) + counted_up(counts)
        return replace(
            self,
            triples=self.triples.some(items),
            caps=self.caps.some(caps),
            cap_first=np.append(0, np.cumsum(counts)),
            drawn=self.drawn[items],
        )

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> FluidTable:
        """Return the cavities, which are the same at any position."""
        caps = self.caps
        return FluidTable(
            acts,
            np.ascontiguousarray(place[self.triples.corners]),
            self.triples.weight,
            self.triples.first.astype(np.int64),
            self.cap_first.astype(np.int64),
            np.ascontiguousarray(place[caps.edges]),
            caps.weight,
            caps.first,
            np.ascontiguousarray(place[caps.nodes]),
            caps.shares,
            caps.node_first,
            caps.within,
            caps.fixed,
            self.crossing.within,
            self.crossing.fixed,
            self.drawn,
            self.modulus,
            self.density if self.weighs else 0.0,
            self.gravity,
        )

    @property
    def derivatives(self) -> str:
        """Why learning refuses fluids: they have no exact derivatives."""
        return "has no exact derivatives"


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
