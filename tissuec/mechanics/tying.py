"""Tied sections of cuts: the parts of sections ahead of the blade.

The stiffness per area of a tie is that of ``STIFF`` layers of tissue as thick as the element,
with h = V/A of its volume and its section, in series where it joins two elements:

    k = 2 STIFF / (h₁/E₁ + h₂/E₂).

A tie with k h/E of 1 to 10 gives the opening of a slit, and the energy that it releases, in
elements of any orientation; 3 costs a third of the stable step. Nearly incompressible tissue,
whose step depends on its bulk modulus, can have 10. (Measured for this program. Cohesive
segments: J. J. C. Remmers, R. de Borst, A. Needleman, Comput. Mech. 31:69, 2003.) Ties of an
interface are everywhere between two regions, which they must not soften: k h/E is
``STIFF_INTERFACE`` there, and they have no viscosity, which would shorten stable steps by the
same factor once more. The zone in which they soften lies along the faces, so that its length is
in sizes of these.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.forces.moduli import plane_modulus, poisson_of, young_of
from tissuec.forces.solids.element_limits import softening_strength
from tissuec.forces.solids.ties import (
    FAR,
    STIFF_INTERFACE,
    SUDDEN,
    SofteningTies,
    Ties,
    openings,
)
from tissuec.forces.surfaces.membranes import Membranes
from tissuec.geometry.blade_sections import halves
from tissuec.geometry.cut_cells.parts import functions_at
from tissuec.geometry.cut_cells.sections import CutFacets, facet_sizes
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_fields import facet_areas
from tissuec.model.network import Floats, Indices, Network

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
STIFF, STIFF_INCOMPRESSIBLE = 3.0, 10.0
NEARLY_INCOMPRESSIBLE = 0.45 - 1e-9  # Poisson's ratio, to rounding
#: Largest ω² of ties, over that of ties of a whole section between undivided elements.
SWIFT = 1.5
ON_SURFACE = 1e-3  # of the size of an element: how far triangles of a surface are from it
_COLUMNS = (
    "entities", "roots", "shares", "stiffness", "damping", "size", "soft", "first", "last",
    "softens", "interface",
)  # fmt: skip
#: Of triangles, of degree 2, and of lines, of degree 3, by the number of corners; weights are
#: equal.
_POINTS = {3: 0.5 * np.eye(3) + 1.0 / 6.0, 2: np.sqrt(1.0 / 3.0) * (np.eye(2) - 0.5) + 0.5}


class TiedSections(Struct, frozen=True, eq=False):
    """Triangles of cuts whose faces are tied. Sides are the part in front and the one behind.

    Those of cuts through walls are lines.

    Attributes:
        entities: Of both parts, shape (triangle, 2).
        roots: Corners of the cells of both that are those of a root, shape
            (triangle, 2, corner of the root).
        shares: Of these in each corner, of the same points of matter, shape
            (triangle, 2, corner, corner of the root).
        stiffness: k [Pa/m], shape (triangle,).
        damping: [Pa s/m], shape (triangle,).
        size: h, the mean of both sides [m], shape (triangle,).
        soft: Factor of stiffness and damping, shape (triangle,): 1 but in slivers.
        first, last: Openings at which they begin to soften and are free [m], shape (triangle,);
            infinite where a blade alone parts them.
        softens: Which have begun, shape (triangle,).
        interface: Number of the interface of the body that each lies in, -1 of cuts and tears,
            shape (triangle,).
        heights: Of nodes of all parts that were ever tied, above the surfaces of their cuts
            [m], NaN of others, shape (node,).
    """

    entities: Indices
    roots: Indices
    shares: Floats
    stiffness: Floats
    damping: Floats
    size: Floats
    soft: Floats
    first: Floats
    last: Floats
    softens: Bools
    interface: Indices
    heights: Floats

    def __len__(self) -> int:
        return len(self.entities)

    @classmethod
    def none(cls, nodes: int, corners: int) -> Self:
        """Return none in a network of so many nodes, of roots with so many corners."""
        index = np.zeros((0, 2), dtype=np.int64)
        roots, numbers = np.zeros((0, 2, corners), dtype=np.int64), [np.zeros(0)] * 6
        shares, none = np.zeros((0, 2, corners - 1, corners)), np.zeros(0, dtype=bool)
        heights = np.full(nodes, np.nan)
        return cls(index, roots, shares, *numbers, none, index[:, 0], heights)

    @classmethod
    def of(
        cls, network: Network, name: str, body: CutBody, found: CutFacets, heights: Floats,
        interface: int = -1,
    ) -> Self:  # fmt: skip
        """Return all sections of a cut.

        Args:
            name: Of the body.
            body: Its elements after the cut.
            found: Triangles of the cut, with numbers of parts over all shapes.
            heights: Of all nodes above the surface, copies among them [m], shape (node,).
            interface: Number of the interface of the body that they lie in; -1 of others.
        """
        areas = facet_areas(network.elements_of(name), body.parts, found, network.position)
        columns = [np.zeros((0, 7))]
        for field, parts in zip(network.elements_of(name), body.parts, strict=True):
            shear, bulk = field.shear[parts.cell], field.bulk_modulus[parts.cell]
            is_soft = poisson_of(shear, bulk) < NEARLY_INCOMPRESSIBLE
            stiff = np.where(is_soft, STIFF, STIFF_INCOMPRESSIBLE)
            late = field.viscosity[parts.cell] / shear
            young = young_of(shear, bulk)
            each = (
                field.volume[parts.cell], young, stiff, late, plane_modulus(shear, bulk),
                *_strengths(field, parts.cell),
            )  # fmt: skip
            columns.append(np.stack(each, axis=1))
        every = np.moveaxis(np.concatenate(columns)[found.parts], 2, 0)
        volume, young, stiff, late, plane, strength, energy = every
        _, pair = np.unique(found.parts, axis=0, return_inverse=True)
        section = np.bincount(pair.ravel(), areas)[pair.ravel()]
        own = section > 0.0
        if interface >= 0:
            tough = network.body_named(name).interfaces[interface].toughness
            stiff, late = np.full_like(stiff, STIFF_INTERFACE), np.zeros_like(late)
            along = np.sqrt(section)[:, None]
            energy = np.full_like(energy, tough)
            strength = softening_strength(plane, energy, along)
        size = volume[own] / section[own, None]
        stiffness = 2.0 * stiff[own].min(axis=1) / (size / young[own]).sum(axis=1)
        entities = np.concatenate(body.entities)[found.parts[own]]
        strength, energy = strength[own].min(axis=1), energy[own].min(axis=1)
        first, last = openings(strength, energy, stiffness)  # ties of slivers are soft
        count = len(first)
        return cls(
            entities, found.roots[own], found.shares[own], stiffness,
            stiffness * late[own].mean(axis=1), size.mean(axis=1), np.ones(count), first, last,
            np.zeros(count, dtype=bool), np.full(count, interface), heights,
        )  # fmt: skip

    @property
    def names(self) -> Indices:
        """Return the entity that names the section of each, shape (triangle,).

        It is one of both parts, and names no other section; the part in front where there are
        more sections than parts.
        """
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import maximum_bipartite_matching

        if not len(self):
            return np.zeros(0, dtype=np.int64)
        pairs, of = np.unique(self.entities, axis=0, return_inverse=True)
        parts, column = np.unique(pairs, return_inverse=True)
        rows = np.repeat(np.arange(len(pairs)), 2), column.reshape(-1)
        graph = csr_matrix((np.ones(pairs.size), rows))
        found = maximum_bipartite_matching(graph, perm_type="column")
        return np.where(found >= 0, parts[found], pairs[:, 0])[of.reshape(-1)]

    @property
    def is_gradual(self) -> Bools:
        """Return which triangles take energy as they open, shape (triangle,)."""
        return self.last > 2.0 * SUDDEN * self.first

    def some(self, chosen: Bools | Indices) -> Self:
        """Return some triangles."""
        own = {name: getattr(self, name)[chosen] for name in _COLUMNS}
        return type(self)(**own, heights=self.heights)

    def parts_of(self, which: Indices, shares: Floats) -> Self:
        """Return parts of triangles.

        Args:
            which: The triangle that each is a part of, shape (n,).
            shares: Of its corners in each corner, dimensionless, shape (n, corner, corner).
        """
        own = self.some(which)
        return replace(own, shares=shares[:, None] @ own.shares)

    def followed_by(self, more: Self, body: CutBody) -> Self:
        """Return these and others; heights at nodes of others are theirs."""
        near = np.zeros(len(self.heights), dtype=bool)
        nodes = more.nodes(body)
        near[nodes[nodes >= 0]] = True
        both = {n: np.concatenate([getattr(self, n), getattr(more, n)]) for n in _COLUMNS}
        return type(self)(**both, heights=np.where(near, more.heights, self.heights))

    # --- at parts -----------------------------------------------------------------------------

    def nodes(self, body: CutBody) -> Indices:
        """Return the nodes of both parts, padded by -1, shape (triangle, 2, node)."""
        width = max(each.nodes.shape[1] for each in body.parts)
        found = np.full((len(self), 2, width), -1)
        for kind, parts in enumerate(body.parts):
            here, row = self._of_kind(body, kind)
            found[here, : parts.nodes.shape[1]] = parts.nodes[row]
        return found

    def weights(self, body: CutBody, shares: Floats) -> Floats:
        """Return the weights of nodes at points of triangles, shape (triangle, 2, point, node).

        Args:
            shares: Of corners of triangles at each point, dimensionless, shape
                (point, corner) or (triangle, point, corner).
        """
        width = max(each.nodes.shape[1] for each in body.parts)
        points = np.broadcast_to(shares, (len(self), *shares.shape[-2:]))
        found = np.zeros((len(self), 2, points.shape[1], width))
        for kind, parts in enumerate(body.parts):
            here, _ = self._of_kind(body, kind)
            own = points[np.nonzero(here)[0]] @ self.shares[here]
            xi = own @ parts.division.corners[self.roots[here]]
            at = functions_at(parts.shape, xi).values
            found[here, :, : at.shape[2]] = at
        return found

    def of_parts(self, body: CutBody, values: Sequence[Floats]) -> Floats:
        """Return values of the parts on both sides, in their unit, shape (triangle, 2).

        Args:
            values: Of all parts of each shape, shape (part,) each.
        """
        found = np.zeros((len(self), 2))
        for kind, each in enumerate(values):
            here, row = self._of_kind(body, kind)
            found[here] = each[row]
        return found

    def values(self, body: CutBody, values: Floats) -> Floats:
        """Return values at corners on each side, shape (triangle, 2, corner, …).

        Args:
            values: Of all nodes in any unit, shape (node, k).
        """
        own = values[self.nodes(body)]
        return self.weights(body, np.eye(self.shares.shape[2])) @ own

    def linear(self, body: CutBody, heights: Floats) -> Floats:
        """Return heights at corners, linear on roots [m], shape (triangle, 2, corner).

        Args:
            heights: Of all nodes [m], shape (node,).
        """
        ends = np.take_along_axis(self.nodes(body), self.roots, axis=2)
        return (self.shares @ heights[ends][..., None])[..., 0]

    def are_on(self, body: CutBody, heights: Floats) -> Bools:
        """Return which triangles lie in a surface, shape (triangle,); NaN is nowhere.

        Args:
            heights: Of all nodes above it [m], shape (node,).
        """
        away = np.abs(self.linear(body, heights)).max(axis=(1, 2))
        return np.asarray(away < ON_SURFACE * self.size)

    def _of_kind(self, body: CutBody, kind: int) -> tuple[Bools, Indices]:
        """Return which sides are parts of a shape, shape (triangle, 2), and their rows."""
        here = np.isin(self.entities, body.entities[kind])
        order = np.argsort(body.entities[kind])
        at = np.searchsorted(body.entities[kind][order], self.entities[here])
        return here, order[at]

    def existing(self, body: CutBody) -> Self:
        """Return the triangles both of whose parts exist."""
        return self.some(np.isin(self.entities, np.concatenate(body.entities)).all(axis=1))

    def after(
        self,
        before: CutBody,
        source: tuple[Indices, ...],
        names: list[Indices],
        heights: Floats,
    ) -> Self:
        """Return the triangles, divided by another cut, on the parts where they are.

        Args:
            before: Elements before the cut.
            source: The former part of each part, shape (part,) each.
            names: Entities of the parts, shape (part,) each.
            heights: Of all nodes above the surface of the cut [m], shape (node,).
        """
        own = self.existing(before)
        if not len(own):
            return own
        ahead, behind = own.entities.copy(), own.entities.copy()
        for kind, (of, name) in enumerate(zip(source, names, strict=True)):
            here, row = own._of_kind(before, kind)
            # Of two parts, the one behind comes first.
            behind[here] = name[np.searchsorted(of, row, side="left")]
            ahead[here] = name[np.searchsorted(of, row, side="right") - 1]
        each = own.linear(before, heights)
        each = np.where(np.isnan(each), each[:, ::-1], each).mean(axis=1)
        is_met = (ahead != behind).any(axis=1) & ~np.isnan(each).any(axis=1)
        which, shares, is_ahead = halves(np.where(is_met[:, None], each, -1.0))
        entities = np.where(is_ahead[:, None], ahead[which], behind[which])
        return replace(own.parts_of(which, shares), entities=entities)

    def copied(self, copies: Indices, copied: Indices) -> Self:
        """Return the same with heights of new nodes.

        Args:
            copies: New nodes, shape (n,).
            copied: The nodes that these are copies of, shape (n,).
        """
        heights = self.heights.copy()
        heights[copies] = heights[copied]
        return replace(self, heights=heights)

    def field(self, network: Network, name: str, body: CutBody) -> Ties:
        """Return their force.

        Args:
            name: Of the body.
        """
        points = _POINTS[self.shares.shape[2]]
        at, number = self.weights(body, points), len(points)
        nodes = np.repeat(self.nodes(body)[:, :, None], number, axis=2)
        nodes = np.where(nodes < 0, nodes[..., :1], nodes).swapaxes(1, 2)
        signed = (at * np.array([1.0, -1.0])[:, None, None]).swapaxes(1, 2)
        areas = np.repeat(self.areas(network, name, body) * self.soft / number, number)
        count, every = len(areas), np.arange(len(areas))
        span = network.elements_of(name)[0].span
        common = {
            "walls": np.repeat(self.entities, number, axis=0).ravel(),
            "walled": np.repeat(every, 2), "nodes": nodes.reshape(count, -1), "name": name,
            "weights": signed.reshape(count, -1),
            "stiffness": areas * np.repeat(self.stiffness, number),
            "damping": areas * np.repeat(self.damping, number), "span": span,
        }  # fmt: skip
        if not np.isfinite(self.first).any():
            return Ties(**common)
        of_points = (
            np.repeat(each, number)
            for each in (self.first, self.last, self.names, self.softens)
        )
        first, last, sections, softens = of_points
        return SofteningTies(
            **common, first=np.minimum(first, FAR), last=np.minimum(last, 2.0 * FAR),
            sections=sections, softens=softens,
        )  # fmt: skip

    def softened(self, state: "State", name: str) -> Self:
        """Return the same, softer where a sliver has so little mass that steps would be short.

        Those that tear stay as they are.
        """
        network, body, widths = state.network, state.cut_bodies[name], list[Floats]()
        for field, parts in zip(network.elements_of(name), body.parts, strict=True):
            is_wall = isinstance(field, Membranes)
            width = field.thickness if is_wall else np.cbrt(field.volume)
            widths.append(width[parts.cell])
        nodes, weights = self.nodes(body), self.weights(body, np.eye(self.shares.shape[2]))
        squares = (weights**2).mean(axis=2)
        ease, drawn = (
            (squares / np.where(nodes < 0, 1.0, mass[nodes])).sum(axis=(1, 2))
            for mass in (state.divisor, network.mass[network.parents])
        )
        _, pair = np.unique(self.entities, axis=0, return_inverse=True)
        pair, areas = pair.ravel(), self.areas(network, name, body)
        section, ease, drawn = (
            np.bincount(pair, areas * each)[pair] for each in (1.0, ease, drawn)
        )
        most = SWIFT * self.size * self.of_parts(body, widths).mean(axis=1) * drawn / section
        soft = np.where(np.isfinite(self.first), 1.0, np.minimum(1.0, most / ease))
        return replace(self, soft=soft)

    def areas(self, network: Network, name: str, body: CutBody) -> Floats:
        """Return their areas as drawn [m²], shape (triangle,)."""
        sizes = facet_sizes(self.values(body, network.position)[:, 0])
        if isinstance(wall := network.elements_of(name)[0], Membranes):
            return sizes * self.of_parts(body, [wall.thickness[body.parts[0].cell]])[:, 0]
        return sizes


def _strengths(field: "SolidElements", cell: Indices) -> tuple[Floats, Floats]:
    """Return strengths [Pa] and energies per area [J/m²] of faces in cells, shape (part,)."""
    none = np.full(len(cell), np.inf)
    if field.limits is None:
        return none, none
    limits = field.limits.some(cell)
    stress = np.minimum(limits.stress, field.young[cell] * limits.strain)
    return stress, limits.parting
