"""What is allowed in the sentences of a study block."""

from collections.abc import Iterator
from functools import cache

from tissuec.compiler.study.expectations import OVER_RUNS
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.words import STEPS
from tissuec.lsp.expected import NUMBERS, Expected, measured, number
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import CHOICE, MEASURE, BlockKind, Term, Terms, by_label, plain
from tissuec.lsp.vocabulary import entries
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.graded import GRADED_ENTRIES
from tissuec.scene.reading.parts import blocks, entries_in, settable
from tissuec.scene.reading.spellings import AGGREGATES, form_over_time
from tissuec.scene.study.entries import DISTRIBUTIONS

#: Blocks inside of others whose entries can vary as if they were of those.
_INNER = {"body": "mesh"}

DISTRIBUTION_TERMS = by_label(
    Term(name, MEASURE, "A distribution, for random designs.", form, "(")
    for name, form in DISTRIBUTIONS.items()
)
OVER_RUNS_TERMS = by_label(
    Term(name, MEASURE, "Over all runs that have a value.", form, "(")
    for name, form in OVER_RUNS.items()
)
AGGREGATE_TERMS = by_label(
    Term(name, MEASURE, f"Over time: {about}.", form_over_time(name), "(")
    for name, about in AGGREGATES.items()
)
STEPS_TERMS = plain(CHOICE, [STEPS], "So many values, both ends among them.")
#: Functions of measures over time, and the time of an event.
OVER_TIME_TERMS: Terms = {
    **AGGREGATE_TERMS,
    "time": Term("time", MEASURE, "The time of the first event.", "time of rupture", " of "),
}


@cache
def _owners() -> dict[str, str]:
    """Return blocks whose entries can vary, and the kind of block that is named after them."""
    known = (
        (one, kind) for kind in settable("named") for one in (kind, _INNER.get(kind, kind))
    )
    return dict(known)


def _chooses(kind: str, entry: str) -> bool:
    """Return whether an entry chooses which others there are, so that no others suit it."""
    return entry in (blocks()[kind].chooser, _INNER.get(kind))


@cache
def _own(block: BlockKind) -> Terms:
    """Return the entries of a block, without formulas of the place, which do not vary."""
    known = entries_in(*block)
    return {
        name: term
        for name, term in entries(block).items()
        if name not in GRADED_ENTRIES or known[name] is not GRADED_ENTRIES[name]
    }


@cache
def varied() -> Terms:
    """Return the entries that can vary: with the block that has them, or alone."""
    found: dict[str, Term] = {}
    unnamed = settable("single")
    for kind in (*_owners(), *unnamed):
        behind = " = " if kind in unnamed else " of "
        for name, term in _own(BlockKind(kind)).items():
            if term.behind in (" = ", " is ") and not _chooses(kind, name):
                found.setdefault(name, replace(term, behind=behind, form=f"{name}{behind}…"))
    return found


def varying(program: ResolvedProgram) -> set[str]:
    """Return the entries of ``varied`` that blocks of a scene have, or could have."""
    declarations, found = program.declarations, set[str]()
    for tissue in program.tissues.values():
        found |= tissue.given.keys() | tissue.written_laws.keys()
    for kind in dict.fromkeys(_owners().values()):
        for declared in declarations.of(kind).values():
            if kind != "tissue" and isinstance(declared.item, s.Block):
                found.update(_entries_of(kind, declared.item))
    for kind in settable("single"):
        if kind in declarations.single:
            found |= _own(BlockKind(kind)).keys()
    return found


def _entries_of(kind: str, block: s.Block) -> Iterator[str]:
    """Yield the entries of a block, and of the mesh inside it, for each of its choices."""
    chosen = {
        item.name.key: item.phrase.words[0].key
        for item in block.items
        if isinstance(item, s.Sentence | s.Block) and item.phrase is not None
    }
    known = _own(BlockKind(kind, chosen.get("kind", "")))
    yield from (name for name in known if not _chooses(kind, name))
    if "mesh" in chosen:
        yield from _own(BlockKind("mesh", chosen["mesh"]))


def of_study(prefix: Prefix) -> Expected | None:
    """Return the completions in a sentence of a study; None if they follow from its form."""
    if prefix.head == "expect":
        return number(OVER_RUNS_TERMS)._replace(names=("column", *NUMBERS))
    if prefix.call in AGGREGATES:
        return measured()
    if prefix.subject == "vary" and (prefix.has("=") or prefix.clause == "of"):
        return _varied(prefix)
    return None


def _varied(prefix: Prefix) -> Expected:
    """Return the expectation of the owner of a varied entry, or of a value of it."""
    name = prefix.object
    if not prefix.has("="):
        return Expected(names=owners_of(name))
    term = entry_of(name)
    if term is not None and term.choices:
        return Expected((term.choices,))
    if name == "tissue":
        return Expected(names=("tissue",))
    if term is None and prefix.has("of"):
        return Expected(scale=name)
    return number(DISTRIBUTION_TERMS)


def owners_of(entry: str) -> tuple[str, ...]:
    """Return the kinds of blocks that have an entry; a property is one of tissues."""
    found = (owner for kind, owner in _owners().items() if entry in _own(BlockKind(kind)))
    of_one = any(entry in _own(BlockKind(kind)) for kind in settable("single"))
    return tuple(dict.fromkeys(found)) or (() if of_one else ("tissue",))


def entry_of(name: str) -> Term | None:
    """Return the entry of a name that can vary, None if there is none."""
    known = (_own(BlockKind(kind)) for kind in (*_owners(), *settable("single")))
    return next((terms[name] for terms in known if name in terms), None)
