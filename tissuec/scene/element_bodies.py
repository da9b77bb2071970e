"""Bodies made of finite elements: ``made of elements``, and entries that only springs have."""

from collections.abc import Collection, Mapping
from typing import NoReturn

from tissuec.core.errors import Note
from tissuec.core.hints import Edit, Hint, alternatives, leaving_out, proposal, removal
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Elemental, Generator
from tissuec.meshes.generators.imported import Imported
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.scene.findings import Findings

ELEMENTS, SPRINGS = "elements", "springs"
MADE_OF = (ELEMENTS, SPRINGS)
CUBIC = "sodium chloride"  # the kind of lattice whose nodes are the corners of its cells
#: Entries of bodies that are for springs, and for walls and bars.
_OF_SPRINGS, _OF_WALLS = ("bending", "interface"), ("section", "thickness")


def read_made_of(
    item: s.Assign | s.Sentence | s.Block, tissues: Collection[str], findings: Findings
) -> Span | None:
    """Return where ``made of elements`` is written; None for ``made of springs``.

    Args:
        item: The entry, whose name begins with "made".
        tissues: Names of tissues, which may be meant.
        findings: Takes diagnostics.
    """
    if not isinstance(item, s.Sentence) or item.name.key != "made" or item.phrase is not None:
        _wrong_form(item, findings)
    if [clause.word for clause in item.clauses] != ["of"]:
        _wrong_form(item, findings)
    word = item.clauses[0].value
    if isinstance(word, s.Name) and word.key in MADE_OF:
        return item.span if word.key == ELEMENTS else None
    text = word.span.text
    meant = f"tissue is {text}"
    findings.reject(
        "TIS305",
        f'a body cannot be made of "{text}"',
        word.span,
        hint=Hint(f"write {meant}", Edit(meant, item.span))
        if isinstance(word, s.Name) and word.key in tissues
        else alternatives(text.lower(), MADE_OF, what="choices"),
    )


def _wrong_form(item: s.Assign | s.Sentence | s.Block, findings: Findings) -> NoReturn:
    written = item.span.text.lower()
    known = [word for word in MADE_OF if word in written]
    hint = f"for example: made of {ELEMENTS}"
    findings.reject(
        "TIS312",
        'a body is "made of" elements or springs',
        item.span,
        hint=proposal(f"made of {known[0]}", item.span) if len(known) == 1 else hint,
    )


def refuse(
    what: str, place: Span, made: Span, findings: Findings, *, is_block: bool = False
) -> None:
    """Report something that elements do not have.

    Args:
        what: In words.
        place: Where it is written.
        made: Where the body is made of elements.
        findings: Takes diagnostics.
        is_block: Whether it is the head of a block.
    """
    of_springs = f"made of {SPRINGS}"
    removing = () if is_block else (removal(place),)
    findings.add(
        "TIS306",
        f"{what} is not available for elements",
        place,
        hint=Hint(f"remove it, or write {of_springs}", *removing, Edit(of_springs, made)),
        notes=(Note("required by this entry", made),),
    )


def refuse_entries(places: Mapping[str, Span], made: Span, findings: Findings) -> None:
    """Report entries of a body of elements that are for springs and walls.

    Args:
        places: Where its entries are written, by name.
        made: Where the body is made of elements.
        findings: Takes diagnostics.
    """
    for name in _OF_SPRINGS:
        if name in places:
            refuse(f'"{name}"', places[name], made, findings)
    for name in _OF_WALLS:
        if name in places:
            findings.add(
                "TIS306",
                f'a body of elements cannot have "{name}"',
                places[name],
                hint=leaving_out(
                    f"remove {name}: the mesh already defines its dimensions", places[name]
                ),
            )


def refuse_mesh(
    mesh: Generator | None, head: Span, places: Mapping[str, Span], made: Span, to: Findings
) -> None:
    """Report a mesh that elements cannot divide, and its entries that are for springs.

    Args:
        mesh: Of the body; None if it is explicit.
        head: Head of the mesh.
        places: Where its entries are written, by name.
        made: Where the body is made of elements.
        to: Takes diagnostics.
    """
    if not isinstance(mesh, Elemental):
        to.add(
            "TIS306",
            "this mesh cannot consist of elements because it is not solid",
            head,
            hint=Hint(
                "remove made of elements, or use a lattice or an imported solid", removal(made)
            ),
            notes=(Note("required by this entry", made),),
        )
        return
    if isinstance(mesh, Lattice) and "kind" in places and mesh.kind != CUBIC:
        to.add(
            "TIS306",
            f"{mesh.kind} says where springs are, but elements are the cubic cells",
            places["kind"],
            hint=Hint(f"write kind is {CUBIC}", Edit(f"kind is {CUBIC}")),
            notes=(Note("required by this entry", made),),
        )
    if isinstance(mesh, Imported) and mesh.filling in CRYSTALS:
        to.add(
            "TIS306",
            f"a filling of {mesh.filling} consists of springs",
            places["filling"],
            hint=Hint("write filling is tetrahedra", Edit("filling is tetrahedra")),
            notes=(Note("required by this entry", made),),
        )
    for name in ("reach", "stiffness"):
        if name in places:
            refuse(f'"{name}" of a mesh', places[name], made, to)
