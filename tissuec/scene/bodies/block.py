"""Bodies: a mesh, its tissue, and regions with tissues of their own."""

from collections.abc import Mapping
from typing import Any

from tissuec.core.errors import Note
from tissuec.core.fields import OneOf
from tissuec.core.hints import Edit, Hint, alternatives, leaving_out
from tissuec.core.source import Span
from tissuec.geometry.affine import Affine
from tissuec.lang import syntax as s
from tissuec.meshes.generators import MESHES, Generator, is_wall
from tissuec.meshes.generators.imported import Imported
from tissuec.meshes.generators.lattice import Lattice
from tissuec.scene.bodies.bending import BENDING_ENTRY
from tissuec.scene.bodies.elements import (
    CUBIC,
    MADE_ENTRY,
    as_matter,
    can_be_elements,
    has_matter,
    read_made_of,
    refuse,
    refuse_entries,
    refuse_mesh,
    refuse_quadratic,
    refuse_springs,
)
from tissuec.scene.bodies.entries import RUPTURE, VALUES
from tissuec.scene.bodies.fibres import FIBRES_ENTRY, SECOND_FIBRES, SECOND_FIBRES_ENTRY
from tissuec.scene.bodies.likeness import BODY_KIND, names_like
from tissuec.scene.bodies.parts import (
    INTERFACE_ENTRY,
    REGION_ENTRY,
    SPRINGS_ENTRY,
    PartReader,
)
from tissuec.scene.bodies.placement import PLACEMENT_ENTRIES, is_placement, read_placement
from tissuec.scene.bodies.prestress import DIRECTION_ENTRY, PRESTRESS
from tissuec.scene.bodies.tables import explicit_tables
from tissuec.scene.model import Bending, Body, Graded, MadeOfElements, Tables, Tissue
from tissuec.scene.program.declarations import Declared, without
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import (
    NEEDED,
    BlockEntries,
    by_name,
    entries_of_members,
    entry,
)
from tissuec.scene.reading.entry_hints import unknown_entry
from tissuec.scene.reading.graded import (
    GRADABLE,
    GRADED_ENTRIES,
    is_graded,
    read_graded,
    refuse_even,
    require_of_tissue,
    with_graded,
)
from tissuec.scene.reading.parts import SCENE, block, declare
from tissuec.scene.sentences import WrittenTable
from tissuec.scene.tissues.appearance import APPEARANCE
from tissuec.scene.tissues.names import read_tissue, tissue_entry
from tissuec.scene.tissues.quantities import QUANTITIES

EXPLICIT = "explicit"
ENTRIES = by_name(
    entry(
        "mesh", OneOf(MESHES, True, MESHES), "the mesh of nodes and springs", NEEDED,
        opens=BlockEntries(
            lambda kind: {**entries_of_members(MESHES, kind), **PLACEMENT_ENTRIES}
        ),
    ),
    MADE_ENTRY, tissue_entry("the tissue of the body"), REGION_ENTRY, SPRINGS_ENTRY, RUPTURE,
    BENDING_ENTRY, FIBRES_ENTRY, SECOND_FIBRES_ENTRY, DIRECTION_ENTRY, INTERFACE_ENTRY,
    *PLACEMENT_ENTRIES.values(), *VALUES,
)  # fmt: skip
declare(
    "body", "A mesh made of tissue.", 22, sentences=BODY_KIND.forms,
    example="body NAME { … }",
    block=block(with_graded(ENTRIES), elsewhere=GRADED_ENTRIES.keys() - ENTRIES.keys()),
    names=SCENE, entries_vary=True,
    read=lambda program, declared: _BodyReader(program, declared).read(),
)  # fmt: skip
#: What is said of a body elsewhere, and how.
ELSEWHERE = {
    "volume": "write in the script, for example: at 0 s: preserve volume of NAME with 10 kPa"
}


def _is_made_of(item: s.Item) -> bool:
    """Return whether an item says what a body is made of, in its right form or another one."""
    if not isinstance(item, s.Assign | s.Sentence | s.Block):
        return False
    return item.name.key == "made" or item.name.key.startswith("made ")


def _order(item: s.Item) -> int:
    """Return when an item is read: what a body is made of before its mesh."""
    if _is_made_of(item):
        return 0
    is_entry = isinstance(item, s.Assign | s.Sentence | s.Block)
    is_tissue = is_entry and (
        item.name.key == "tissue" or without(item.name, "region") is not None
    )
    return 1 if is_tissue else 2


