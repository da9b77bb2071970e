"""Bodies: a mesh, its tissue, and regions with tissues of their own."""

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from tissuec.core import units
from tissuec.core.errors import Note
from tissuec.core.fields import OneOf, Point, Real
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.meshes.generators import MESHES, Generator
from tissuec.meshes.generators.lattice import Lattice
from tissuec.model.network import Floats
from tissuec.scene import schema
from tissuec.scene.appearance import APPEARANCE
from tissuec.scene.declarations import Declarations, without
from tissuec.scene.element_bodies import (
    CUBIC,
    read_made_of,
    refuse,
    refuse_entries,
    refuse_mesh,
)
from tissuec.scene.entry_meanings import left_side, unknown_entry
from tissuec.scene.expressions import Scope
from tissuec.scene.findings import Findings
from tissuec.scene.model import (
    AssignedQuantity,
    Bending,
    Body,
    Region,
    SpringPart,
    Tables,
    Tissue,
    WrittenLaws,
)
from tissuec.scene.quantities import QUANTITIES
from tissuec.scene.tables import explicit_tables, tables_of
from tissuec.scene.written_numbers import read_given

EXPLICIT = "explicit"
INTERFACES = ("mean", "softer", "stiffer")

#: Of nets from tables, and of joints.
SECTION = schema.Entry(
    "section",
    "section",
    Real(units.AREA, above=0.0),
    None,
    "cross-section of each spring, if the body is made of matter",
)
#: Entries of a body beside mesh, tissue and regions.
BODY_ENTRIES: dict[str, schema.Entry] = {
    entry.name: entry
    for entry in (
        schema.Entry(
            "mass",
            "mass",
            Real(units.MASS, above=0.0),
            None,
            "mass of the whole body, shared equally by its nodes; by volume in elements",
        ),
        schema.Entry(
            "thickness",
            "thickness",
            Real(units.LENGTH, above=0.0),
            None,
            "thickness of a sheet or a wall that is made of matter",
        ),
        SECTION,
        schema.Entry(
            "interface",
            "interface",
            OneOf(INTERFACES),
            "",
            "the material of springs between two regions",
        ),
        schema.Entry("velocity", "velocity", Point(units.VELOCITY), None, "initial velocity"),
        schema.Entry(
            "spin",
            "spin",
            Point(units.FREQUENCY),
            None,
            "initial rotation about the centre of mass, in rad/s",
        ),
    )
}
_PART = Real(units.NUMBER, at_least=0.0, at_most=100.0)
SECOND_FIBRES = "second fibres"
AXIAL, CIRCUMFERENTIAL = "axial", "circumferential"  # fibres of a tube
ELASTIC = "elastic"  # how a wall of matter resists bending
#: How stiff bending springs are in words, as parts of the tissue's springs.
BENDING = {"none": 0.0, "soft": 0.05, "medium": 0.2, "stiff": 1.0}
_CHOICES = (*BENDING, ELASTIC)
ENTRIES = (
    "mesh", "made", "tissue", "region", "springs", "rupture", "bending", "fibres",
    SECOND_FIBRES,
    *BODY_ENTRIES,
)  # fmt: skip
#: What is said of a body elsewhere, and how.
ELSEWHERE = {
    "volume": "write in the script, for example: at 0 s: preserve volume of NAME with 10 kPa"
}


def read_body(
    name: s.Name,
    item: s.Item,
    tissues: Mapping[str, Tissue],
    laws: Mapping[str, WrittenLaws],
    declarations: Declarations,
    scope: Scope,
) -> Body:
    """Return a body from its block, or reject it if it cannot be drawn."""
    assert isinstance(item, s.Block)
    return _BodyReader(name, item, tissues, laws, declarations, scope).read()


