"""Tissues by name: ``tissue is NAME`` in bodies, their parts, and joints."""

from collections.abc import Mapping
from typing import Annotated

from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.scene.model import Tissue
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import Entries, Entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import TISSUE, NameClause


class TissueNamed(VerbSentence, frozen=True):
    """The name of a tissue."""

    tissue: Annotated[s.Name, NameClause("is", places=(TISSUE,))]


_KIND = SentenceKind((TissueNamed,), examples=("tissue is fallopian tube",))


def tissue_entry(about: str) -> Entry:
    """The entry ``tissue is NAME`` of a block.

    Args:
        about: What is made of it, in one sentence.
    """
    return written("tissue", about, TissueNamed)


def reading_tissues(
    entries: Entries, tissues: Mapping[str, Tissue], declarations: Declarations
) -> dict[str, Entry]:
    """Return entries of which ``tissue`` is read as one of some tissues.

    Args:
        entries: Of a block.
        tissues: By name.
        declarations: Of the scene.
    """

    def read(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> Tissue:
        return read_tissue(item, tissues, declarations, scope)

    return {**entries, "tissue": replace(entries["tissue"], reads=read)}


def read_tissue(
    item: s.Assign | s.Sentence | s.Block,
    tissues: Mapping[str, Tissue],
    declarations: Declarations,
    scope: Scope,
) -> Tissue:
    """Return the tissue that ``tissue is …`` names."""
    said: TissueNamed = SentenceReader("tissue", _KIND, item, scope).get()
    name = said.tissue
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
