"""Contact: forces of instruments, threads and surfaces on nodes.

A node is looked up in *shapes*: capsules, planes, and surfaces made of triangles. Where shapes
are faces of one surface, or pieces of one thread, the elements that they share are looked up
too, with the weights W of ``geometry.inclusion``, so that what a surface does depends on where
it is and not on how it is divided. At the depth δ below the surface of a shape with the normal
n a node is pressed by

    N n,    N = W k φ(δ) max(0, 1 + b δ̇),    φ(δ) = δ² / 2w up to the depth w, δ - w/2 beyond,

where δ̇ is Σ W φ δ' / Σ W φ over the shapes of one surface, δ' their own rates (damping that
grows with the depth: K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42:440, 1975). The energy is
k Σ W ∫ φ. Shapes are carried by nodes, which get the opposite force: capsules and triangles by
the weights of the nearest point, planes so that its moment is kept. So the work of moving
them equals the increase of the energy, and nothing depends on how these nodes are held or
driven.

Friction follows Coulomb's law by a bristle z at each node, which bends with the sliding
velocity u and slips where it bears no more. The coefficient μ is the smaller one of the node
and of the nearest point of the shape. With N now the sum over all shapes, and G = Σ μN the
largest friction,

    force -κ z min(1, 1/r),   κ = N / (N/k + w/2),   r = |z| / ℓ,   ℓ = G/N (N/k + w/2),
    z' = d - max(0, d·e) e r⁸,   d = u - z κ' / 2κ,   e = z / |z|.

So the force is G where the bristle slips (r = 1), and never more. Shapes share it by their μN,
which weight the sliding velocity, too. A bristle under a steady load below G does not creep, as
a friction that depends on velocity alone does; and since a bristle unbends as κ grows, κ z²/2
grows by work alone. (One-sided form of the model of P. R. Dahl, The Aerospace Corporation
TOR-0158, 1968.) Friction acts on a surface at the nearest point, a distance away from the node;
the couple of both forces is taken up by the touched faces, whose rotation counts in the sliding
velocity.

All of this holds for points between nodes as well (``contact.points``): those
on faces of bodies, and on axes of tools that are thinner than these. Where there are any, φ is
δ except in a very thin layer, and bristles are cut instead (``contact.bristle_kernel``).

Bristles are kept in the velocities of ``memory`` nodes, as z times ``rate``, so that they are
stepped, stored and resumed like all other motion. Without pressure they stand up: z' = -rate z.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled.loops.tables import ItemTable, PoolTable, room_for
from tissuec.core.keeping import kept_on_owner
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.contact.bristle_kernel import AHEAD
from tissuec.forces.contact.contact_kernel import PLACING, touch
from tissuec.forces.contact.pairs import ContactPairs, NearShapes
from tissuec.forces.contact.pressing import NodeOnShape, PairForm, traced_pairs
from tissuec.forces.contact.rows_kernel import COLUMNS, PLACES
from tissuec.forces.contact.sides_kernel import TORN
from tissuec.forces.effects import Resisting
from tissuec.forces.fields import in_line, stretches
from tissuec.forces.matrices import ForceDerivatives, assembled, whole
from tissuec.geometry.nearest import CAPSULE, PLANE, TRIANGLE, NearestPlace, places
from tissuec.kernels.records import (
    BoundaryConditions,
    ContactRecord,
    ContactTable,
    Integers,
    Roughness,
)
from tissuec.kernels.thread_loops import UNDIVIDED
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from tissuec.forces.potential_kernels import PotentialKernels

MOST_TOGETHER = 4096  # pairs that are examined at once
SEEN = 1e5  # times the length below which distances are equal: a direction is accurate there
WORTHWHILE = 2000  # pairs from which threads share them; fewer take less time than it saves


NO_ITEMS = ItemTable(0, np.zeros(0, dtype=np.int64), np.zeros(0))


class PressingRecord(NamedTuple):
    """Contact whose loops are generated.

    Attributes:
        pool: Pairs by nodes and surfaces; first, as generated loops take the record for this.
        touches: Shapes and the nodes that they can touch.
    """

    pool: PoolTable
    touches: ContactTable


class Contact(NearShapes, frozen=True, dict=True, kw_only=True):
    """Nodes and shapes that can touch, with the stiffness of contact.

    Attributes:
        stiffness: k of each node [N/m], shape (m,).
        layer: w [m].
        damping: b [s/m].
        friction: Coefficient everywhere; None where it is that of tissues.
        node_friction: That of each node, shape (m,) or (0,); very large on the axis of a tool,
            which has the coefficient of the tissue.
        face_friction: That of the points that carry each shape, shape (shape, 3) or (0, 3);
            very large for tools. Weights of the nearest point interpolate between the points.
        listed: Longest way since pairs were listed [m]; None for ``stride``.
        memory: Nodes whose velocities are the bristles, shape (m,), or none without friction.
        rate: Of bristles in those velocities [1/s].
        span: Where it is written.
        pairs: Pairs that are considered; None for all that are near.
        bounds: Entities of the parts of solids that the last triangles bound, shape (n,); empty
            before a cut.
        twins_touch: Whether both faces of a cut touch each other, as bodies do.
    """

    stiffness: Floats
    layer: float
    damping: float
    friction: float | None
    node_friction: Floats
    face_friction: Floats
    memory: Indices
    rate: float
    span: Span
    pairs: ContactPairs | None = None
    listed: float | None = None
    bounds: Indices = np.zeros(0, dtype=np.int64)
    twins_touch: bool = False

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock("contact", "contact", self, self.span)

    def intact(self, alive: NDArray[np.bool_]) -> "Contact":
        """Return the same without the faces whose springs are gone.

        Args:
            alive: Springs that are there, shape (spring,).
        """
        return _with_whole(self, np.asarray(alive, dtype=bool).tobytes())

    # --- what it does -----------------------------------------------------------------------

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return which nodes it acts on, shape (node,)."""
        pairs, _ = self.pressed(position)
        pairs, found = pairs.some(pairs.weight != 0.0), np.zeros(len(position), dtype=bool)
        here, count = self.nodes[pairs.node], len(position)
        if self.between is not None:
            found[self.between.corners[here[here >= count] - count]] = True
        found[here[here < count]] = True
        found[self.points[pairs.shape]] = True
        return found

    def least_friction(self, position: Floats) -> float:
        """Return the smallest coefficient of friction of what touches; 0 without any."""
        if self.friction is not None:
            return self.friction
        pairs, place = self.pressed(position)
        there = (place.weights * self.face_friction[pairs.shape]).sum(axis=1)
        both = np.minimum(self.node_friction[pairs.node], there)
        return float(both.min()) if len(both) else 0.0

    def pressed(self, position: Floats) -> tuple[ContactPairs, NearestPlace]:
        """Return the pairs that touch, and where they are."""
        return next(self.pressed_in(position[None]))

    def pressed_in(self, position: Floats) -> Iterator[tuple[ContactPairs, NearestPlace]]:
        """Yield the pairs that touch in each state, and where they are.

        Of single states, the last ones are kept.

        Args:
            position: Of all nodes [m], shape (state, node, 3).
        """
        if len(position) == 1:
            yield _touching(self, position.tobytes())
        else:
            yield from self.touching(position)

    def touching(self, position: Floats) -> Iterator[tuple[ContactPairs, NearestPlace]]:
        """Search for the pairs that touch in each state; yield them and where they are.

        Args:
            position: Of all nodes [m], shape (state, node, 3).
        """
        for part in stretches(position, self.stride):
            states = position[part]
            # Pairs hold for all of a stretch.
            margin = 2.0 * self.stride if len(states) > 1 else 0.0
            pairs = self.near(states[0], margin) if self.pairs is None else self.pairs
            count = max(1, MOST_TOGETHER // max(1, len(pairs.node)))
            for some in np.split(states, range(count, len(states), count)):
                # States one after the other, as if each pair had been met in each of them.
                every = pairs.some(np.tile(np.arange(len(pairs.node)), len(some)))
                row, some = (
                    np.arange(len(some)).repeat(len(pairs.node)),
                    self._with_points(some),
                )
                x = some[row, self.nodes[every.node]]
                corners = some[row[:, None], self.points[every.shape]]
                place = places(x, self.kind[every.shape], corners, every.radius)
                place = self._sided(every, place, corners, row)
                depth = place.depth.reshape(len(some), -1)
                for state, here in enumerate(depth):
                    inside = np.flatnonzero(here > 0.0)
                    yield pairs.some(inside), place.some(inside + state * len(here))

    def pressure(self, pairs: ContactPairs, depth: Floats) -> Floats:
        """Return k φ(δ) [N], shape (pair,)."""
        w, d = self.layer, np.maximum(depth, 0.0)
        return self.stiffness[pairs.node] * np.where(d < w, d * d / (2.0 * w), d - 0.5 * w)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the energy of all pressed contacts [J], shape (…)."""
        total: list[float] = []
        for pairs, place in self.pressed_in(in_line(position)):
            w, d = self.layer, place.depth
            deep = 0.5 * d * (d - w) + w * w / 6.0
            each = pairs.weight * np.where(d < w, d**3 / (6.0 * w), deep)
            total.append(float(self.stiffness[pairs.node] @ each))
        return np.reshape(total, position.shape[:-2])

    # --- its second derivative --------------------------------------------------------------

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return the stiffness of pressed contacts [N/m] among the nodes that may move.

        Args:
            exact: Whether to include the terms of curved shapes and of shapes that turn, which
                may be negative; otherwise it is positive semidefinite.
        """
        from scipy.sparse import csc_matrix

        pairs, place = self._nearest(position)
        if not exact:
            presses = pairs.weight > 0.0
            pairs, place = pairs.some(presses), place.some(presses)
        blocks = self._blocks(self._with_points(position), pairs, place, exact=exact)
        here = np.concatenate([self.nodes[pairs.node][:, None], self._carriers(pairs)], axis=1)
        if self.between is None:
            return assembled(blocks, number[here], size)
        to = self.between.map(number, size)
        found = assembled(blocks, here, to.shape[0] // 3).tocsr()
        return csc_matrix(to.T @ found @ to)

    def _blocks(
        self, position: Floats, pairs: ContactPairs, place: NearestPlace, *, exact: bool
    ) -> Floats:
        """Return the stiffness of pairs that touch [N/m], shape (pair, 4, 3, 4, 3).

        Args:
            position: Of nodes and points [m], shape (node + point, 3).
            place: Where the pairs touch.
            exact: As for ``matrix``.
        """
        depth, x = place.depth, position[self.nodes[pairs.node]]
        side = np.where(self.meetings.is_sided & (depth > pairs.radius), -1.0, 1.0)
        # Close to a surface, directions are those of a point that is a little further away.
        gap = np.abs(pairs.radius - depth)
        away = np.where((pairs.sided > 0) & (gap <= self.alike), SEEN * self.alike, 0.0)
        x = x + (side * away)[:, None] * place.normal
        own = np.concatenate([x[:, None], position[self._carriers(pairs)]], axis=1)
        radius = np.where(self.kind[pairs.shape] == PLANE, 0.0, depth + side * (gap + away))
        columns = self._numbers(pairs, PairForm.of(self.kind), {"radius": radius, "side": side})
        kernels = _of_pairs_at_rest(PairForm.of(self.kind))
        table = kernels.table(np.arange(4 * len(x)).reshape(-1, 4), columns)
        what = "matrix" if exact else "steepness"
        found = kernels.recorded(what, own.ravel(), np.zeros(own.size), table)
        if exact:
            return whole(found).reshape(-1, 4, 3, 4, 3)
        steep, slopes = found[:, 0], found[:, 1:]
        return np.einsum("p,pi,pj->pij", steep, slopes, slopes).reshape(-1, 4, 3, 4, 3)

    def _carriers(self, pairs: ContactPairs) -> Indices:
        """Return the nodes of shapes as triangles, flat ones for capsules, shape (pair, 3)."""
        points, is_capsule = self.points[pairs.shape], self.kind[pairs.shape] == CAPSULE
        return np.where(is_capsule[:, None], points[:, [0, 1, 0]], points)

    @property
    def _kernels(self) -> "PotentialKernels":
        from tissuec.forces.pooled_kernels import kernels_of  # which costs time

        pool = traced_pairs(self._form)
        return kernels_of("contact", pool.item, pool)

    def _numbers(
        self, pairs: ContactPairs, form: PairForm, more: Mapping[str, Floats]
    ) -> Floats:
        """Return the numbers of pairs, shape (number, pair).

        Args:
            form: Of the pairs.
            more: Some of them, by name.
        """
        found: dict[str, Floats | float] = {
            "stiffness": self.stiffness[pairs.node],
            "weight": pairs.weight,
            "radius": pairs.radius,
            "side": 1.0,
            "layer": self.layer,
            "inverse": 1.0 / self.layer,
            "flat": 1.0 * (self.kind[pairs.shape] == PLANE),
            **more,
        }
        count, widths = len(pairs.node), form.widths.items()
        rows = [np.broadcast_to(found[name], (width, count)) for name, width in widths]
        return np.concatenate(rows)

    @property
    def _form(self) -> PairForm:
        """Return the kind of pairs for kernels that follow from their potential."""
        between = self.between is not None
        return PairForm.of(self.kind, is_between=between, is_damped=self.damping > 0.0)

    def _pool(
        self, places: Indices, pairs: ContactPairs, nodes: int, bends: Integers
    ) -> PoolTable:
        """Return pairs by nodes and surfaces.

        Args:
            places: Of each node and point in the arrays of the kernel.
            nodes: Number of all nodes.
            bends: Where those that are passed are counted, shape (3,).
        """
        here, more = self.nodes[pairs.node], dict[str, Floats]()
        own = here[:, None]
        if self.between is not None:
            point = np.maximum(here - nodes, 0)
            is_node = (here < nodes)[:, None]
            own = np.where(is_node, own, self.between.corners[point])
            more["shares"] = np.where(is_node, [1.0, 0.0, 0.0], self.between.shares[point]).T
        key = pairs.node * (1 + int(self.surface.max())) + self.surface[pairs.shape]
        begins = np.flatnonzero(np.diff(key, prepend=-1))  # pairs of a group are in succession
        count, none = len(begins), np.zeros((len(key), 2), dtype=np.int64)
        none[:, 1] = np.searchsorted(begins, np.arange(len(key)), side="right") - 1
        items = ItemTable.of(
            np.concatenate([places[own], places[self._carriers(pairs)], none], axis=1),
            self._numbers(pairs, self._form, more), pairs.node[:, None].astype(np.int64),
        )  # fmt: skip
        damping = np.full((int(self.damping > 0.0), count), self.damping)
        groups = np.column_stack([np.arange(count), np.zeros(count, dtype=np.int64)])
        room = room_for(len(traced_pairs(self._form).rows), len(key))
        return PoolTable(
            NO_ITEMS, NO_ITEMS, 0, items, ItemTable.of(groups, damping),
            np.append(begins, len(key)), items.places, room.ravel(), bends,
        )  # fmt: skip

    def _nearest(self, position: Floats) -> tuple[ContactPairs, NearestPlace]:
        """Return the pairs that touch, one for each nearest point; weights add up there.

        So what cancels in forces does so in stiffnesses without being counted as weakening.
        """
        pairs, place = self.pressed(position)
        touched = np.where(place.weights > 0.0, self.points[pairs.shape], -1)
        # Only where the depth has a sign, it exceeds the radius.
        key = np.column_stack(
            [
                pairs.node,
                self.surface[pairs.shape],
                place.depth > pairs.radius,
                np.sort(touched, axis=1),
            ]
        )
        _, first, of = np.unique(key, axis=0, return_index=True, return_inverse=True)
        weight = _sums(of.reshape(-1), pairs.weight, len(first))
        counts = weight != 0.0
        first = first[counts]
        return pairs.some(first)._replace(weight=weight[counts]), place.some(first)

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        size = float(np.abs(position).max(initial=0.0))
        pairs, place = self.pressed(position)
        return size * float((np.abs(pairs.weight) * self.pressure(pairs, place.depth)).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return float(self.stiffness.max(initial=0.0) * np.abs(position).max(initial=0.0))

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the stiffness of all that could touch, so that the bound does not change with
        each touch [N/m]."""
        count, points = len(position), self.between
        hard = np.zeros(count if points is None else count + len(points.corners))
        hard[self.nodes] = self.stiffness
        to_all = None if points is None else points.map(np.arange(count), count)

        def resist(moved: Floats, to: Floats) -> None:
            if to_all is None:
                to += hard[:, None] * moved
            else:
                pressed = np.repeat(hard, 3) * (to_all @ moved.ravel())
                to += (to_all.T @ pressed).reshape(-1, 3)

        return resist

    # --- for the engine ---------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the loop: by hand where bristles and sides have states."""
        if self._follows:
            return self._kernels.forces
        return touch

    @property
    def _follows(self) -> bool:
        """Return whether all that it does follows from what pairs store."""
        return not self.rubs and not self.meetings.is_sided

    @property
    def derivatives(self) -> ForceDerivatives | str:
        """Return the derivatives, also by the stiffness; there are none of bristles."""
        if self.rubs:
            return "has friction"
        if self.meetings.is_sided:
            return "keeps points outside of solids, and has no exact derivatives"
        return self._kernels.derivatives(("stiffness",))

    @property
    def remembered(self) -> Indices:
        """Return the rows of bristles; see ``Field``."""
        return self.memory

    @property
    def rubs(self) -> bool:
        """Return whether there is friction anywhere."""
        return len(self.memory) > 0

    @property
    def loss(self) -> str:
        """Return why energy is not conserved; empty if it is."""
        return "contact brakes" if self.damping or self.rubs else ""

    @property
    def reach(self) -> float:
        """Return how far nodes may go before others are near shapes [m]."""
        return self.stride if self.listed is None else self.listed

    def within(self, distance: float) -> "Contact":
        """Return the same with a table that holds until a node has moved by a distance [m]."""
        return replace(self, listed=distance)

    def table(
        self, place: Indices, acts: BoundaryConditions, position: Floats
    ) -> ContactRecord | PressingRecord:
        """Return shapes and the nodes near them; it holds until one has moved by ``reach``.

        Where there are points, nodes and points near no shape are left out, and so are their
        bristles, which do not change from zero.
        """
        pairs, count = self.near(position, 2.0 * self.reach), len(position)
        places, listed = place, np.arange(len(self.nodes))
        near, corners, shares = self.nodes[:0], self.points[:0], np.zeros((0, 3))
        room = np.zeros((3, 0))
        if self.between is not None:
            kept, points = int(np.count_nonzero(place >= 0)), len(self.between.corners)
            places = np.concatenate([place[:count], kept + np.arange(points)])
            listed, room = np.unique(pairs.node), np.zeros((3, 3 * (kept + points)))
            near = self.nodes[listed]
            near = near[near >= count]
            own = near - count
            corners, shares = self.between.corners[own], self.between.shares[own]
        touches = self._table(place, places, position, pairs, listed)
        if self._follows:
            return PressingRecord(self._pool(place, pairs, count, touches.bends), touches)
        rough = self.node_friction[listed if len(self.node_friction) else slice(None)]
        return ContactRecord(
            touches=touches,
            rough=Roughness(rough, self.face_friction),
            sided=pairs.sided if pairs.sided.any() else pairs.sided[:0],
            alike=self.alike,
            at=3 * places[near],
            corners=np.ascontiguousarray(3 * place[corners]),
            shares=np.ascontiguousarray(shares),
            x=room[0],
            v=room[1],
            f=room[2],
        )

    def _table(
        self,
        every: Indices,
        place: Indices,
        position: Floats,
        pairs: ContactPairs,
        listed: Indices,
    ) -> ContactTable:
        """Return the record of pairs.

        Args:
            every: Index of each node and row of internal variables in the arrays of the kernel.
            place: That of each node and point.
            pairs: Those near one another.
            listed: Numbers of the nodes that the record contains, ascending, shape (n,).
        """
        counts = np.bincount(pairs.node, minlength=len(self.nodes))[listed]
        memory = self.memory[listed] if len(self.memory) else self.memory
        most, around = int(counts.max(initial=0)), np.zeros((np.count_nonzero(every >= 0), 3))
        there = every[: len(position)]
        around[there[there >= 0]] = position[there >= 0]
        return ContactTable(
            nodes=place[self.nodes[listed]],
            first=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            shape=pairs.shape,
            weight=pairs.weight,
            radius=pairs.radius,
            kind=self.kind,
            points=np.ascontiguousarray(place[self.points]),
            surface=self.surface,
            starts=np.zeros(1, dtype=np.int64),
            stops=np.zeros(0, dtype=np.int64),
            part=UNDIVIDED,
            met=np.zeros((most, COLUMNS)),
            at=np.zeros((most, PLACES), dtype=np.int64),
            memory=every[memory],
            bent=np.zeros((len(memory), 3 if self.between is None else AHEAD + 1)),
            lag=np.zeros(1),
            bends=np.zeros(3, dtype=np.int64),
            listed=around.ravel(),
            squares=np.zeros(len(around)),
            reach=self.reach,
            stiffness=self.stiffness[listed],
            layer=self.layer,
            damping=self.damping,
            friction=-1.0 if self.friction is None else self.friction,
            rate=self.rate,
        )

    def bristles_in(self, touches: ContactTable, order: Indices) -> Indices:
        """Return the bristles of a record with friction, shape (n,).

        Args:
            touches: It may have no places for them.
            order: Node at each place, shape (place,).
        """
        kept = len(order)
        is_node = touches.nodes < kept
        first = len(self.nodes) - (0 if self.between is None else len(self.between.corners))
        node = order[np.where(is_node, touches.nodes, 0)]
        own = np.searchsorted(self.nodes[:first], node)
        return self.memory[np.where(is_node, own, first + touches.nodes - kept)]

    def in_parts(self, table: ContactRecord | PressingRecord, parts: int) -> list[list[Any]]:
        """Return tables of nodes with about equally many pairs, and one that adds them up.

        If there are points, a table that places them comes first.
        """
        touches, pairs = table.touches, len(table.touches.shape)
        if parts == 1 or pairs < WORTHWHILE:
            return [[table]]
        if isinstance(table, PressingRecord):
            divided = table.pool.in_parts(parts)
            return [[table._replace(pool=each) for each in part] for part in divided]
        cuts = np.searchsorted(touches.first, np.linspace(0, pairs, parts + 1)[1:-1])
        shared = touches._replace(
            starts=np.array([0, *cuts, len(touches.nodes)], dtype=np.int64),
            stops=np.zeros(parts, dtype=np.int64),
            met=np.zeros((pairs, COLUMNS)),
            at=np.zeros((pairs, PLACES), dtype=np.int64),
        )
        tables = [
            table._replace(touches=shared._replace(part=part)) for part in range(parts + 1)
        ]
        placing = [table._replace(touches=touches._replace(part=PLACING))]
        return [*([placing] if len(table.at) else []), tables[:-1], tables[-1:]]


@cache
def _of_pairs_at_rest(form: PairForm) -> "PotentialKernels":
    """Return the kernels of pairs by themselves, once for each form."""
    from tissuec.forces.potential_kernels import kernels_of  # which costs time

    return kernels_of("contact", NodeOnShape(form))


@kept_on_owner(8)
def _with_whole(contact: Contact, alive: bytes) -> Contact:
    """Return contact without the faces whose springs are gone; cached for repeated calls."""
    there = np.frombuffer(alive, dtype=bool)
    bound = contact.bonds >= 0
    holding = np.zeros_like(bound)
    holding[bound] = there[contact.bonds[bound]]
    whole = np.logical_or(holding.any(axis=1), ~bound.any(axis=1))
    triangles = np.flatnonzero(contact.kind[: len(whole)] == TRIANGLE)
    held = contact.edges.holding(there).all(axis=1)
    whole[triangles] = np.append(held, there[contact.bounds])
    table, points = contact.meetings, contact.between
    if table.is_sided and not whole.all():
        # Tools and threads are no longer kept outside of a surface that has a hole, bodies are.
        torn, columns = table.sided.copy(), np.unique(table.of[~whole])
        stays = ~np.isnan(table.distances[:, columns]) & (torn[:, columns] > 0)
        torn[:, columns] = np.where(stays, TORN, 0)
        contact = replace(contact, meetings=replace(table, sided=torn))
    if points is not None and not (stays := points.whole(there)).all():
        nodes = np.ones(len(contact.nodes) - len(stays), dtype=bool)
        contact = replace(contact, there=np.concatenate([nodes, stays]))
    return contact if whole.all() else replace(contact, whole=whole)


@kept_on_owner(2)
def _touching(contact: Contact, position: bytes) -> tuple[ContactPairs, NearestPlace]:
    """Return the pairs that touch with nodes at some positions, and where they are."""
    return next(contact.touching(np.frombuffer(position).reshape(1, -1, 3)))


def _sums(row: Indices, values: Floats, count: int) -> Floats:
    """Return the sums of values by rows; without any, NumPy would count in integers."""
    return np.bincount(row, values, count).astype(float, copy=False)