def read_tissue(
    item: s.Assign | s.Sentence | s.Block,
    tissues: Mapping[str, Tissue],
    declarations: Declarations,
    scope: Scope,
) -> Tissue:
    """Return the tissue that ``tissue is …`` names."""
    name = schema.word_of(item, scope, example="tissue is fallopian tube")
    properties = [] if name.key in tissues else _properties_with(name.key, declarations)
    if properties and name.key not in declarations.of("tissue"):
        words = f"{properties[0]} is {name.text}"
        scope.findings.reject(
            "TIS301",
            f'there is no tissue called "{name.text}"; it is a word for {properties[0]}',
            name.span,
            hint=f"describe a tissue with it: tissue NAME {{ described in …; {words}; … }}",
        )
    declarations.find("tissue", name, scope.findings)
    if name.key not in tissues:
        scope.findings.stop()  # the tissue itself was found wrong
    return tissues[name.key]


def _properties_with(word: str, declarations: Declarations) -> list[str]:
    """Return the properties that have a word of this name."""
    return [
        declared.name.text
        for declared in declarations.of("property").values()
        if isinstance(declared.item, s.Block)
        and any(
            isinstance(part, s.Name) and part.key == word for part in walk(declared.item.items)
        )
    ]


def read_rupture(item: s.Assign | s.Sentence | s.Block, findings: Findings) -> bool:
    """Return what ``rupture is …`` says."""
    phrase = None if isinstance(item, s.Assign) else item.phrase
    if phrase is None or phrase.words[0].key != "allowed" or phrase.kind == "between":
        forms = [f"{left_side(item)} is {word}" for word in ("allowed", "not allowed")]
        findings.reject(
            "TIS305",
            "rupture is either allowed or not",
            item.span,
            hint=Hint(f"write {', or '.join(forms)}", *map(Edit, forms)),
        )
    return phrase.kind == "word"


def _is_made_of(item: s.Item) -> bool:
    """Return whether an item says what a body is made of, in its right form or another one."""
    if not isinstance(item, s.Assign | s.Sentence | s.Block):
        return False
    return item.name.key == "made" or item.name.key.startswith("made ")