class _BodyReader:
    """One reading of one body block."""

    def __init__(self, program: ResolvedProgram, declared: Declared):
        assert isinstance(declared.item, s.Block)
        self.name, self.block = declared.name, declared.item
        self.tissues, self.laws = program.tissues, program.laws
        self.all_tables = program.tables
        self.declarations, self.scope = program.declarations, program.constants
        self.findings = self.scope.findings
        self.once: dict[str, Span] = {}
        self.mesh: Generator | None = None
        self.mesh_kind = ""
        self.tissue: Tissue | None = None
        self.parts = PartReader(self.tissues, self.declarations, self.scope)
        self.elements: MadeOfElements | None = None
        self.may_be_elements = False  # also where that is written wrong
        self.mesh_places: Mapping[str, Span] = {}
        self.mesh_placement: Affine | None = None
        self.placements: list[s.Item] = []
        self.rest: dict[str, Any] = {}  # attributes of the body with an entry each
        self.graded: list[Graded] = []

    def read(self) -> Body:
        failures = self.findings.failures
        self._items()
        before = self.findings.failures
        placement = read_placement(self.placements, self.scope)
        if self.findings.failures > before:
            self.findings.stop()  # everything else depends on the place
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
        if "made" not in self.once:
            self.elements = as_matter(self.mesh, self._matter())
        elif not self.may_be_elements and self._is_solid_matter():
            place = self.once["made"]
            refuse_springs(self.name.text, self._matter(), place, self.findings)
            is_whole = False
        bending, shell = self.rest.pop("bending", (None, None))
        if self.elements is not None:
            shell = self._refuse_springs(self.elements, bending, shell)
            bending = None
            is_whole = self.findings.failures == failures
        elif self.parts.regions and is_whole and "interface" not in self.rest:
            is_whole = self.parts.require_interface(self.name.text, self.block.head)
        is_known = "made" in self.once or "tissue" not in self.once or self.tissue is not None
        if self.elements is None and is_known:
            self._refuse_of_elements(shell)
        if is_whole:
            self._check_graded()
            is_whole = self.findings.failures == failures
        return Body(
            name=self.name.text,
            mesh=self.mesh,
            tables=tables,
            mesh_placement=self.mesh_placement,
            placement=placement,
            tissue=self.tissue,
            regions=tuple(self.parts.regions),
            spring_parts=tuple(
                sorted(self.parts.spring_parts, key=lambda part: part.sides is None)
            ),
            interfaces=tuple(self.parts.interfaces),
            bending=bending,
            shell=shell,
            elements=self.elements,
            places=self.once,
            is_whole=is_whole,
            span=self.block.head,
            graded=tuple(self.graded),
            **self.rest,
        )

    def _check_graded(self) -> None:
        """Report graded quantities of which the tissue has none."""
        owner, regions = self.name.text, self.parts.regions
        require_of_tissue(self.graded, self.tissue, owner, self.block.head, self.findings)
        for one in regions:
            tissue = one.tissue or self.tissue
            require_of_tissue(one.graded, tissue, one.name, one.span, self.findings)

    def _items(self) -> None:
        """Read all entries; each error rejects one only."""
        for item in sorted(self.block.items, key=_order):
            with self.findings.item():
                self._item(item)
                continue
            self._doubt(item)

    def _doubt(self, item: s.Item) -> None:
        """Make doubtful the region that a rejected item may have been."""
        if isinstance(item, s.Block) and item.name.key not in ENTRIES:
            self.findings.doubt(item.name)

    def _item(self, item: s.Item) -> None:
        if not isinstance(item, s.Assign | s.Sentence | s.Block):
            self.findings.reject("TIS303", "this is not allowed in a body", item.span)
        if isinstance(item, s.Block) and without(item.name, "region") is not None:
            self.parts.read_region(item)
            return
        if isinstance(item, s.Assign) and is_graded(item):
            self.graded.append(read_graded(item, self.graded, self.scope))
            return
        key = "made" if _is_made_of(item) else item.name.key
        if key == "interface" and not isinstance(item, s.Assign) and item.clauses:
            self.parts.read_interface(item)
            return
        if is_placement(item):
            self.placements.append(item)
            return
        if key == "springs":
            self.parts.read_springs(item)
            return
        if key in GRADABLE and isinstance(item, s.Assign):
            refuse_even(item, "body", self.findings)
        if key in self.once:
            self.findings.refuse_second(f'"{key}"', item.span, self.once[key])
        self.once[key] = item.span
        if key == "mesh":
            self._mesh(item)
        elif key == "made":
            self.may_be_elements = True
            self.elements = read_made_of(item, self.tissues, self.scope)
            self.may_be_elements = self.elements is not None
        elif key == "tissue":
            self.tissue = read_tissue(item, self.tissues, self.declarations, self.scope)
        elif key in ENTRIES and (key != PRESTRESS or isinstance(item, s.Sentence)):
            entry = ENTRIES[key]
            self.rest[entry.field] = schema.read_entry(entry, item, self.scope)
        else:
            told = ELSEWHERE.get(key) or schema.chosen(item, ENTRIES) or self._elsewhere(item)
            hint = told or unknown_entry(item, ENTRIES)
            self.findings.refuse_entry(item.name, "a body", hint=hint)

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
            hint = alternatives(kind.key, MESHES, what="meshes")
            if kind.quoted and "." in kind.quoted:
                written = f'imported {{ file "{kind.quoted}" in mm }}'
                hint = Hint(f"write: mesh is {written}", Edit(written))
            message = f'there is no mesh called "{kind.text}"'
            self.findings.reject("TIS305", message, kind.span, hint=hint)
        self.mesh_kind = kind.key
        items = item.items if isinstance(item, s.Block) else ()
        with self.findings.together():
            self.mesh_placement = read_placement(tuple(filter(is_placement, items)), self.scope)
        items = tuple(one for one in items if not is_placement(one))
        if kind.key == EXPLICIT:
            if items:
                self.findings.reject(
                    "TIS303",
                    "an explicit mesh is given by tables, not by entries",
                    items[0].span,
                    hint=f"table nodes of {self.name.text} in mm "
                    'with columns "id x y z" { … }',
                )
            return
        where = item.head if isinstance(item, s.Block) else item.span
        is_wrong = "tissue" in self.once and self.tissue is None  # and may be matter
        is_matter = has_matter(self._matter()) or ("made" not in self.once and is_wrong)
        may_be_elements = self.may_be_elements or is_matter
        is_lattice = MESHES[kind.key] is Lattice
        is_cubic = may_be_elements and is_lattice
        names, net = [_key(one) for one in items], "kind is sodium chloride"
        if is_lattice and not is_cubic and self.tissue is not None and "kind" not in names:
            self.findings.reject(
                "TIS304",
                f'mesh lattice needs "kind" for {self.tissue.name}, which describes springs',
                where,
                hint=Hint(
                    "for a solid of elements, use a tissue in pascals"
                    f"{_matter_named(self.tissue.name)}; for a net: {net}",
                    *schema.missing(net, where).edits,
                ),
            )
        self.mesh, self.mesh_places = schema.build(
            MESHES[kind.key], items, self.scope, what=f"mesh {kind.key}", where=where,
            usual={"kind": CUBIC} if is_cubic else None,
        )  # fmt: skip

    def _is_solid_matter(self) -> bool:
        """Return whether the body is a solid or a wall with a tissue in pascals.

        Lines of a file are bars, if a section is written.
        """
        is_bars = isinstance(self.mesh, Imported) and "section" in self.once
        return can_be_elements(self.mesh) and not is_bars and has_matter(self._matter())

    def _matter(self) -> list[tuple[Tissue, Span]]:
        """Return the tissues of the body and its regions, and where each is written."""
        parts = [(self.tissue, self.once.get("tissue", self.block.head))]
        parts += [(region.tissue, region.span) for region in self.parts.regions]
        return [(tissue, span) for tissue, span in parts if tissue is not None]

    def _refuse_of_elements(self, shell: Span | None) -> None:
        """Report entries that a body of springs does not have.

        Args:
            shell: The entry that requires elastic bending.
        """
        if shell is not None:
            self.findings.add(
                "TIS304",
                f"elastic bending of {self.name.text} needs a Young's modulus",
                shell,
                hint="write a Young's modulus in its tissue and a thickness in the body, "
                "or bending = 20 %",
            )
        self._refuse_faces()
        if SECOND_FIBRES in self.once:
            self.findings.add(
                "TIS306",
                "only a body of elements can have a second family of fibres",
                self.once[SECOND_FIBRES],
                hint="write made of elements, or remove second fibres",
            )
        if PRESTRESS in self.rest:
            place = self.once[PRESTRESS]
            self.findings.add(
                "TIS306",
                "only a body of elements has a direction of prestress",
                place,
                hint=leaving_out(
                    "remove it: each spring is prestressed along its own direction", place
                ),
            )

    def _refuse_faces(self) -> None:
        """Report what needs elements with faces that come apart in a body without such.

        This is ``rupture by faces``, and interfaces with a toughness.
        """
        if self.rest.get("rupture") == "by faces":
            place = self.once["rupture"]
            self.findings.add(
                "TIS306",
                "only solids of elements tear by faces",
                place,
                hint=Hint("write rupture is allowed", Edit("rupture is allowed", place)),
            )
        for one in self.parts.interfaces:
            self.findings.add(
                "TIS306",
                "only regions of solids of elements come apart at an interface",
                one.span,
                hint="remove the toughness, or use a solid with a tissue in pascals",
            )

    def _refuse_springs(
        self, made: MadeOfElements, bending: Bending | None, shell: Span | None
    ) -> Span | None:
        """Report entries for springs in a body of elements; return one that needs a shell."""
        nets = [one for one in self._matter() if not has_matter([one])]
        if nets:
            (tissue, place) = nets[0]
            self.findings.reject(
                "TIS304",
                f"elements need a Young's modulus, but {tissue.name} describes springs",
                made.span if made.is_written else place,
                hint=f"use a tissue in pascals{_matter_named(tissue.name)}, or describe all "
                f"tissues of {self.name.text} by spring constants",
            )
        if self.mesh is not None or self.mesh_kind == EXPLICIT:
            head = self.once["mesh"]
            refuse_mesh(self.mesh, head, self.mesh_places, made, self.findings)
        wall = is_wall(self.mesh)
        if wall:
            self._refuse_faces()
        elif self.parts.interfaces and self.rest.get("rupture") in ("allowed", "by toughness"):
            place = self.once["rupture"]
            self.findings.add(
                "TIS306",
                "elements beside an interface with a toughness cannot break as a whole",
                place,
                hint=Hint("write rupture by faces", Edit("rupture by faces", place)),
                notes=(Note("the interface", self.parts.interfaces[0].span),),
            )
        refuse_entries(self.once, made, self.findings, wall=wall)
        if made.is_quadratic:
            known = self.rest.get("rupture")
            breaks = self.once["rupture"] if known and known != "by faces" else None
            refuse_quadratic(made, breaks, self.findings, wall=wall)
        if wall and bending is not None:
            refuse("bending by springs", bending.span, made, self.findings)
        for part in self.parts.spring_parts:
            what = f"a tissue for {part.name}"
            refuse(what, part.span, made, self.findings, is_block=True)
        return made.span if wall and "bending" not in self.once else shell

    def _tables(self) -> Tables | None:
        tables: dict[str, WrittenTable | None] = {}
        # Of the nearest body that has a table of a kind.
        for name in names_like(self.name, self.declarations, self.findings):
            tables = {**self.all_tables.get(name.key, {}), **tables}
        if None in tables.values():
            self.findings.stop()
        if self.mesh_kind == EXPLICIT:
            return explicit_tables(self.name, self.block.head, tables, self.laws, self.findings)
        if tables:
            edits = (
                Edit("mesh is explicit", self.once[key]) for key in self.once if key == "mesh"
            )
            self.findings.reject(
                "TIS306",
                f"body {self.name.text} has both a mesh and a table",
                next(one for one in tables.values() if one is not None).rows.name.span,
                hint=Hint("write mesh is explicit", *edits),
            )
        return None


def _key(item: s.Item) -> str:
    """Return the key of the name of an entry; "" of what has none."""
    return item.name.key if isinstance(item, s.Assign | s.Sentence) else ""


def _matter_named(name: str) -> str:
    """Return how to use the preset of matter with the name of a tissue, or an empty text."""
    from tissuec.core.resources import library  # where a tissue is wrong

    preset = f"matter/{name.replace(' ', '_')}"
    return f' (use "{preset}")' if (library() / f"{preset}.tis").exists() else ""
