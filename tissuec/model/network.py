"""The compiled network: read-only arrays with the source line of each entry.

Nodes and springs are in the order of the scene and keep their numbers for good; the engine
may renumber inside, never visibly. Springs, followed by the edges of elements, are *lines*:
what is drawn and selected as such. Lines, followed by elements, are *entities*: what can be
there or be lost. The signed incidence matrix of the paper is the pair of
columns ``springs.ends``: row ``s`` has -1 at ``ends[s, 0]`` and +1 at ``ends[s, 1]``.
"""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from msgspec import Struct
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec.core.arrays import largest_side
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.model.blocks import EMBEDDING, OF_ELEMENTS, FieldBlock, NetSize
from tissuec.model.guides import Guides
from tissuec.model.interfaces import Interface
from tissuec.model.phantoms import NO_RESERVE, Phantoms, Reserve
from tissuec.model.resistance import CuttingResistance, SurfaceFriction
from tissuec.model.springs import COLUMNS, Springs
from tissuec.model.topology import PairIndex

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
# Whose internal variables there are.
SPRINGS = "springs"
FRICTION = "friction"
ELEMENTS = "elements"
CellNodes = tuple[NDArray[np.int32], NDArray[np.int32]]


def numbers_in(part: slice) -> Indices:
    """Return the numbers from the start of a slice up to its stop, shape (entry,)."""
    return np.arange(int(part.start), int(part.stop))


class Origin(Struct, frozen=True):
    """Why an entry of an array has its value."""

    span: Span
    how: str  # such as "rules", "written", "otherwise", "table", "drawn length"


class Provenance(Struct, frozen=True, eq=False):
    """The origin of every entry of one array, shape of ``index`` (entry,)."""

    index: NDArray[np.int32]
    origins: tuple[Origin, ...]

    def __getitem__(self, entry: int) -> Origin:
        return self.origins[int(self.index[entry])]


#: An array of the network and where its numbers are from.
Explained: TypeAlias = tuple[Floats, Provenance]


class Grid(NamedTuple):
    """Nodes in rows and columns, numbered row by row.

    The skin of a grid has two triangles to a cell, cell by cell in the same order: of the
    corners (0, 0), (0, 1), (1, 1) and of (0, 0), (1, 1), (1, 0), as (row, column).
    """

    rows: int
    columns: int
    closed: bool  # whether the last column is followed by the first


class ThreadBody(Struct, frozen=True):
    """A body that is a thread.

    Attributes:
        pieces: The springs along it.
        hold: Between its ends: the spring that a knot holds by. A loop has it from the start.
        slip: Beside it: takes its place while the knot slips.
        radius: Of the thread [m].
        closed: Whether it is a loop.
    """

    pieces: slice
    hold: int
    slip: int
    radius: float
    closed: bool

    @property
    def knots(self) -> list[int]:
        """Return the springs that are no piece of it, but hold or slip as a knot."""
        pieces = range(self.pieces.start, self.pieces.stop)
        return [spring for spring in (self.hold, self.slip) if spring not in pieces]


