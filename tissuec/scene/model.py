"""Scene: everything a text says, with names bound and numbers in SI units, before any mesh."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from msgspec import Struct, field

from tissuec.core.source import Source, Span
from tissuec.forces.acting import Force
from tissuec.geometry.affine import Affine
from tissuec.lang import syntax as s
from tissuec.laws import SpringLaw, ViscosityLaw
from tissuec.laws.formula import Formula
from tissuec.laws.solid import SolidLaw
from tissuec.laws.uniaxial import Stiffening
from tissuec.meshes.generators import Generator, is_wall
from tissuec.model.network import UNTOUCHED, Floats
from tissuec.scene.environment import Environment
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.program.metadata import Metadata
from tissuec.scene.program.parameters import Constants
from tissuec.scene.sentences import WrittenTable
from tissuec.scene.tissues.known_curves import KnownCurve
from tissuec.scene.tissues.quantities import LEFT_OUT, STIFFENING, Spread, TissueQuantity
from tissuec.scene.words.vocabulary import Vocabulary
from tissuec.script.plan import Simulation
from tissuec.script.tools import Shape, ToolKind, kinds_in

if TYPE_CHECKING:
    from tissuec.scene.bodies.fibres import Direction
    from tissuec.scene.learning.model import VocabularyFit, WrittenFitProblem
    from tissuec.scene.study.model import Study

#: Limits by which springs and elements break; empty if they do not.
Rupture = Literal["", "allowed", "by toughness", "by faces"]
#: By which part the truth may differ from a single number that is known.
ABOUT = 0.05


class Fired(Struct, frozen=True):
    """A rule that spoke for a quantity, for explanations."""

    word: str  # of the conclusion, as read: "low", "very low (low, shifted outward)"
    degree: float
    facts: str  # "hardness soft 1.00, elasticity big 1.00"
    span: Span  # of the rule


class AssignedQuantity(Struct, frozen=True):
    """One quantity of a tissue and where it is from.

    Attributes:
        value: In SI units.
        spread: What it belongs to.
        length: Spring length that the value holds for [m]; None: the same for every spring.
        how: "written", "rules" or "otherwise".
        span: The entry, or the first of the fired rules, or the ``otherwise``.
        fired: The rules that spoke, strongest first.
        formula: Of x, y and z, where the body grades it; then ``value`` is that of its tissue,
            to which laws refer, and holds nowhere.
    """

    quantity: TissueQuantity
    value: float
    spread: Spread
    length: float | None
    how: str
    span: Span
    fired: tuple[Fired, ...] = ()
    formula: s.Expression | None = None


class KnownQuantity(Struct, frozen=True):
    """Evidence on one quantity of a tissue.

    Attributes:
        stated: A number, or the limits of a range, in SI units.
        source: As it is named.
        is_verified: Whether the source could be looked up.
    """

    quantity: TissueQuantity
    stated: tuple[float, ...]
    source: str
    is_verified: bool
    span: Span

    @property
    def low(self) -> float:
        return min(self._limits)

    @property
    def high(self) -> float:
        return max(self._limits)

    @property
    def _limits(self) -> tuple[float, ...]:
        first, *others = self.stated
        return self.stated if others else (first * (1.0 - ABOUT), first * (1.0 + ABOUT))

    @property
    def shown(self) -> str:
        """Return the range, or the number, with its unit."""
        return " to ".join(self.quantity.show(value, digits=4) for value in self.stated)


class PropertyFact(Struct, frozen=True):
    """A property of a tissue as it was written and as the rules see it."""

    property: str
    written: str  # "soft", "between small and medium", "0.3"
    number: float
    span: Span


class WrittenLaw(Struct, frozen=True):
    """A law of springs, dashpots or solids as a tissue has it.

    Attributes:
        name: Of the law, or the formula as written.
        formula: The force of a spring or dashpot [N]; of a solid, the energy per volume in
            units of its shear modulus.
        law: The law with its constants, a member of its family; None for a free formula.
    """

    name: str
    formula: Formula
    span: Span
    law: SpringLaw | ViscosityLaw | SolidLaw | Stiffening | None = None


#: Laws that are not the usual ones, by "spring law", "viscosity law" and "solid law".
WrittenLaws: TypeAlias = Mapping[str, WrittenLaw]
#: Laws of stiffening under stretch, by entry.
STRETCHED = frozenset(("spring law", "solid law"))


class Appearance(Struct, frozen=True):
    """How a tissue looks in pictures.

    Attributes:
        colour: As "#rrggbb"; empty where none is written.
        gloss: From 0, dull, to 1; None where none is written.
    """

    colour: str = ""
    gloss: float | None = None


class Tissue(Struct, frozen=True):
    """A preset with everything it inherits.

    Attributes:
        missing: Quantities that nothing gives, with the reason, for TIS206 where one is needed.
        concluded: What rules conclude, also where a number is written, by quantity.
        written_laws: Laws that are written.
        known: Evidence, quantity by quantity.
        curves: Evidence on curves, mode by mode.
    """

    name: str
    about: str
    vocabulary: str  # name of the rules, "" without
    facts: tuple[PropertyFact, ...]
    given: Mapping[str, AssignedQuantity]
    missing: Mapping[str, str]
    concluded: Mapping[str, float]
    written_laws: WrittenLaws
    known: tuple[KnownQuantity, ...]
    curves: tuple[KnownCurve, ...]
    appearance: Appearance
    span: Span

    @property
    def gaps(self) -> Mapping[str, str]:
        """Return the missing quantities that few bodies do without, with the reason."""
        return {key: why for key, why in self.missing.items() if key not in LEFT_OUT}

    @property
    def laws(self) -> WrittenLaws:
        """Return all laws, also that of the stiffening."""
        given = self.given.get(STIFFENING)
        if (
            given is None
            or given.value == given.quantity.none
            or STRETCHED & self.written_laws.keys()
        ):
            return self.written_laws
        law = Stiffening(given.value)
        found = WrittenLaw(STIFFENING, law.force(), given.span, law)
        return {**self.written_laws, "spring law": found}


class Graded(Struct, frozen=True):
    """A quantity of the tissue of a body or a region that depends on the place.

    Attributes:
        formula: Of x, y and z, the coordinates of the body as drawn.
        span: The entry.
    """

    quantity: TissueQuantity
    formula: s.Expression
    span: Span


class Region(Struct, frozen=True):
    """A part of a body with a tissue of its own."""

    name: str
    where: s.Expression
    tissue: Tissue | None  # None: the body's
    prestress: AssignedQuantity | None  # overrides the tissue's
    span: Span
    graded: tuple[Graded, ...] = ()  # the later of two counts


class SpringPart(Struct, frozen=True):
    """Springs of a body that are made of something else than their nodes.

    Attributes:
        name: As messages call it.
        sides: Regions between which they lead, or the body for what is in none; None where a
            condition chooses them.
        where: What they meet; None between regions.
        rule: "mean", "softer" or "stiffer" for springs that are made of both sides; else "".
        tissue: None: the body's, or that of a rule.
        prestress: Overrides the tissue's.
    """

    name: str
    sides: tuple[s.Name, s.Name] | None
    where: s.Expression | None
    rule: str
    tissue: Tissue | None
    prestress: AssignedQuantity | None
    span: Span


class RegionInterface(Struct, frozen=True):
    """Faces between the elements of two regions that can come apart.

    Attributes:
        sides: The regions, or the body for what is in none.
        toughness: Energy per area as drawn [J/m²].
    """

    sides: tuple[s.Name, s.Name]
    toughness: float
    span: Span

    @property
    def name(self) -> str:
        """Return the name in messages, such as "from wall to pad"."""
        first, second = (side.text for side in self.sides)
        return f"from {first} to {second}"


class Tables(Struct, frozen=True):
    """Explicit nodes and springs."""

    nodes: WrittenTable
    springs: WrittenTable | None
    laws: Mapping[str, WrittenLaws]  # that rows may name, by lower-case name


class Bending(Struct, frozen=True):
    """Springs between second neighbours of a surface."""

    part: float  # of the tissue's spring constant and viscosity; above zero
    span: Span


class PrestressDirection(Struct, frozen=True, eq=False):
    """A direction of prestress.

    Attributes:
        axis: Unit vector, shape (3,).
        is_across: Whether all directions of the plane with this normal are stretched, and not
            the axis.
    """

    axis: Floats
    is_across: bool = False


class MadeOfElements(Struct, frozen=True):
    """Why a body consists of finite elements.

    Attributes:
        span: ``made of elements``, or else the entry that gives a solid its tissue in pascals.
        is_written: Whether it is the first of these.
        is_quadratic: Whether hexahedra have 27 nodes.
    """

    span: Span
    is_written: bool
    is_quadratic: bool = False


class Body(Struct, frozen=True, eq=False, kw_only=True):
    """A mesh made of tissue.

    Attributes:
        mesh: The generator; None for an explicit mesh, which is in ``tables``.
        mesh_placement: What its mesh block does with the mesh; None if it stays where it is.
        placement: What is then done with the body as it is described: its mesh, regions and
            directions; None if it stays where it is.
        tissue: None where tables give everything.
        thickness, section: Of a wall [m], of the springs of an explicit net [m²]; None if not
            written.
        mass: Of the whole body [kg], overriding the tissue's; None if not written.
        interface: "mean", "softer" or "stiffer": what springs between two regions are made of
            if no part says it; "" if not written.
        spring_parts: Springs with a tissue of their own, between regions before chosen ones.
        interfaces: Faces between regions of elements that can come apart.
        rupture: ``rupture is allowed``, ``by toughness`` or ``by faces``; empty if not written.
        bending: Springs between second neighbours; None without any.
        fibres: Their direction, or "axial" or "circumferential" in a tube; None if not written.
        second_fibres: Of a body of elements, the direction of another family; None without.
        prestress: Of a body of elements, the direction of its prestress; None if not written.
        shell: The entry that gives bending stiffness by the thickness of the wall, or None.
        elements: Why it consists of finite elements; None if it consists of springs.
        is_whole: Whether all of it could be read. Otherwise its mesh and regions hold, and no
            more: sets can be chosen from it.
        velocity: Initial velocity [m/s], shape (3,).
        spin: Initial angular velocity about the centre of mass [rad/s], shape (3,).
        places: Where entries are written, by their names.
        graded: Quantities of its tissue that depend on the place; they hold in regions without
            a tissue of their own, too.
        is_refined: Whether cells are shorter than written, so that ids select nothing.
    """

    name: str
    span: Span
    mesh: Generator | None = None
    tables: Tables | None = None
    mesh_placement: Affine | None = None
    placement: Affine | None = None
    tissue: Tissue | None = None
    regions: tuple[Region, ...] = ()
    interface: str = ""
    spring_parts: tuple[SpringPart, ...] = ()
    interfaces: tuple[RegionInterface, ...] = ()
    rupture: Rupture = ""
    bending: Bending | None = None
    fibres: "Direction | None" = None
    second_fibres: "Direction | None" = None
    prestress: PrestressDirection | None = None
    shell: Span | None = None
    elements: MadeOfElements | None = None
    mass: float | None = None
    thickness: float | None = None
    section: float | None = None
    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    spin: Floats = field(default_factory=lambda: np.zeros(3))
    places: Mapping[str, Span] = {}
    is_whole: bool = True
    graded: tuple[Graded, ...] = ()
    is_refined: bool = False

    @property
    def whole_placement(self) -> Affine | None:
        """Return the total placement of the mesh; None if it stays where it is."""
        if self.mesh_placement is None or self.placement is None:
            return self.placement or self.mesh_placement
        return self.mesh_placement.then(self.placement)

    @property
    def may_rupture(self) -> bool:
        """Return whether it breaks where a limit is exceeded."""
        return bool(self.rupture)

    @property
    def tears_by_faces(self) -> bool:
        """Return whether faces open in it where a limit is exceeded."""
        return self.rupture == "by faces"

    @property
    def is_wall(self) -> bool:
        """Return whether it is a wall made of elements."""
        return self.elements is not None and is_wall(self.mesh)

    @property
    def tissues(self) -> tuple[Tissue, ...]:
        """The tissues of the body and its parts."""
        parts = (self, *self.regions, *self.spring_parts)
        return tuple(part.tissue for part in parts if part.tissue is not None)


class Joint(Struct, frozen=True, eq=False):
    """Springs from nodes to others.

    Attributes:
        ends: Sets or bodies on either side.
        reach: Drawn length up to which nodes are joined [m]; infinite if not written.
        joins_all: Whether all within reach are joined, and not each with the nearest one only.
        section: Of each spring [m²]; None if not written.
    """

    name: str
    ends: tuple[s.Name, s.Name]
    reach: float
    joins_all: bool
    section: float | None
    tissue: Tissue
    rupture: Rupture
    span: Span


class Glue(Struct, frozen=True, eq=False):
    """Nodes that are embedded in a body, or faces that are tied to it and can come apart.

    Attributes:
        ends: The set or body that is glued, and that to which it is.
        reach: Distance from the other side as drawn up to which nodes are glued [m]; None if
            not written.
        toughness: Energy per area as drawn at which faces come apart [J/m²]; None of nodes that
            are embedded.
    """

    name: str
    ends: tuple[s.Name, s.Name]
    reach: float | None
    toughness: float | None
    span: Span


class WrittenForce(Struct, frozen=True):
    """A force on nodes, from its block.

    Attributes:
        kind: A member of ``FORCES``.
        target: The set or body that it acts on.
        entries: What is written of it.
        places: Where each entry is written.
    """

    name: str
    kind: str
    target: s.Name
    entries: Force
    places: Mapping[str, Span]
    span: Span


class Tool(Struct, frozen=True):
    """A tool.

    Attributes:
        kind: A member of ``TOOLS``; "" where what was written is wrong.
        shapes: What it touches with; empty if it acts by name only.
        entries: What is written of it; None where that is wrong.
    """

    name: str
    kind: str
    shapes: tuple[Shape, ...]
    entries: ToolKind | None
    span: Span

    @property
    def may_touch(self) -> bool:
        """Return whether it has no opening or edge, whose place alone counts."""
        return all(shape.kind not in UNTOUCHED for shape in self.shapes)

    @property
    def holds_nodes(self) -> bool:
        """Return whether it can hold nodes: those of its shape, or those that it grasps.

        One that is wrong may have had a shape.
        """
        return bool(self.shapes) or self.kind in kinds_in("grasping") or self.entries is None

    def may_be(self, kind: str) -> bool:
        """Return whether this tool is of a kind, as far as its kind is known."""
        return self.kind in (kind, "")


class Scene(Struct, frozen=True, eq=False):
    """A whole text, resolved; ``declarations`` still holds what needs meshes, such as sets.

    Wrong parts are left out or, in environment and simulation, replaced.
    """

    source: Source
    imports: tuple[Source, ...]  # files that it uses, in the order of reading
    metadata: Metadata
    declarations: Declarations
    constants: Constants
    vocabulary: Vocabulary
    tissues: Mapping[str, Tissue]
    bodies: Mapping[str, Body]
    joints: Mapping[str, Joint]
    glues: Mapping[str, Glue]
    tools: Mapping[str, Tool]
    forces: Mapping[str, WrittenForce]
    environment: Environment
    simulation: Simulation
    fit_problems: "Mapping[str, WrittenFitProblem]"
    vocabulary_fits: "Mapping[str, VocabularyFit]"
    studies: "Mapping[str, Study]"
    overrides: tuple[str, ...]  # texts of --set
    #: What blocks contain that a declaration of their kind reads, by kind and name.
    blocks: Mapping[str, Mapping[str, Any]] = {}

    @property
    def embeddings(self) -> list[Glue]:
        """Return the glue that never comes apart."""
        return [glue for glue in self.glues.values() if glue.toughness is None]

    @property
    def peeling(self) -> list[Glue]:
        """Return the glue with a toughness."""
        return [glue for glue in self.glues.values() if glue.toughness is not None]
