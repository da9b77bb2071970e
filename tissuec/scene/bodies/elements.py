"""Bodies made of finite elements: which ones are, and entries that only springs have.

A solid or a wall whose tissues have a Young's modulus is made of elements; any other body is
made of springs.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Annotated

from tissuec.core.errors import Note
from tissuec.core.hints import Edit, Hint, leaving_out, proposal, removal
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Elemental, Generator, is_wall
from tissuec.meshes.generators.imported import TETRAHEDRA, Imported
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.scene.model import MadeOfElements, Tissue
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause

Part = tuple[Tissue, Span]  # a tissue, and where it is written that a body consists of it
ELEMENTS, QUADRATIC, SPRINGS = "elements", "quadratic elements", "springs"


class MadeWords(VerbSentence, frozen=True):
    """What a body consists of."""

    of: Annotated[
        str,
        ChoiceClause(
            "of",
            {
                ELEMENTS: "Finite elements.",
                QUADRATIC: "Hexahedra with 27 nodes instead of eight.",
                SPRINGS: "Springs between nodes.",
            },
            what="constituent",
        ),
    ]


_KIND = SentenceKind((MadeWords,), wrong='a body is "made of" elements or springs')
MADE_ENTRY = written(
    "made", "whether a solid consists of finite elements or of springs", *_KIND.forms
)
CUBIC = "sodium chloride"  # the kind of lattice whose nodes are the corners of its cells
#: Entries of bodies that are for springs, and for walls and bars.
_OF_SPRINGS, _OF_WALLS = ("bending", "interface"), ("section", "thickness")
#: Entries of meshes of walls that say where springs are.
_WHERE_SPRINGS_ARE = ("diagonals", "interior", "second neighbours")


def read_made_of(
    item: s.Assign | s.Sentence | s.Block, tissues: Collection[str], scope: Scope
) -> MadeOfElements | None:
    """Return the written choice of ``made of elements``; None for ``made of springs``.

    Args:
        item: The entry, whose name begins with "made".
        tissues: Names of tissues, which may be meant.
        scope: Of the scene.
    """
    reader = SentenceReader("made", _KIND, item, scope)
    if not isinstance(item, s.Sentence) or item.name.key != "made" or not item.clauses:
        reader.reject_form()
    word = item.clauses[0].value
    if isinstance(word, s.Name) and word.key in tissues:
        meant = f"tissue is {word.text}"
        scope.findings.reject(
            "TIS305", f'a body cannot be made of "{word.text}"', word.span,
            hint=Hint(f"write {meant}", Edit(meant, item.span)),
        )  # fmt: skip
    said: MadeWords = reader.get()
    if said.of == SPRINGS:
        return None
    return MadeOfElements(item.span, is_written=True, is_quadratic=said.of == QUADRATIC)


def as_matter(mesh: Generator | None, parts: Sequence[Part]) -> MadeOfElements | None:
    """Return the choice of elements for a body that does not write one, or None.

    Args:
        mesh: Of the body; None if it is explicit or could not be read.
        parts: Tissues of the body and its regions, each with the place where it is written.
    """
    matter = [one for one in parts if has_matter([one])]
    if not (can_be_elements(mesh) and matter):
        return None
    return MadeOfElements(matter[0][1], is_written=False)


def can_be_elements(mesh: Generator | None) -> bool:
    """Return whether a mesh is that of a solid or of a wall; see ``as_matter``."""
    return isinstance(mesh, Elemental) or is_wall(mesh)


def has_matter(parts: Sequence[Part]) -> bool:
    """Return whether any tissue has a Young's modulus; see ``as_matter``."""
    return any(YOUNGS_MODULUS in tissue.given for tissue, _ in parts)


def note_of(made: MadeOfElements) -> Note:
    """Return a note on the entry that requires elements."""
    if made.is_written:
        return Note("required by this entry", made.span)
    return Note("a tissue with a Young's modulus is made of elements", made.span)