class BodyPart(Struct, frozen=True, eq=False):
    """Ranges of the nodes, springs and elements of one body in the arrays.

    Attributes:
        grid: Arrangement of its nodes in rows and columns, if there is one.
        bending: How many of its springs, the last ones, resist bending only.
        cells: Of a solid body, gives the cells that it is divided into, all of them alike:
            nodes of the faces, shape (cell, face, 4), and of nodes inside, shape (cell, inner),
            counted from those of the body.
        thread: Where it is a thread.
        divided: Of a solid body, tetrahedra that divide it, counted from its nodes, shape
            (tetrahedron, 4).
        elements: Entities that are the finite elements which resist its deformation, shape by
            shape; where there are any, there are no springs.
        edges: Lines that are the edges of its elements.
        is_wall: Whether these are triangles of a wall.
        is_solid: Whether its mesh fills a volume, whatever it is made of.
        regions: Its regions with their tissues; "" comes first, for what is in none.
        element_region: Which of them each element belongs to, shape (element,); None without
            elements.
        density: Of its elements over that of any, shape (element,); None where it is even.
        interfaces: Faces between its regions that can come apart.
        reserve: How many of its nodes and elements, the last ones, are in reserve for cuts.
    """

    name: str
    nodes: slice
    springs: slice
    span: Span
    grid: Grid | None = None
    bending: int = 0
    cells: Callable[[], CellNodes] | None = None
    thread: ThreadBody | None = None
    divided: NDArray[np.int64] | None = None
    elements: slice = slice(0, 0)
    edges: slice = slice(0, 0)
    is_wall: bool = False
    is_solid: bool = False
    regions: tuple[tuple[str, str], ...] = ()
    element_region: Indices | None = None
    density: Floats | None = None
    interfaces: tuple[Interface, ...] = ()
    reserve: Reserve = NO_RESERVE

    @property
    def element_count(self) -> int:
        """Return how many finite elements it has as drawn."""
        return int(self.elements.stop - self.elements.start) - self.reserve.elements

    @property
    def is_made_of_elements(self) -> bool:
        """Return whether finite elements resist its deformation, rather than springs."""
        return self.element_count > 0

    @property
    def lines(self) -> slice:
        """Return its springs, or the edges of its elements."""
        return self.edges if self.is_made_of_elements else self.springs

    @property
    def size(self) -> NetSize:
        """Return how many nodes, and springs or elements, it has."""
        springs = self.springs.stop - self.springs.start
        nodes = self.nodes.stop - self.nodes.start - self.reserve.nodes
        return NetSize(nodes, springs, self.element_count)


class JointPart(Struct, frozen=True):
    """Springs of a joint; their nodes are those of bodies."""

    name: str
    springs: slice
    span: Span

    @property
    def lines(self) -> slice:
        """Return its springs."""
        return self.springs

    @property
    def size(self) -> NetSize:
        """Return how many springs it has."""
        return NetSize(0, self.springs.stop - self.springs.start)


#: Shapes of tools without contact.
UNTOUCHED = ("opening", "edge")


class ToolShape(NamedTuple):
    """Shapes that pairs of nodes of a tool carry.

    Attributes:
        kind: "capsule" between them, "plane" through the first and at right angles to the way
            to the second, "opening" that looks this way, or "edge" between them.
        radius: Of a capsule or an opening, and of an edge as it is drawn [m].
    """

    kind: str
    radius: float

    @property
    def seen_as(self) -> str:
        """Return the kind that it is drawn as: an edge is a thin capsule."""
        return "capsule" if self.kind == "edge" else self.kind


class ToolPart(Struct, frozen=True):
    """Nodes that carry the shapes of a tool, two each, and its kind."""

    name: str
    kind: str
    nodes: slice
    span: Span
    shapes: tuple[ToolShape, ...] = ()

    @property
    def touches(self) -> bool:
        """Return whether any of its shapes has contact."""
        return any(shape.kind not in UNTOUCHED for shape in self.shapes)

    @property
    def jaws(self) -> tuple[Indices, Indices] | None:
        """Return the nodes of the upper and of the lower jaw of forceps, shape (2,) each."""
        if self.kind != "forceps":
            return None
        start = int(self.nodes.start)
        return np.arange(start, start + 2), np.arange(start + 2, start + 4)


class InternalPart(Struct, frozen=True):
    """Internal variables of one kind, three to a row behind those of nodes.

    Attributes:
        name: Whose they are: ``SPRINGS``, ``ELEMENTS``, or of bristles ``FRICTION``.
        rows: Behind the rows of nodes.
    """

    name: str
    rows: slice


class MirrorPlane(Struct, frozen=True, eq=False):
    """A plane of symmetry.

    Attributes:
        origin: A point on it [m], shape (3,).
        normal: A unit vector, shape (3,).
        nodes: Those of bodies that lie on it, ascending, shape (n,).
    """

    origin: Floats
    normal: Floats
    nodes: Indices


