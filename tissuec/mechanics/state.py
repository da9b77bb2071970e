"""The state of a net at one time of a run, with everything that the script has changed.

The engine and the reference both step a ``State`` from event to event; events change it
between steps. Arrays are in the order of the network.
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.acting.load import Drag, Load, LoadTerm, Nodal, Weight, total
from tissuec.forces.effects import Effect
from tissuec.forces.fields import Field
from tissuec.forces.springs.springs import ChangingRestLengths, SpringForce
from tissuec.mechanics.guiding import DirectedHold, guides_of, prescribing
from tissuec.model.blocks import EMBEDDING, KINDS, OF_ELEMENTS, FieldBlock
from tissuec.model.cut_cells import CutCells
from tissuec.model.edges import bare_edges, joined_pairs, without
from tissuec.model.guides import Guides
from tissuec.model.knots import SURE, Knot
from tissuec.model.network import Floats, Indices, Network, numbers_in
from tissuec.model.profiles import TimeProfile
from tissuec.model.resistance import ClosingForce
from tissuec.model.springs import Springs
from tissuec.model.topology import join_nodes_of

if TYPE_CHECKING:  # annotations only: scenes without them load faster
    from tissuec.forces.acting.embedding import EmbeddedNodes
    from tissuec.forces.acting.jets import Jet
    from tissuec.forces.contact.contact import Contact
    from tissuec.forces.enclosed.kept_volumes import KeptVolumes
    from tissuec.forces.enclosed.pressure import SurfacePressure
    from tissuec.forces.enclosed.volume import Enclosure
    from tissuec.forces.point_fields import PointField

ALL = slice(None)


class PrescribedRotation(Struct, frozen=True, eq=False):
    """A rotation about a fixed axis by ``angle`` times a profile."""

    centre: Floats  # [m], shape (3,)
    axis: Floats  # unit vector, shape (3,)
    angle: float  # [rad]
    profile: TimeProfile

    def apply(self, base: Floats, time: Floats | float) -> tuple[Floats, Floats]:
        """Return rotated points [m] and their velocities [m/s], each of shape (…, point, 3).

        Rodrigues' formula: R r = r cos θ + (n × r) sin θ + n (n·r)(1 - cos θ).

        Args:
            base: Points before the rotation [m], shape (point, 3).
            time: Times [s], shape (…).
        """
        factor, rate = (np.asarray(part)[..., None, None] for part in self.profile.at(time))
        theta = self.angle * factor
        arm = base - self.centre
        along = np.outer(arm @ self.axis, self.axis)
        turned = (
            along + (arm - along) * np.cos(theta) + np.cross(self.axis, arm) * np.sin(theta)
        )
        velocity = np.asarray(np.cross(self.axis, turned), dtype=float) * self.angle * rate
        return self.centre + turned, velocity


class PrescribedMotion(Struct, frozen=True, eq=False):
    """A prescribed path of some nodes.

    x(t) = centre + R(t) (base - centre) + Σ vectorᵢ sᵢ(t), with R = 1 where ``turn`` is None.

    Attributes:
        nodes: The driven nodes, shape (driven,).
        base: Their positions where every profile is zero [m], shape (driven, 3).
        shifts: Translations.
        turn: At most one rotation.
        span: The sentence that ordered it.
        change: By what missing vectors change positions, where nodes are moved in some
            directions only, shape (driven, 3, 3); None in all.
    """

    nodes: Indices
    base: Floats
    shifts: tuple[LoadTerm, ...]
    turn: PrescribedRotation | None
    span: Span
    change: Floats | None = None

    def some(self, nodes: Indices, row: Indices) -> "PrescribedMotion":
        """Return the motion of nodes that move as some of its nodes do.

        Args:
            nodes: Shape (n,).
            row: The place of the one that each is like, shape (n,).
        """
        change = None if self.change is None else self.change[row]
        return replace(self, nodes=nodes, base=self.base[row], change=change)

    def put(self, time: Floats | float, position: Floats, velocity: Floats) -> None:
        """Set what is prescribed of positions and velocities.

        Args:
            time: Times [s], shape (…).
            position, velocity: Of all nodes [m], [m/s], shape (…, node, 3); changed in place.
        """
        for found, of in zip(self.at(time), (position, velocity), strict=True):
            if self.change is not None:
                missing = found - of[..., self.nodes, :]
                of[..., self.nodes, :] += np.einsum("nij,...nj->...ni", self.change, missing)
            else:
                of[..., self.nodes, :] = found

    def at(self, time: Floats | float) -> tuple[Floats, Floats]:
        """Return positions [m] and velocities [m/s] of the nodes, of shape (…, driven, 3)."""
        position, velocity = self.base, np.zeros_like(self.base)
        if self.turn is not None:
            position, velocity = self.turn.apply(self.base, time)
        shift, speed = (part[..., None, :] for part in total(self.shifts, time))
        return position + shift, velocity + speed


class State(Struct, eq=False):
    """The state at ``time`` and what acts on it until the next event.

    Attributes:
        position: Of nodes [m], shape (node, 3).
        velocity: Of nodes, followed by internal variables times a rate [m/s], see
            ``Network.internal``, shape (node + row, 3).
        alive: False for springs and elements that were cut or have broken, shape (entity,).
        mass: Masses [kg], shape (node,).
        blades: Ways of blades that close through elements, by sentence and time.
        cut_bodies: Bodies that blades have divided, ``cut_body.CutBody`` by their names.
        tears: Tears of solids, ``tearing.Tears`` by their names.
        interface_nodes: Nodes that interfaces have on their other side, and the drawn nodes
            that they are copies of, shape (2, n); None without interfaces.
        tied: Sections of cuts that are tied, ``tying.TiedSections`` by the names of bodies.
        shares: Of what the drawn node has, mass and drag, that each of its copies has, shape
            (node,); None without phantoms, which have none before a cut.
        springs: All springs with their present numbers. Rest lengths of threads under way are
            those at ``time``.
        holders: Who holds which nodes ("fix" for fixed ones, otherwise a tool or set name);
            a node held by anybody is no unknown.
        directed: Who holds which nodes in some directions, and which, by their keys.
        guides: Nodes that are free in some directions only; None without any.
        motions: Prescribed motions under way, by the name of the tool or set that moves.
        loads: External forces, by name.
        blocks: What acts beside springs, by name.
        reelings: Threads that are drawn in or paid out, by the name of the body.
        knots: Knots that were tied, by the name of the body.
        hold_ends: When a hold for an interval ends [s], by the name of the holder.
        closing: Forces of blades that close.
        riders: The node of each riding point of ``cut_cells`` that something can act on, -1 of
            others, shape (point,); None before the first cut.
        still_until: When the scene ceases to be static [s]; minus infinity if it is not.
        gravity: Acceleration [m/s²], shape (3,).
        drag: Ambient damping [N s/m] of all nodes alike.
        cut_cells: What is drawn of elements that were cut; None before the first cut.
    """

    network: Network
    time: float
    position: Floats
    velocity: Floats
    alive: NDArray[np.bool_]
    mass: Floats
    springs: Springs
    gravity: Floats
    drag: float
    holders: dict[str, Indices] = field(default_factory=dict[str, Indices])
    directed: dict[str, DirectedHold] = field(default_factory=dict[str, DirectedHold])
    guides: Guides | None = None
    motions: dict[str, PrescribedMotion] = field(default_factory=dict[str, PrescribedMotion])
    loads: dict[str, Load] = field(default_factory=dict[str, Load])
    blocks: dict[str, FieldBlock] = field(default_factory=dict[str, FieldBlock])
    reelings: dict[str, ChangingRestLengths] = field(
        default_factory=dict[str, ChangingRestLengths]
    )
    knots: dict[str, Knot] = field(default_factory=dict[str, Knot])
    hold_ends: dict[str, float] = field(default_factory=dict[str, float])
    closing: tuple[ClosingForce, ...] = ()
    still_until: float = -np.inf
    shares: Floats | None = None
    cut_bodies: dict[str, Any] = field(default_factory=dict[str, Any])
    blades: dict[str, Any] = field(default_factory=dict[str, Any])
    cut_cells: CutCells | None = None
    tied: dict[str, Any] = field(default_factory=dict[str, Any])
    riders: Indices | None = None
    tears: dict[str, Any] = field(default_factory=dict[str, Any])
    interface_nodes: Indices | None = None

    @classmethod
    def start(cls, network: Network, *, gravity: Floats, drag: float) -> "State":
        """Return the state at 0 s, before any event: all nodes are free, no knot is tied.

        Args:
            network: The compiled network.
            gravity: Acceleration [m/s²], shape (3,).
            drag: Ambient damping of each node [N s/m].
        """
        tools: dict[str, Indices] = {
            tool.name: numbers_in(tool.nodes) for tool in network.tools
        }
        rows, mass, shares = network.row_count - network.node_count, network.mass, None
        if network.phantoms:
            shares = (network.parents == np.arange(network.node_count)).astype(float)
            mass = mass * shares
        return cls(
            network=network,
            time=0.0,
            position=network.position.copy(),
            velocity=np.pad(network.velocity, ((0, rows), (0, 0))),
            alive=network.present,
            mass=mass,
            shares=shares,
            springs=network.springs,
            gravity=np.asarray(gravity, dtype=float),
            drag=drag,
            holders=tools,
            guides=network.guides,
            blocks={block.name: block for block in network.blocks},
        )

    @property
    def held(self) -> NDArray[np.bool_]:
        """Return which nodes are held, grasped or driven: no unknowns, shape (node,).

        An embedded node is held if all its hosts are.
        """
        held = np.zeros(self.network.node_count, dtype=bool)
        for nodes in self.holders.values():
            held[nodes] = True
        if (embedding := self.embedding) is not None:
            held[embedding.nodes] = ~embedding.any_of(~held)
        return held

    @property
    def free(self) -> NDArray[np.bool_]:
        """Return which nodes are unknowns, neither held nor embedded, shape (node,)."""
        free = ~self.held
        if (embedding := self.embedding) is not None:
            free[embedding.nodes] = False
        return free

    @property
    def every_holder(self) -> dict[str, Indices]:
        """Return the nodes held by each holder, in all directions or in some, shape (n,)."""
        found = dict(self.holders)
        for hold in self.directed.values():
            own = found.get(hold.holder)
            found[hold.holder] = hold.nodes if own is None else np.union1d(own, hold.nodes)
        return found

    @property
    def driven(self) -> NDArray[np.bool_]:
        """Return which nodes, or some of their hosts, follow a path, shape (node,)."""
        driven = np.zeros(self.network.node_count, dtype=bool)
        for motion in self.motions.values():
            if motion.change is None:
                driven[motion.nodes] = True
        if (embedding := self.embedding) is not None:
            driven[embedding.nodes] = embedding.any_of(driven)
        return driven

    @property
    def still(self) -> NDArray[np.bool_]:
        """Return which nodes are held and follow no path, shape (node,)."""
        return self.held & ~self.driven

    def lumped(self, masses: Floats) -> Floats:
        """Return masses with those of embedded nodes lumped at their hosts.

        Args:
            masses: Or whatever adds up, of all nodes in any unit, shape (node,).
        """
        return masses if self.embedding is None else self.embedding.lumped(masses)

    @property
    def inertia(self) -> Floats:
        """Return the masses that resist forces: 0 of embedded nodes [kg], shape (node,)."""
        return self.lumped(self.mass)

    @property
    def divisor(self) -> Floats:
        """Return ``inertia``, but 1 for embedded nodes [kg], shape (node,)."""
        inertia = self.inertia
        if self.embedding is not None:
            inertia[self.embedding.nodes] = 1.0
        return inertia

    @property
    def braking(self) -> Floats:
        """Return the ambient damping of each node [N s/m], shape (node,)."""
        braking, own = np.full(self.network.node_count, float(self.drag)), self.network.drag
        if (guides := self.guides) is not None:  # the mirror image brakes the other part
            braking[guides.nodes] *= guides.share
        if own is not None:  # followed by nodes of tools
            braking[: len(own)] += own[self.network.parents[: len(own)]]
        return braking if self.shares is None else braking * self.shares

    @property
    def weighing(self) -> Floats:
        """Return the dimensionless ratio of weight to mass times gravity, shape (node,)."""
        weighing, own = np.ones(self.network.node_count), self.network.weighing
        if own is not None:
            weighing[: len(own)] = own
        return weighing

    def spring_force(self, chosen: Indices | slice = ALL) -> SpringForce:
        """Return the force of some springs with their present numbers.

        Args:
            chosen: Indices of shape (n,), or a slice, whose numbers are not copied.
        """
        return SpringForce(self.springs.some(chosen), self.alive_springs[chosen])

    @property
    def acting(self) -> SpringForce:
        """Return the force of the springs that act on a free node."""
        idle = join_nodes_of(self.springs.ends, self.held)
        return self.spring_force(np.flatnonzero(self.alive_springs & ~idle))

    def rest_at(self, time: Floats | float) -> Floats:
        """Return the rest lengths at times until the next event [m], shape (…, spring)."""
        if not self.reelings:
            return self.springs.rest
        times = np.asarray(time, dtype=float)
        springs = self.springs.rest.shape[-1]
        own = self.springs.rest.reshape(-1, springs)[
            0
        ]  # what does not change is alike at all times
        rest = np.broadcast_to(own, (*times.shape, springs)).copy()
        for reeling in self.reelings.values():
            found = [reeling.rest(float(t)) for t in times.ravel()]
            rest[..., reeling.springs] = np.reshape(found, (*times.shape, -1))
        return rest

    def at(self, time: Floats | float) -> "State":
        """Return the state with the rest lengths of other times.

        Args:
            time: Times [s], shape (…); rest lengths that change get the shape (…, spring).
        """
        if not self.reelings:
            return self
        return replace(self, springs=replace(self.springs, rest=self.rest_at(time)))

    def keep_rest(self) -> None:
        """Set the rest lengths of threads under way to those at ``time``."""
        if self.reelings:
            self.springs = replace(self.springs, rest=self.rest_at(self.time))

    def stop_reeling(self, springs: Indices) -> None:
        """Stop the change of rest lengths in threads that contain some of the given springs.

        Args:
            springs: Indices, shape (n,).
        """
        self.keep_rest()
        self.reelings = {
            name: reeling
            for name, reeling in self.reelings.items()
            if not np.isin(reeling.springs, springs).any()
        }

    @property
    def alive_springs(self) -> NDArray[np.bool_]:
        """Return which springs are there, shape (spring,)."""
        return self.alive[: self.network.spring_count]

    @property
    def alive_lines(self) -> NDArray[np.bool_]:
        """Return which springs and edges of elements are there, shape (line,)."""
        return self.alive[: self.network.line_count]

    def lose(self, lines: Indices) -> None:
        """Remove lines, and the elements whose edges they are.

        Args:
            lines: Springs and edges, shape (n,).
        """
        self.alive = without(self.network, self.alive, lines)

    def break_entities(self, broken: Indices) -> Indices:
        """Remove springs and elements that break, and edges that no other element has.

        Args:
            broken: Entities, shape (n,).

        Returns:
            The edges, ascending, shape (m,).
        """
        self.alive = self.alive.copy()
        self.alive[broken] = False
        edges = bare_edges(self.network, self.alive, broken)
        self.alive[edges] = False
        return edges

    def give_way(self, springs: Indices) -> list[str]:
        """Let the knots slip whose springs exceed their limits; return the names of the knots.

        Args:
            springs: Springs that exceed their limits, shape (n,).
        """
        found = [name for name, knot in self.knots.items() if self._slips(knot, springs)]
        for name in found:
            knot = self.knots[name]
            stretch = SURE * (self._distance(knot) - float(self.springs.rest[knot.hold]))
            self._switch(name, replace(knot, stretch=stretch))
        return found

    def _slips(self, knot: Knot, springs: Indices) -> bool:
        """Return whether this knot gives way, rather than the thread that breaks there."""
        return knot.limit < knot.strength and knot.hold in springs

    # --- cuts of elements -------------------------------------------------------------------

    @property
    def cut_elements(self) -> "tuple[PointField, ...]":
        """Return the elements that cuts have made: parts, and whole ones with copies."""
        drawn = {block.name for block in self.network.blocks}
        return tuple(
            block.field
            for name, block in self.blocks.items()
            if block.kind in OF_ELEMENTS and name not in drawn
        )

    @property
    def is_cut(self) -> bool:
        """Return whether nodes have copies by cuts."""
        return self.shares is not None and bool(self.cut_elements)

    def with_copies(self, nodes: Indices) -> Indices:
        """Return nodes with their copies at the same side of a cut, ascending, shape (m,).

        A copy belongs to a set if its parent does, and a node of the set is in one part with
        it. A set that fills elements beside an interface, such as a region, has the nodes of
        the interface on the side of these elements only, others have those on both sides.

        Args:
            nodes: Of the bodies as drawn, ascending, shape (n,).
        """
        if not self.is_cut:
            return nodes
        parents = self.network.parents
        are_copies = parents != np.arange(len(parents))
        if self.interface_nodes is not None:
            nodes = self._on_own_sides(nodes, *self.interface_nodes)
            are_copies[self.interface_nodes[0]] = False
        chosen = np.zeros(len(parents), dtype=bool)
        chosen[nodes] = True
        found = chosen.copy()
        belongs = np.zeros(len(parents), dtype=bool)
        belongs[parents[nodes]] = True
        for each in self.cut_elements:
            own = each.nodes[self.alive[each.walls]]
            beside = own[chosen[own].any(axis=1) | are_copies[own].all(axis=1)]
            found[beside[are_copies[beside] & belongs[parents[beside]]]] = True
        return np.flatnonzero(found)

    def _on_own_sides(self, nodes: Indices, copies: Indices, drawn: Indices) -> Indices:
        """Return nodes with those of interfaces that belong to them; see ``with_copies``.

        Args:
            nodes: As drawn, or with copies, shape (n,).
            copies, drawn: Rows of ``interface_nodes``, shape (m,) each.
        """
        parents = self.network.parents
        chosen, filled, is_known, fills = np.zeros((4, len(parents)), dtype=bool)
        chosen[nodes] = True
        is_known[drawn[chosen[copies]]] = True  # a set that has copies is complete
        own = chosen[drawn] & ~is_known[drawn]
        members = np.concatenate([np.unique(drawn[own]), copies[own]])
        for each in self.elements:
            beside = each.nodes[self.alive[each.walls]]
            filled[beside[chosen[parents[beside]].all(axis=1)]] = True
        fills[parents[members[filled[members]]]] = True
        chosen[members] = filled[members] | ~fills[parents[members]]
        return np.flatnonzero(chosen)

    @property
    def drawn(self) -> Floats:
        """Return where nodes are drawn, riders by where they ride [m], shape (node, 3)."""
        drawn, embedding = self.network.position, self.embedding
        if self.riders is None or embedding is None:
            return drawn
        drawn = drawn.copy()
        embedding.follow(drawn)
        return drawn

    @property
    def joined_pairs(self) -> Indices:
        """Return the nodes of edges of elements that are there, shape (edge, 2).

        Ties join two nodes of their parts.
        """
        whole = joined_pairs(self.network, self.alive)
        own = [each.intact(self.alive).edges.reshape(-1, 2) for each in self.cut_elements]
        own += [each.intact(self.alive).joined_pairs for each in self.of_kind("ties")]
        return np.concatenate([whole, *own]) if own else whole

    @property
    def is_slipping(self) -> bool:
        """Return whether any knot slips."""
        return any(self.alive[knot.slip] for knot in self.knots.values())

    def seizing(self, time: float, position: Floats, velocity: Floats) -> list[str]:
        """Return the knots that slip but through which no thread runs any more, by name.

        Args:
            time: [s], until the next event.
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        found: list[str] = []
        for name, knot in self.knots.items():
            if self.alive[knot.slip]:
                drawn = sum(r.rate_of(knot.hold, time) for r in self.reelings.values())
                if _parting(self.network, knot, position, velocity) <= drawn:
                    found.append(name)
        return found

    def seize(self) -> list[str]:
        """Let knots hold again that no longer slip; return their names."""
        found = self.seizing(self.time, self.position, self.velocity)
        for name in found:
            knot = self.knots[name]
            assert knot.stretch is not None
            rest = self._distance(knot) - knot.stretch
            longer = rest - float(self.springs.rest[knot.hold])
            self.springs = self.springs.changed("rest", knot.hold, rest)
            self.reelings = {
                name: reeling.lengthened(knot.hold, longer)
                for name, reeling in self.reelings.items()
            }
            self._switch(name, replace(knot, stretch=None))
        return found

    def _switch(self, name: str, knot: Knot) -> None:
        """Let the one spring of a knot take the place of the other."""
        self.alive = self.alive.copy()
        slips = knot.stretch is not None
        self.alive[[knot.hold, knot.slip]] = not slips, slips
        self.knots = {**self.knots, name: knot}

    def _distance(self, knot: Knot) -> float:
        """Return how far the ends of a thread are apart [m]."""
        first, second = self.position[self.springs.ends[knot.hold]]
        return float(np.linalg.norm(second - first))

    # --- blocks beside springs --------------------------------------------------------------

    def put(self, *blocks: FieldBlock) -> None:
        """Add blocks; they replace those of the same names."""
        self.blocks = self.blocks | {block.name: block for block in blocks}

    def remove(self, *blocks: FieldBlock) -> None:
        """Remove blocks by their names."""
        names = {block.name for block in blocks}
        self.blocks = {name: each for name, each in self.blocks.items() if name not in names}

    @property
    def without_contact(self) -> "State":
        """Return the same in which nothing touches."""
        blocks = {name: b for name, b in self.blocks.items() if b.kind != "contact"}
        return replace(self, blocks=blocks)

    def of_kind(self, *kinds: str) -> tuple[Any, ...]:
        """Return the fields of the blocks of some kinds."""
        return tuple(block.field for block in self.blocks.values() if block.kind in kinds)

    @property
    def elements(self) -> tuple[Any, ...]:
        """Return the elements of solids and walls."""
        return self.of_kind(*OF_ELEMENTS)

    @property
    def enclosures(self) -> "dict[str, Enclosure]":
        """Return the volumes that are kept by pressure, by the name of the body."""
        return {each.name: each for each in self.of_kind("volume")}

    @property
    def jets(self) -> "dict[str, Jet]":
        """Return the jets of fluid by the name of the nozzle."""
        return {each.nozzle: each for each in self.of_kind("jet")}

    @property
    def pressures(self) -> "tuple[SurfacePressure, ...]":
        """Return the pressures on surfaces, without torn faces."""
        return tuple(each.intact(self.alive) for each in self.of_kind("pressure"))

    @property
    def supplied(self) -> tuple[Field, ...]:
        """Return the fields whose forces do external work."""
        active = (each.intact(self.alive) for each in self.of_kind("activation"))
        return (*self.jets.values(), *self.pressures, *active)

    @property
    def contact(self) -> "Contact | None":
        """The contact of instruments, bodies and threads; None if nothing can touch."""
        return next(iter(self.of_kind("contact")), None)

    @property
    def touching(self) -> "Contact | None":
        """The contact without faces that were cut or torn; None if nothing can touch."""
        contact = self.contact
        return None if contact is None else contact.intact(self.alive)

    @property
    def kept_volumes(self) -> "tuple[KeptVolumes, ...]":
        """Return the volumes that are kept by pressure: cells of bodies, and cavities."""
        return self.of_kind("volume", "fluid")

    def enclosure(self, name: str) -> "KeptVolumes | None":
        """Return the volume of a body or set that is kept, None without one."""
        found = (each for each in self.kept_volumes if each.name.lower() == name.lower())
        return next(found, None)

    def let_leak(self) -> "list[tuple[KeptVolumes, int]]":
        """Remove torn cells and cavities, which keep no pressure; jets pass through tears.

        Returns:
            The volumes before, each with the number of cells that it loses.
        """
        found: list[tuple[KeptVolumes, int]] = []
        for enclosure in self.kept_volumes:
            torn = enclosure.lost_items(self.alive)
            if len(torn):
                found.append((enclosure, len(torn)))
                left = enclosure.without(torn)
                (self.put if left.item_count else self.remove)(left.block)
        self.put(*(jet.torn(self.alive).block for jet in self.jets.values()))
        return found

    @property
    def named_fields(self) -> dict[str, Field]:
        """The fields that act beside springs, by name, without what was cut or torn."""
        return {block.name: block.field.intact(self.alive) for block in self.present_blocks}

    @property
    def present_blocks(self) -> tuple[FieldBlock, ...]:
        """Return the blocks in the order in which their forces are added.

        It does not depend on when blocks were added.
        """
        rank = {kind: place for place, kind in enumerate(KINDS)}
        rank[EMBEDDING] = len(KINDS) + 1
        blocks = self.blocks.values()
        return tuple(sorted(blocks, key=lambda block: rank.get(block.kind, len(KINDS))))

    @property
    def fields(self) -> tuple[Field, ...]:
        """The fields that act beside springs, in the order in which they are added."""
        return tuple(self.named_fields.values())

    @property
    def embedding(self) -> "EmbeddedNodes | None":
        """The nodes that are embedded in others; None without any."""
        return next(iter(self.of_kind(EMBEDDING)), None)

    @property
    def parked(self) -> tuple[Indices, Indices]:
        """Return nodes that no cut has used yet, and their hosts, shape (n,) each."""
        embedding = self.embedding
        if embedding is None or self.shares is None:
            return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
        # Copies of glued nodes have several hosts.
        own = (embedding.counts == 1) & self._unused[embedding.nodes]
        return embedding.nodes[own], embedding.hosts[embedding.first[:-1][own]]

    @property
    def coupling(self) -> "EmbeddedNodes | None":
        """The embedded nodes that anything acts on: no reserve that no cut has used yet."""
        embedding = self.embedding
        if embedding is None or self.shares is None:
            return embedding
        left = embedding.without(np.flatnonzero(self._unused))
        return left if len(left.nodes) else None

    @property
    def _unused(self) -> NDArray[np.bool_]:
        """Return which nodes are in reserve, and no cut has used them yet, shape (node,)."""
        assert self.shares is not None
        unused = self.shares == 0.0
        if self.riders is not None:
            unused[self.riders[self.riders >= 0]] = False
        return unused

    @property
    def outer(self) -> tuple[Nodal, ...]:
        """Return the external forces on free nodes: weight, drag and applied forces.

        Those on embedded nodes are on their hosts.
        """
        held, braking, embedding = self.held, self.lumped(self.braking), self.embedding
        weighing = self.weighing
        if embedding is not None:
            weighing = embedding.lumped(self.mass * weighing) / self.divisor
        weight = Weight(np.where(held, 0.0, self.inertia), self.gravity, weighing)
        drag = Drag(np.where(held, 0.0, braking))
        loads = self.loads.values()
        return (
            *((weight,) if self.gravity.any() else ()),
            *((drag,) if braking.any() else ()),
            *(loads if embedding is None else map(embedding.carried, loads)),
        )

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return all that acts beside springs."""
        return (*self.outer, *self.fields)

    @property
    def loss(self) -> str:
        """Return why energy is not kept, as the beginning of a sentence; empty if it is."""
        springs = self.acting.springs
        if springs.behaviour.is_viscous:
            return "there is viscosity"
        if springs.inelastic is not None:
            return "there are springs that relax or flow"
        for effect in self.effects:
            if effect.loss:
                return effect.loss
            if effect.braking(self.position) is not None:
                return "there is viscosity"
        return ""

    def forget_friction(self, nodes: Indices) -> None:
        """Reset the bristles of friction on some nodes to zero, as at first contact.

        Args:
            nodes: Indices, shape (n,).
        """
        contact = self.contact
        if contact is not None and len(contact.memory):
            settled = contact.are_at(nodes)
            self.velocity[contact.memory[settled]] = 0.0

    def place_held(self) -> None:
        """Move driven nodes to their paths and let all else that is held rest, at ``time``.

        Threads that are drawn in or paid out are as long as they are then.
        """
        self.keep_rest()
        for nodes in self.holders.values():
            self.velocity[nodes] = 0.0
        if self.guides is not None:
            self.guides.keep(self.velocity)
        for motion in self.motions.values():
            motion.put(self.time, self.position, self.velocity)
        self.follow_hosts()

    def guide(self) -> None:
        """Find again which nodes are guided, and how motions do, after ``directed`` changed."""
        drawn, count = self.network.guides, self.network.node_count
        if drawn is not None and self.is_cut:
            nodes = self.with_copies(drawn.nodes)
            drawn = drawn.some(nodes, self.network.parents[nodes])
        self.guides = guides_of(drawn, self.directed.values(), count)
        for name, hold in self.directed.items():
            if (motion := self.motions.get(name)) is not None:
                rest = [one for one in self.directed.values() if one is not hold]
                others = guides_of(drawn, rest, count)
                change = prescribing(others, motion.nodes, hold.directions)
                self.motions[name] = replace(motion, change=change)

    def follow_hosts(self) -> None:
        """Set positions and velocities of embedded nodes by those of their hosts."""
        if (embedding := self.embedding) is not None:
            embedding.follow(self.position)
            embedding.follow(self.velocity)


def _parting(network: Network, knot: Knot, position: Floats, velocity: Floats) -> float:
    """Return how fast the ends of a thread part [m/s]."""
    first, second = network.springs.ends[knot.slip]
    reach = position[second] - position[first]
    distance = float(np.linalg.norm(reach))
    return float(np.vdot(reach, velocity[second] - velocity[first])) / (distance or 1.0)
