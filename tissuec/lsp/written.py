"""Words that are not allowed at a place because of other parts of the text."""

from collections.abc import Collection, Iterable

from tissuec.core.names import key_of
from tissuec.lang.tree import Statement
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.laws.solid import SOLID_LAWS
from tissuec.lsp import study
from tissuec.lsp.phrases import Phrase
from tissuec.lsp.terms import BlockKind
from tissuec.lsp.views import View
from tissuec.lsp.vocabulary import numbers_of_forces
from tissuec.scene.learning.entries import ADJUSTED
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.parts import entries_in, parts
from tissuec.scene.tissues.laws import BY_ENTRY, LawKind


def left_out_of(view: View, phrase: Phrase) -> Collection[str]:
    """Return keys of words that are not allowed in the place of a phrase.

    These are entries that the block has once and that another statement writes, properties of
    a tissue without a vocabulary, what to adjust of laws and forces that a text has not, and
    entries that cannot vary because no block has them.
    """
    statement, block = phrase.statement, phrase.block
    if block.kind == "learn" and statement.words[:1] == ["adjust"]:
        return _adjusted_elsewhere(view)
    if phrase.expected.terms == (study.varied(),):
        return _entries_elsewhere(view)
    if any(part.start < phrase.start for part in statement.parts):
        return ()
    beside = statement.outer.items if statement.outer else view.structure.statements
    known = [*_once(block), *(_properties(view) if block.kind == "tissue" else ())]
    written = (key_of(" ".join(one.words)) for one in beside if one.start != statement.start)
    # The longest, for some entries begin with another one.
    begun = {max(_beginning(text, known), key=len, default="") for text in written}
    if block.kind in ("tissue", "law"):
        begun |= {name for name, law in BY_ENTRY.items() if begun & _names_of(law)}
    if block.kind == "tissue" and "described" not in begun and not _is_like(statement):
        begun |= set(_properties(view))
    return begun


def _names_of(law: LawKind) -> set[str]:
    """Return the entries that write a law, of which a tissue has one."""
    return {law.word, *(form.name for form in law.forms)}


def _is_like(statement: Statement) -> bool:
    """Return whether the tissue around a statement inherits from another one."""
    return statement.outer is not None and any(
        part.text == "like" for part in statement.outer.parts
    )


def _beginning(text: str, known: Iterable[str]) -> Iterable[str]:
    return (key for key in known if f"{text} ".startswith(f"{key} "))


def _once(block: BlockKind) -> Collection[str]:
    """Return the entries that a block, or the text outside of blocks, may have only once."""
    if not block.kind:
        return parts("single")
    return [name for name, entry in entries_in(*block).items() if not entry.repeats]


def _properties(view: View) -> list[str]:
    return [symbol.key for symbol in view.of_kind("property")]


def _entries_elsewhere(view: View) -> Collection[str]:
    """Return entries that could vary in other scenes, but not in this one."""
    if view.words is None:
        return ()
    named = {symbol.key for symbol in view.of_kind("param", "property")}
    return study.varied().keys() - study.varying(view.words) - named


def _adjusted_elsewhere(view: View) -> Collection[str]:
    """Return constants of laws that no tissue of the text has, and numbers of forces."""
    if view.words is None or not view.words.tissues:
        return ()
    laws = [
        law for tissue in view.words.tissues.values() for law in tissue.written_laws.values()
    ]
    own = {name for law in laws if law.law is not None for name in entries_of(type(law.law))}
    families = (SPRING_LAWS, VISCOSITY_LAWS, SOLID_LAWS)
    every = {name for family in families for law in family.values() for name in entries_of(law)}
    of_forces = set(numbers_of_forces())
    if any(view.of_kind("force")):
        own |= of_forces
    return (every | of_forces) - own - set(ADJUSTED)