class Network(Struct, frozen=True, eq=False, dict=True):
    """All mass points and springs of a scene, in SI units.

    Attributes:
        position: Drawn positions [m], shape (node, 3).
        velocity: Initial velocities [m/s], shape (node, 3).
        mass: Masses [kg], shape (node,); positive.
        springs: All springs, those of bodies first, with their numbers at the start of a run.
        edges: Node pairs of the edges of elements, body by body, shape (edge, 2).
        phantoms: In reserve for cuts.
        skin: Triangles of the bodies' surfaces, for viewers, shape (triangle, 3).
        node_ids: Ids of the author (table ids, or the number within the body), shape (node,).
        bodies: The parts of the arrays that belong to each body.
        joints: Springs after those of the bodies that join them.
        tools: Nodes after those of the bodies that carry the shapes of tools.
        skin_elements: The element of each triangle of the skin, an entity, or -1, shape
            (triangle,); None where no element may break.
        internal: Internal variables of first order: what friction, springs and elements did
            before. A state has them behind its velocities, times a rate.
        blocks: What acts beside springs from the start: elements, contact, ``force`` blocks.
        weighing: Weights of the nodes of bodies over those that their masses would have,
            dimensionless, shape (node,); None if all are 1.
        drag: Ambient damping of each node besides that of all alike [N s/m], shape (node,);
            None without any.
        friction: Coefficients that tissues give to nodes and surfaces; None without any.
        cutting: The energy that blades need; None if they need none.
        guides: Nodes on planes of symmetry; None without any.
        mirrored: Planes of symmetry; triangles between the nodes on one are no surface of the
            whole.
        provenance: Origins by array name ("mass", "stiffness", …).
    """

    position: Floats
    velocity: Floats
    mass: Floats
    springs: Springs
    skin: NDArray[np.int32]
    node_ids: Indices
    bodies: tuple[BodyPart, ...]
    provenance: Mapping[str, Provenance]
    joints: tuple[JointPart, ...] = ()
    tools: tuple[ToolPart, ...] = ()
    internal: tuple[InternalPart, ...] = ()
    blocks: tuple[FieldBlock, ...] = ()
    weighing: Floats | None = None
    drag: Floats | None = None
    skin_elements: Indices | None = None
    mirrored: tuple[MirrorPlane, ...] = ()
    friction: SurfaceFriction | None = None
    cutting: CuttingResistance | None = None
    edges: NDArray[np.int32] = np.zeros((0, 2), dtype=np.int32)
    phantoms: tuple[Phantoms, ...] = ()
    guides: Guides | None = None

    def __post_init__(self) -> None:
        for value in (*astuple(self), *astuple(self.springs)):
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __reduce__(self) -> tuple[type["Network"], tuple[object, ...]]:
        # Made anew, so that its arrays are read-only in copies, too.
        return Network, astuple(self)

    @property
    def node_count(self) -> int:
        return len(self.position)

    @property
    def spring_count(self) -> int:
        return len(self.springs.ends)

    def array(self, name: str) -> NDArray[Any]:
        """Return a column of nodes or springs in SI units, such as "mass" or "rest".

        The shape is (node, …) or (spring, …).
        """
        return getattr(self.springs if name in COLUMNS else self, name)

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> "Network":
        """Return this with other columns of nodes and springs.

        Args:
            arrays: By name, in SI units, shape (node, …) or (spring, …).
        """
        of_springs = {name: each for name, each in arrays.items() if name in COLUMNS}
        of_nodes = {name: each for name, each in arrays.items() if name not in COLUMNS}
        return replace(self, **of_nodes, springs=replace(self.springs, **of_springs))

    def of_kind(self, *kinds: str) -> tuple[Any, ...]:
        """Return the fields of the blocks of some kinds."""
        return tuple(block.field for block in self.blocks if block.kind in kinds)

    @property
    def elements(self) -> tuple[Any, ...]:
        """Return all ``solids.elements.SolidElements`` and ``surfaces.membranes.Membranes``."""
        return self.of_kind(*OF_ELEMENTS)

    def elements_of(self, body: str) -> tuple[Any, ...]:
        """Return the elements of a body, shape by shape."""
        return tuple(each for each in self.elements if each.name == body)

    def elements_within(self, nodes: Indices) -> Indices:
        """Return the elements all of whose nodes are among some, as entities, shape (n,).

        Args:
            nodes: Shape (n,).
        """
        inside = np.zeros(self.node_count, dtype=bool)
        inside[nodes] = True
        found = [each.walls[inside[each.nodes].all(axis=1)] for each in self.elements]
        return np.concatenate([np.zeros(0, dtype=np.int64), *found])

    def field(self, kind: str) -> Any:
        """The field of the first block of a kind; None if there is none."""
        return next(iter(self.of_kind(kind)), None)

    @property
    def contact(self) -> Any:
        """The ``forces.contact.Contact`` of all that can touch; None if nothing can."""
        return self.field("contact")

    def with_blocks(self, *blocks: FieldBlock) -> "Network":
        """Return this with other blocks; they replace those of the same names."""
        known = {block.name: block for block in (*self.blocks, *blocks)}
        return replace(self, blocks=tuple(known.values()))

    @property
    def row_count(self) -> int:
        """Return how many nodes and rows of internal variables there are."""
        return self.internal[-1].rows.stop if self.internal else self.node_count

    @property
    def internal_rows(self) -> slice:
        """Return the rows of internal variables, behind those of nodes."""
        return slice(self.node_count, self.row_count)

    def remembering(self, name: str) -> Indices:
        """Return the rows of internal variables of one kind, shape (row,)."""
        parts = (part.rows for part in self.internal if part.name == name)
        return numbers_in(next(parts, slice(0, 0)))

    @property
    def relaxes(self) -> bool:
        """Return whether springs relax or flow, or elements relax."""
        return self.springs.inelastic is not None or len(self.remembering(ELEMENTS)) > 0

    def with_internal(self, name: str, rows: int) -> "Network":
        """Return this with internal variables behind all others.

        Args:
            name: Whose they are.
            rows: How many, of three each.
        """
        part = InternalPart(name, slice(self.row_count, self.row_count + rows))
        return replace(self, internal=(*self.internal, part))

    def with_nodes(self, places: Floats, mass: float, known: Provenance) -> "Network":
        """Return this with nodes at rest after all others.

        Args:
            places: [m], shape (node, 3).
            mass: Of each [kg].
            known: Where their masses come from.
        """
        count, weight = len(places), self.provenance["mass"]
        index = np.concatenate([weight.index, len(weight.origins) + known.index])
        every = Provenance(index, (*weight.origins, *known.origins))
        return replace(
            self,
            position=np.concatenate([self.position, places]),
            velocity=np.concatenate([self.velocity, np.zeros_like(places)]),
            mass=np.concatenate([self.mass, np.full(count, mass)]),
            node_ids=np.concatenate([self.node_ids, np.arange(count)]),
            provenance={**self.provenance, "mass": every},
        )

    @property
    def body_nodes(self) -> int:
        """Return how many nodes belong to bodies, phantoms included; they come first."""
        return max((body.nodes.stop for body in self.bodies), default=0)

    @cached_property
    def parents(self) -> Indices:
        """Return the node that each is a copy of, itself but for phantoms, shape (node,).

        That of riders is the first node of their body.
        """
        found = np.arange(self.node_count)
        for part in self.phantoms:
            found[part.nodes], found[part.riders] = part.parents, part.parents[0]
        return found

    def moved(self, position: Floats) -> Floats:
        """Return displacements of nodes from the drawing [m], shape (…, node, 3).

        Those of riders, which are drawn nowhere, are 0.

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        found = position - self.position
        for part in self.phantoms:
            found[..., part.riders, :] = 0.0
        return found

    def phantoms_of(self, body: str) -> Phantoms | None:
        """Return the reserve of a body for cuts, by its name; None if it has none."""
        return next((part for part in self.phantoms if part.body == body), None)

    def body_named(self, name: str) -> BodyPart:
        """Return a body by its name."""
        return next(body for body in self.bodies if body.name == name)

    def body_numbers(self, nodes: Indices) -> Indices:
        """Return the numbers of the bodies of some nodes, in the shape of these.

        Args:
            nodes: Of bodies, shape (…).
        """
        ends = np.array([body.nodes.stop for body in self.bodies])
        return np.searchsorted(ends, nodes, side="right")

    def body_at(self, node: int) -> BodyPart:
        """Return the body of one of the ``body_nodes``."""
        return next(body for body in self.bodies if node < body.nodes.stop)

    @property
    def body_springs(self) -> int:
        """Return how many springs belong to bodies; they come first."""
        return self.joints[0].springs.start if self.joints else self.spring_count

    @property
    def element_count(self) -> int:
        """Return how many finite elements there are."""
        return sum(body.element_count for body in self.bodies)

    @property
    def entity_count(self) -> int:
        """Return how many entities there are: lines, elements, and the reserve for cuts."""
        reserve = sum(body.reserve.elements for body in self.bodies)
        return self.line_count + self.element_count + reserve

    @property
    def line_count(self) -> int:
        """Return how many lines there are: springs, followed by edges of elements."""
        return self.spring_count + len(self.edges)

    @cached_property
    def line_ends(self) -> NDArray[np.int32]:
        """Return the node pairs of lines, shape (line, 2)."""
        if not len(self.edges):
            return self.springs.ends
        return np.concatenate([self.springs.ends, self.edges])

    @property
    def joined_ends(self) -> NDArray[np.int32]:
        """Return the nodes of the springs of joints, shape (spring, 2)."""
        return self.springs.ends[self.body_springs :]

    @property
    def parts(self) -> tuple[BodyPart | JointPart, ...]:
        """Return all that springs belong to, in the order of their numbers."""
        return (*self.bodies, *self.joints)

    @property
    def region_names(self) -> tuple[str, ...]:
        """Return the names of regions with their bodies; "" comes first, for none."""
        named = (f"{name} of {b.name}" for b in self.bodies for name, _ in b.regions[1:])
        return ("", *named)

    @property
    def tissue_names(self) -> tuple[str, ...]:
        """Return the names of the tissues of bodies; "" stands for none."""
        return tuple(dict.fromkeys(tissue for b in self.bodies for _, tissue in b.regions))

    def skin_of(self, body: BodyPart) -> Indices:
        """Return the triangles of the surface of a body, shape (triangle, 3)."""
        return self.skin[self._is_skin_of(body)].astype(np.int64)

    def skin_elements_of(self, body: BodyPart) -> Indices | None:
        """Return the ``skin_elements`` of the triangles of ``skin_of``, shape (triangle,)."""
        every = self.skin_elements
        return None if every is None else every[self._is_skin_of(body)]

    def _is_skin_of(self, body: BodyPart) -> NDArray[np.bool_]:
        inside = (self.skin >= body.nodes.start) & (self.skin < body.nodes.stop)
        return np.asarray(inside.all(axis=1))

    @property
    def embedding(self) -> Any:
        """The ``acting.embedding.EmbeddedNodes``; None without any."""
        return self.field(EMBEDDING)

    @property
    def glued_ends(self) -> Indices:
        """Return embedded nodes beside each of their hosts, shape (host, 2).

        Of faces that are glued with a toughness, a node of either side at each point follows.
        """
        found = [np.zeros((0, 2), dtype=np.int64)]
        if (embedding := self.embedding) is not None:
            ends = embedding.nodes[embedding.owners], embedding.hosts
            found.append(np.stack(ends, axis=1))
        found += [each.joined_pairs for each in self.of_kind("glue")]
        return np.concatenate(found)

    @cached_property
    def glued(self) -> Indices:
        """Return pairs of bodies, nodes of the first of which are glued to the second.

        The shape is (pair, 2).
        """
        return np.unique(self.body_numbers(self.glued_ends), axis=0)

    def are_joined(self, one: BodyPart, other: BodyPart) -> bool:
        """Return whether springs of joints lead from one body to another, or glue does."""
        parts = [self.bodies.index(one), self.bodies.index(other)]
        if (np.sort(self.glued, axis=1) == np.sort(parts)).all(axis=1).any():
            return True
        ends = self.joined_ends
        first, second = (
            ((ends >= body.nodes.start) & (ends < body.nodes.stop)).any(axis=1)
            for body in (one, other)
        )
        return bool((first & second).any())

    @cached_property
    def pairs(self) -> PairIndex:
        """Return the lines by their nodes."""
        return PairIndex(self.line_ends)

    def owner(self, entity: int) -> BodyPart | JointPart:
        """Return the body or joint of a spring, an edge or an element."""
        if entity < self.spring_count:
            return next(part for part in self.parts if entity < part.springs.stop)
        if entity < self.line_count:
            return next(body for body in self.bodies if entity < body.edges.stop)
        return next(body for body in self.bodies if entity < body.elements.stop)

    def number_of(self, entity: int) -> int:
        """Return the id of a spring, or the number of an edge or element in its body from 1."""
        if entity < self.spring_count:
            return int(self.springs.ids[entity])
        owner = self.owner(entity)
        assert isinstance(owner, BodyPart)
        own = owner.edges if entity < self.line_count else owner.elements
        return entity - int(own.start) + 1

    def springs_among(self, lines: Indices) -> Indices:
        """Return which of some lines are springs, shape (n,).

        Args:
            lines: Of which the others are edges of elements, shape (m,).
        """
        return lines[lines < self.spring_count]

    @property
    def of_bodies(self) -> NDArray[np.bool_]:
        """Return which lines belong to bodies, not to joints, shape (line,)."""
        found = np.ones(self.line_count, dtype=bool)
        found[self.body_springs : self.spring_count] = False
        return found

    @property
    def shown_lines(self) -> NDArray[np.bool_]:
        """Return which lines are shown: no springs that only bend, shape (line,)."""
        return ~self.bends

    @property
    def bears(self) -> NDArray[np.bool_]:
        """Return which lines can bear a force, shape (line,); edges of elements do not."""
        springs, bears = self.springs, np.zeros(self.line_count, dtype=bool)
        bears[: self.spring_count] = (springs.stiffness > 0.0) | (springs.law > 0)
        return bears

    @property
    def bends(self) -> NDArray[np.bool_]:
        """Return which lines are springs that resist bending only, shape (line,)."""
        bends = np.zeros(self.line_count, dtype=bool)
        for body in self.bodies:
            bends[body.springs.stop - body.bending : body.springs.stop] = True
        return bends

    @property
    def threads(self) -> dict[str, ThreadBody]:
        """Return the bodies that are threads, by name."""
        return {body.name: body.thread for body in self.bodies if body.thread is not None}

    @property
    def can_be_drawn_in(self) -> bool:
        """Return whether there are springs whose length can be changed in time."""
        return bool(self.threads or self.joints)

    @property
    def size(self) -> NetSize:
        """Return how many nodes, springs and elements its bodies and joints have."""
        reserve = sum(body.reserve.nodes for body in self.bodies)
        return NetSize(self.body_nodes - reserve, self.spring_count, self.element_count)

    @property
    def present(self) -> NDArray[np.bool_]:
        """Return which entities are there from the start, shape (entity,); knots are not."""
        present = np.ones(self.entity_count, dtype=bool)
        for part in self.phantoms:
            present[part.elements] = False
        for thread in self.threads.values():
            present[thread.slip] = False
            present[thread.hold] = thread.closed
        return present

    @property
    def extent(self) -> float:
        """Return the largest side of the bounding box of the drawing [m]; 0 without nodes."""
        return largest_side(self.position)