class _BodyReader:
    """One reading of one body block."""

    def __init__(
        self,
        name: s.Name,
        block: s.Block,
        tissues: Mapping[str, Tissue],
        laws: Mapping[str, WrittenLaws],
        declarations: Declarations,
        scope: Scope,
    ):
        self.name = name
        self.block = block
        self.tissues, self.laws = tissues, laws
        self.declarations = declarations
        self.scope = scope
        self.findings = scope.findings
        self.once: dict[str, Span] = {}
        self.mesh: Generator | None = None
        self.mesh_kind = ""
        self.tissue: Tissue | None = None
        self.regions: list[Region] = []
        self.spring_parts: list[SpringPart] = []
        self.may_rupture = False
        self.bending: Bending | None = None
        self.fibres: Floats | str | None = None
        self.second_fibres: Floats | str | None = None
        self.shell: Span | None = None
        self.elements: Span | None = None
        self.may_be_elements = False  # also where that is written wrong
        self.mesh_places: Mapping[str, Span] = {}
        self.rest: dict[str, Any] = {}

    def read(self) -> Body:
        failures = self.findings.failures
        for item in sorted(self.block.items, key=lambda item: not _is_made_of(item)):
            with self.findings.item():
                self._item(item)
                continue
            self._doubt(item)
        is_whole = self.findings.failures == failures
        if self.mesh is None and self.mesh_kind != EXPLICIT and not is_whole:
            self.findings.stop()  # the mesh may be what is wrong
        tables = self._tables()
        if self.mesh is None and self.mesh_kind != EXPLICIT:
            self.findings.reject(
                "TIS304",
                f'body {self.name.text} needs "mesh"',
                self.block.head,
                hint="for example: mesh is tube { … }",
            )
        if self.elements is not None:
            self._refuse_springs(self.elements)
            is_whole = self.findings.failures == failures
        elif self.regions and is_whole:
            is_whole = self._has_interface()
        if SECOND_FIBRES in self.once and self.elements is None:
            self.findings.add(
                "TIS306",
                "only a body of elements can have a second family of fibres",
                self.once[SECOND_FIBRES],
                hint="write made of elements, or remove second fibres",
            )
        zero = np.zeros(3)
        return Body(
            name=self.name.text,
            mesh=self.mesh,
            tables=tables,
            tissue=self.tissue,
            regions=tuple(self.regions),
            interface=self.rest.get("interface", ""),
            spring_parts=tuple(sorted(self.spring_parts, key=lambda part: part.sides is None)),
            may_rupture=self.may_rupture,
            bending=self.bending,
            fibres=self.fibres,
            second_fibres=self.second_fibres,
            shell=self.shell,
            elements=self.elements,
            mass=self.rest.get("mass"),
            thickness=self.rest.get("thickness"),
            section=self.rest.get("section"),
            velocity=self.rest.get("velocity", zero),
            spin=self.rest.get("spin", zero),
            places=self.once,
            is_whole=is_whole,
            span=self.block.head,
        )

    def _has_interface(self) -> bool:
        """Return whether something says what springs between regions are made of."""
        if "interface" in self.rest or any(part.sides for part in self.spring_parts):
            return True
        head = self.block.head
        words = ("mean", "softer", "stiffer")
        missing = [schema.missing(f"interface is {word}", head) for word in words]
        self.findings.add(
            "TIS304",
            f'body {self.name.text} has regions, so it needs "interface"',
            head,
            hint=Hint(
                "write interface is mean, softer or stiffer, which sets "
                "the material of springs between two regions",
                *(edit for hint in missing for edit in hint.edits),
            ),
        )
        return False

    def _doubt(self, item: s.Item) -> None:
        """Make doubtful the region that a rejected item may have been."""
        if isinstance(item, s.Block) and item.name.key not in ENTRIES:
            self.findings.doubt(item.name)

    def _item(self, item: s.Item) -> None:
        if not isinstance(item, s.Assign | s.Sentence | s.Block):
            self.findings.reject("TIS303", "this is not allowed in a body", item.span)
        if isinstance(item, s.Block) and (region := without(item.name, "region")) is not None:
            self.regions.append(self._region(region, item))
            return
        key = "made" if _is_made_of(item) else item.name.key
        if key == "interface" and not isinstance(item, s.Assign) and item.clauses:
            self.spring_parts.append(self._interface(item))
            return
        if key == "springs":
            self.spring_parts.append(self._springs(item))
            return
        if key in self.once:
            self.findings.refuse_second(f'"{key}"', item.span, self.once[key])
        self.once[key] = item.span
        if key == "mesh":
            self._mesh(item)
        elif key == "made":
            self.may_be_elements = True
            self.elements = read_made_of(item, self.tissues, self.findings)
            self.may_be_elements = self.elements is not None
        elif key == "tissue":
            self.tissue = self._tissue(item)
        elif key == "rupture":
            self.may_rupture = read_rupture(item, self.findings)
        elif key == "bending":
            self._bending(item)
        elif key == "fibres":
            self.fibres = self._fibres(item)
        elif key == SECOND_FIBRES:
            self.second_fibres = self._fibres(item)
        elif key in BODY_ENTRIES:
            self.rest[key] = schema.read_entry(BODY_ENTRIES[key], item, self.scope)
        else:
            told = ELSEWHERE.get(key) or schema.chosen(item, ENTRIES) or self._elsewhere(item)
            self.findings.reject(
                "TIS303",
                f'"{item.name.text}" is not an entry of a body',
                item.name.span,
                hint=told or unknown_entry(item, ENTRIES),
            )

    def _elsewhere(self, item: s.Assign | s.Sentence | s.Block) -> str:
        """Return where an entry belongs that is one of a tissue or of the mesh, or ""."""
        key, text = item.name.key, item.span.one_line
        if key in APPEARANCE:
            return "it is an entry of tissues; move it into the tissue block of this body"
        if key in QUANTITIES:
            return (
                f"it describes tissue: write tissue NAME {{ {text} }}, and in the body "
                "tissue is NAME"
            )
        for kind in (self.mesh_kind,) if self.mesh_kind else MESHES:
            if kind != EXPLICIT and key in schema.entries_of(MESHES[kind]):
                return f"it describes the mesh: write mesh is {kind} {{ {text} }}"
        return ""

    def _mesh(self, item: s.Assign | s.Sentence | s.Block) -> None:
        kind = schema.word_of(item, self.scope, example="mesh is tube { … }")
        if kind.key not in MESHES:
            self.findings.reject(
                "TIS305",
                f'there is no mesh called "{kind.text}"',
                kind.span,
                hint=alternatives(kind.key, MESHES, what="meshes"),
            )
        self.mesh_kind = kind.key
        if kind.key == EXPLICIT:
            if isinstance(item, s.Block) and item.items:
                self.findings.reject(
                    "TIS303",
                    "an explicit mesh is given by tables, not by entries",
                    item.items[0].span,
                    hint=f"table nodes of {self.name.text} in mm "
                    'with columns "id x y z" { … }',
                )
            return
        items = item.items if isinstance(item, s.Block) else ()
        where = item.head if isinstance(item, s.Block) else item.span
        is_cubic = self.may_be_elements and MESHES[kind.key] is Lattice
        self.mesh, self.mesh_places = schema.build(
            MESHES[kind.key], items, self.scope, what=f"mesh {kind.key}", where=where,
            usual={"kind": CUBIC} if is_cubic else None,
        )  # fmt: skip

    def _refuse_springs(self, made: Span) -> None:
        """Report what a body of elements says of springs."""
        if self.mesh is not None or self.mesh_kind == EXPLICIT:
            head = self.once["mesh"]
            refuse_mesh(self.mesh, head, self.mesh_places, made, self.findings)
        refuse_entries(self.once, made, self.findings)
        self.bending = None
        if self.may_rupture:
            refuse("rupture", self.once["rupture"], made, self.findings)
        for region in self.regions:
            if region.prestress is not None:
                refuse("prestress", region.prestress.span, made, self.findings)
        for part in self.spring_parts:
            what = f"a tissue for {part.name}"
            refuse(what, part.span, made, self.findings, is_block=True)

    def _tissue(self, item: s.Assign | s.Sentence | s.Block) -> Tissue:
        return read_tissue(item, self.tissues, self.declarations, self.scope)

    def _fibres(self, item: s.Assign | s.Sentence | s.Block) -> Floats | str:
        """Return the direction of fibres [1], or how they run in a tube."""
        if not isinstance(item, s.Assign):
            example = "fibres is axial, or fibres = (1, 0, 0)"
            word = schema.word_of(item, self.scope, example=example)
            known = (AXIAL, CIRCUMFERENTIAL)
            if word.key in known:
                return word.key
            self.findings.reject(
                "TIS305", f'fibres cannot be "{word.text}"', word.span,
                hint=f"{alternatives(word.key, known, what='choices')}, or fibres = (1, 0, 0)",
            )  # fmt: skip
        entry = schema.Entry("fibres", "fibres", Point(units.NUMBER), None, "")
        direction = np.asarray(schema.read_entry(entry, item, self.scope), dtype=float)
        if not direction.any():
            self.findings.reject(
                "TIS308", "fibres need a direction", item.span, hint="write fibres = (1, 0, 0)"
            )
        return direction / np.linalg.norm(direction)

    def _bending(self, item: s.Assign | s.Sentence | s.Block) -> None:
        """Read how the body resists bending: by springs beside the tissue's, or as a shell."""
        example = "bending is soft, or bending = 20 %"
        if isinstance(item, s.Assign) and item.value.span.text.lower() in _CHOICES:
            schema.refuse_sign(item, self.scope, example=example)
        if isinstance(item, s.Assign):
            entry = schema.Entry("bending", "bending", _PART, 0.0, "")
            part = schema.read_entry(entry, item, self.scope)
        else:
            word = schema.word_of(item, self.scope, example=example)
            if word.key == ELASTIC:
                self.shell = item.span
                return
            part = self._named_part(word)
        self.bending = Bending(part, item.span) if part else None

    def _named_part(self, word: s.Name) -> float:
        """Return how stiff bending springs are by a word."""
        if word.key not in BENDING:
            self.findings.reject(
                "TIS305",
                f'bending cannot be "{word.text}"',
                word.span,
                hint=f"{alternatives(word.key, _CHOICES, what='choices')}, or bending = 20 %",
            )
        return BENDING[word.key]

    def _region(self, name: s.Name, block: s.Block) -> Region:
        if [clause.word for clause in block.clauses] != ["where"]:
            self.findings.reject(
                "TIS312",
                "a region needs one condition",
                block.head,
                hint=f"region {name.text} where z > 10 mm {{ tissue is … }}",
            )
        for other in self.regions:
            if s.key_of(other.name) == name.key:
                self.findings.reject(
                    "TIS503",
                    f'region "{name.text}" is defined twice',
                    name.span,
                    notes=(Note("first here", other.span),),
                )
        made_of = self._made_of(block, "a region")
        return Region(name.text, block.clauses[0].value, *made_of, block.head)

    def _made_of(
        self, block: s.Block, what: str
    ) -> tuple[Tissue | None, AssignedQuantity | None]:
        """Return the tissue and the prestress of a part of the body."""
        tissue: Tissue | None = None
        prestress: AssignedQuantity | None = None
        for item in block.items:
            with self.findings.item():  # a part is there whatever it is made of
                if (
                    isinstance(item, s.Assign | s.Sentence | s.Block)
                    and item.name.key == "tissue"
                ):
                    tissue = self._tissue(item)
                elif isinstance(item, s.Assign) and item.name.key == "prestress":
                    prestress = read_given("prestress", item, self.scope)
                else:
                    self.findings.reject(
                        "TIS303",
                        f"this is not an entry of {what}",
                        item.span,
                        hint="entries: tissue, prestress",
                    )
        return tissue, prestress

    def _interface(self, item: s.Sentence | s.Block) -> SpringPart:
        """Return what springs between two regions are made of."""
        span = item.head if isinstance(item, s.Block) else item.span
        names = [clause.value for clause in item.clauses]
        if (
            [clause.word for clause in item.clauses] != ["from", "to"]
            or not all(isinstance(name, s.Name) for name in names)
            or (item.phrase is None) != isinstance(item, s.Block)
        ):
            self._wrong_interface(span)
        first, second = (name for name in names if isinstance(name, s.Name))
        for other in self.spring_parts:
            sides = {side.key for side in other.sides or ()}
            if sides == {first.key, second.key}:
                what = f"the interface from {first.text} to {second.text}"
                hint = "remove one of them"  # whose block is more than its place
                self.findings.refuse_second(what, span, other.span, hint=hint)
        name = f"springs from {first.text} to {second.text}"
        if isinstance(item, s.Block):
            made_of = self._made_of(item, "an interface")
            return SpringPart(name, (first, second), None, "", *made_of, span)
        assert item.phrase is not None
        word = item.phrase.words[0]
        if item.phrase.kind != "word" or word.key not in INTERFACES:
            self.findings.reject(
                "TIS305",
                f'interface cannot be "{word.text}"',
                item.phrase.span,
                hint=alternatives(word.key, INTERFACES, what="choices"),
            )
        return SpringPart(name, (first, second), None, word.key, None, None, span)

    def _wrong_interface(self, span: Span) -> NoReturn:
        self.findings.reject(
            "TIS312",
            "a separate interface needs two regions",
            span,
            hint="write interface is softer from REGION to REGION, "
            "or interface from REGION to REGION { tissue is … }",
        )

    def _springs(self, item: s.Assign | s.Sentence | s.Block) -> SpringPart:
        """Return what chosen springs are made of."""
        is_block = isinstance(item, s.Block) and item.phrase is None
        if not is_block or [clause.word for clause in item.clauses] != ["where"]:
            self.findings.reject(
                "TIS312",
                "springs with a separate tissue need one condition",
                item.span,
                hint="write springs where length > 3 mm { tissue is … }",
            )
        assert isinstance(item, s.Block)
        made_of = self._made_of(item, "springs")
        where = item.clauses[0].value
        return SpringPart(
            f"springs where {where.span.text}", None, where, "", *made_of, item.head
        )

    def _tables(self) -> Tables | None:
        tables = tables_of(self.name, self.declarations, self.findings)
        if self.mesh_kind == EXPLICIT:
            return explicit_tables(self.name, self.block.head, tables, self.laws, self.findings)
        if tables:
            edits = (
                Edit("mesh is explicit", self.once[key]) for key in self.once if key == "mesh"
            )
            self.findings.reject(
                "TIS306",
                f"body {self.name.text} has both a mesh and a table",
                next(iter(tables.values())).name.span,
                hint=Hint("write mesh is explicit", *edits),
            )
        return None