def refuse_springs(name: str, parts: Sequence[Part], place: Span, findings: Findings) -> None:
    """Report a solid or a wall in pascals that is written to be made of springs.

    Args:
        name: Of the body.
        parts: As for ``as_matter``.
        place: Where it is written what the body is made of.
        findings: Takes diagnostics.
    """
    tissue = next(tissue for tissue, _ in parts if YOUNGS_MODULUS in tissue.given)
    findings.add(
        "TIS306",
        f"{name} cannot be made of springs: a solid or a wall in pascals consists of elements",
        place,
        hint=leaving_out(
            f"remove it, or write a spring constant in {tissue.name} instead of a Young's "
            "modulus",
            place,
        ),
        notes=(Note("its tissue is in pascals", tissue.given[YOUNGS_MODULUS].span),),
    )


def refuse(
    what: str, place: Span, made: MadeOfElements, findings: Findings, *, is_block: bool = False
) -> None:
    """Report something that elements do not have.

    Args:
        what: In words.
        place: Where it is written.
        made: Why the body is made of elements.
        is_block: Whether it is the head of a block.
    """
    removing = () if is_block else (removal(place),)
    findings.add(
        "TIS306",
        f"{what} is not available for elements",
        place,
        hint=Hint("remove it", *removing),
        notes=(note_of(made),),
    )


def refuse_entries(
    places: Mapping[str, Span], made: MadeOfElements, findings: Findings, *, wall: bool
) -> None:
    """Report entries of a body of elements that are for springs, and for walls of a solid.

    Args:
        places: Where its entries are written, by name.
        made: Why the body is made of elements.
        wall: Whether it is a wall, of which ``bending`` says whether it resists it.
    """
    for name in _OF_SPRINGS:
        if name in places and not (wall and name == "bending"):
            refuse(f'"{name}"', places[name], made, findings)
    for name in _OF_WALLS:
        if name in places and not (wall and name == "thickness"):
            findings.add(
                "TIS306",
                f'a body of elements cannot have "{name}"',
                places[name],
                hint=leaving_out(
                    f"remove {name}: the mesh already defines its dimensions", places[name]
                ),
            )


def refuse_quadratic(
    made: MadeOfElements, breaks: Span | None, findings: Findings, *, wall: bool
) -> None:
    """Report what quadratic elements cannot be, or do not have.

    Args:
        made: Why the body is made of them.
        breaks: Where it is written that they may break; None if it is not.
        wall: Whether the body is a wall.
    """
    linear = Hint(f"write made of {ELEMENTS}", Edit(f"made of {ELEMENTS}", made.span))
    if wall:
        message = "only solids can consist of quadratic elements; a wall consists of triangles"
        findings.add("TIS306", message, made.span, hint=linear)
    elif breaks is not None:
        message = "quadratic elements cannot break"
        findings.add("TIS306", message, breaks, hint=linear, notes=(note_of(made),))


def refuse_mesh(
    mesh: Generator | None,
    head: Span,
    places: Mapping[str, Span],
    made: MadeOfElements,
    to: Findings,
) -> None:
    """Report a mesh that elements cannot divide, and its entries that are for springs.

    Args:
        mesh: Of the body; None if it is explicit.
        head: Head of the mesh.
        places: Where its entries are written, by name.
        made: Why the body is made of elements.
        to: Takes diagnostics.
    """
    if not can_be_elements(mesh):
        to.add(
            "TIS306",
            "this mesh cannot consist of elements because it is neither a solid nor a wall",
            head,
            hint=Hint(
                "remove made of elements, or use a lattice, a sheet, a tube, a sphere or an "
                "imported mesh",
                removal(made.span),
            ),
            notes=(note_of(made),),
        )
        return
    if isinstance(mesh, Lattice) and "kind" in places and mesh.kind != CUBIC:
        to.add(
            "TIS306",
            f"{mesh.kind} says where springs are, but elements are the cubic cells",
            places["kind"],
            hint=proposal(f"kind is {CUBIC}"),
            notes=(note_of(made),),
        )
    if isinstance(mesh, Imported) and mesh.filling in CRYSTALS:
        to.add(
            "TIS306",
            f"a filling of {mesh.filling} consists of springs",
            places["filling"],
            hint=proposal(f"filling is {TETRAHEDRA}"),
            notes=(note_of(made),),
        )
    for name in ("reach", "stiffness", *_WHERE_SPRINGS_ARE):
        if name in places and getattr(mesh, name.replace(" ", "_"), "") not in ("none", "no"):
            refuse(f'"{name}" of a mesh', places[name], made, to)
