"""The forms of sentences, taken apart: what each joining word of an order or entry holds."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

from tissuec.core.fields import FileIn, FromTo, Named, OneOf
from tissuec.core.units import NUMBER, show
from tissuec.lang.words import DECLARING_WORDS
from tissuec.lsp import study
from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import Expected, number
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import CHOICE, Term, Terms, by_label, plain
from tissuec.scene.reading.entries import Entry, Written
from tissuec.scene.reading.parts import PARTS, blocks, entries_in
from tissuec.scene.reading.parts import forms_of as part_forms
from tissuec.script import forms as script_forms
from tissuec.script.forms import VerbForm, form_of, texts_of_sentences
from tissuec.script.parts import (
    OWN,
    ChoiceClause,
    ColumnsClause,
    ConcludedClause,
    ConditionClause,
    FilesClause,
    FlagPart,
    MeasureClause,
    NameClause,
    NumberClause,
    Part,
    Placeholder,
    ProfileClause,
    SubjectPart,
    TextClause,
    ToolClause,
    UnionClause,
    UnitClause,
    ValueClause,
)
from tissuec.script.verbs import VERBS


class ClauseForm(NamedTuple):
    """One place of a form.

    Attributes:
        word: The joining word; empty directly after the first words.
        expected: What can be written there.
        needs: Words that are written before.
    """

    word: str
    expected: Expected
    needs: tuple[str, ...] = ()


class SentenceForm(NamedTuple):
    """One form of a sentence.

    Attributes:
        literal: Words after its first ones, such as "spring constant".
        clauses: What is after these, and behind joining words.
        starts: Words of which one is written after "=" in this form only.
    """

    literal: str
    clauses: tuple[ClauseForm, ...]
    starts: tuple[str, ...] = ()


def fitting(prefix: Prefix) -> list[SentenceForm]:
    """Return the forms that the sentence of a prefix can have."""
    kind = prefix.block.kind
    forms = forms_of(kind, prefix.head if kind in ("", "script") else prefix.subject)
    of_words = [one for one in forms if one.literal and one.literal == prefix.object]
    # The last word of an object may be a joining word that is not finished.
    before = prefix.object.rpartition(" ")[0]
    found = of_words or [one for one in forms if not one.literal or one.literal == before]
    if prefix.has("="):
        found = [one for one in found if any(part.word == "=" for part in one.clauses)]
    texts = prefix.texts
    first = texts[texts.index("=") + 1 :][:1] if "=" in texts else []
    if "=" in texts and not first:
        found = [one for one in found if one.starts != ("[",)] or found
    if first:
        begun = [one for one in found if first[0] in one.starts]
        found = begun or [one for one in found if not one.starts]
    return found


@cache
def forms_of(block: str, entry: str) -> tuple[SentenceForm, ...]:
    """Return the forms of a part, entry or order, taken apart.

    Args:
        block: Kind of the block that it stands in.
        entry: The part, entry or verb.
    """
    if block == "script" and entry in VERBS:
        return tuple(_declared(form, entry) for form in script_forms.forms_of(entry))
    known = entries_in(block).get(entry) if block else PARTS.get(entry)
    if known is None:
        kinds, entry = blocks()[block].free if block in blocks() else (), ""
    else:
        kinds = known.sentences
    forms = tuple(_declared(form_of(kind), entry, is_ordered=True) for kind in kinds)
    if isinstance(known, Entry):
        return (*_of_kind(known), *forms)
    if known is not None and known.sort == "named":
        return forms or (SentenceForm("", (ClauseForm("", Expected(declares=entry)),)),)
    return forms


def texts_of(block: str, entry: str) -> tuple[str, ...]:
    """Return the forms of a part, entry or order as the reference has them.

    Args:
        block: Kind of the block that it stands in.
        entry: The part, entry or verb.
    """
    if block == "script" and entry in VERBS:
        return script_forms.texts_of(entry, every=True)
    if not block:
        return part_forms(entry) if entry in PARTS else ()
    found = entries_in(block).get(entry)
    if found is not None:
        return found.forms
    return texts_of_sentences("", blocks()[block].free) if block in blocks() else ()


def _of_kind(entry: Entry) -> Iterator[SentenceForm]:
    """Yield the forms of an entry that its kind alone says."""
    plain_number = number()._replace(dimension=entry.dimension)
    match entry.kind:
        case Written() | Named():
            return
        case OneOf():
            clauses = [("is", Expected())]
        case FromTo(may_bend=may_bend):
            clauses = [("from", plain_number), ("to", plain_number)]
            if may_bend:
                yield SentenceForm("", (ClauseForm("through", plain_number),))
        case FileIn():
            unit = Expected(unit=True, dimension=entry.dimension)
            clauses = [("", Expected(files=entry.name)), ("in", unit)]
        case _:
            clauses = [("=", plain_number)]
    first = clauses[0][0]
    yield SentenceForm(
        "", tuple(ClauseForm(w, held, () if w == first else (first,)) for w, held in clauses)
    )


# --- declared forms ---------------------------------------------------------------------------


def _declared(form: VerbForm, entry: str, *, is_ordered: bool = False) -> SentenceForm:
    """Return a form with what its declaration expects.

    Args:
        entry: The first words of its sentences.
        is_ordered: Whether its clauses are offered in the order of its parts.
    """
    is_literal = form.cases is None or not form.cases.word
    clauses = (
        [ClauseForm("", Expected(names=_names(form.subjects)))]
        if form.subjects
        else list[ClauseForm]()
    )
    needed = list[str]()
    starts: tuple[str, ...] = ()
    required = [part for name, part in form.parts.items() if name not in form.optional]
    for word, part, before in form.clauses:
        needs = (*needed, before) if before else tuple(needed)
        if isinstance(part, str):
            literal = Expected((plain(CHOICE, [part]),))
            same = [one for one in clauses if one.word == word]  # as what is along a direction
            if same:
                both = together((same[0].expected, literal))
                clauses[clauses.index(same[0])] = same[0]._replace(expected=both)
            else:
                clauses.append(ClauseForm(word, literal, needs))
            continue
        clauses.append(ClauseForm(word, _expected(form, word, part, entry), needs))
        match part:
            case MeasureClause(functions=functions, others=others):
                measures = (name.split(" ")[0] for name in v.fitted())
                starts = tuple(measures) if others else functions
            case ChoiceClause(word="=", words=words):
                starts = tuple(words)
            case UnionClause(word="="):
                starts = ("[",)
            case _:
                pass
        if is_ordered and part in required and (word or entry not in ("", *DECLARING_WORDS)):
            needed.append(word)
    return SentenceForm(form.literal if is_literal else "", tuple(clauses), starts)


def _expected(form: VerbForm, word: str, part: Part, entry: str) -> Expected:
    """Return the completions after a joining word."""
    known = getattr(part, "dimension", None)
    dimension = None if known is None or known is OWN else form.dimension_of(word)
    match part:
        case SubjectPart() | ToolClause():
            return Expected(names=_names([part]))
        case NameClause(places=places):
            return together(map(_place, places))
        case ValueClause(places=places):
            found = together(map(_place, places))
            several = number(*found.terms)
            names = (*found.names, *several.names)
            return several._replace(names=names, dimension=dimension)
        case MeasureClause(word=""):  # of which the first words are a part
            return Expected()
        case MeasureClause(functions=functions, others=others):
            if functions:
                return Expected((study.OVER_TIME_TERMS,))
            return number(v.fitted() if others else v.measures())
        case FilesClause(is_new=is_new):
            return Expected(files="" if is_new else entry)
        case ColumnsClause():
            return Expected((v.COLUMN,)) if word else Expected()
        case UnitClause():
            return Expected(unit=True, dimension=dimension)
        case UnionClause(places=places):
            return together(map(_place, places))
        case ConditionClause() | ConcludedClause() | TextClause():
            return Expected()
        case ProfileClause():
            return Expected((v.profiles(),))
        case FlagPart(text=text, about=about):
            return Expected((plain(CHOICE, [text.removeprefix(f"{word} ")], about),))
        case ChoiceClause(words=words):
            return Expected((_terms(words),))
        case NumberClause(words=words):
            terms = _terms(
                {name: show(one, dimension or NUMBER) for name, one in words.items()}
            )
            return (number(terms) if terms else number())._replace(dimension=dimension)
        case _:
            return number()._replace(dimension=dimension)


def _place(place: Placeholder) -> Expected:
    """Return the completions for a placeholder of a declared form."""
    known = {
        "ADJUSTED": v.adjusted, "LISTED": v.adjusted_in_lists, "VARIED": study.varied,
        "FIELD": v.frame_fields, "SOURCE": lambda: v.SOURCE_TERMS,
        "HEDGE": lambda: v.HEDGE_TERMS, "SHAPE": lambda: v.SHAPE_TERMS,
        "PLACE": v.coordinates,
    }  # fmt: skip
    own = known[place.text]() if place.text in known else dict[str, Term]()
    if place.new == "quantity":
        own = v.QUANTITY_TERMS
    terms = {**plain(CHOICE, place.words, place.about), **own}
    return Expected((terms,) if terms else (), place.names, declares=place.new)


def _names(parts: Iterable[SubjectPart | ToolClause]) -> tuple[str, ...]:
    """Return the kinds of names that parts take."""
    found = dict[str, None]()
    for part in parts:
        if isinstance(part, ToolClause):
            found[part.kind] = None
        else:
            found |= dict.fromkeys(name for place in part.places for name in place.names)
    return tuple(found)


def _terms(described: Mapping[str, str]) -> Terms:
    return by_label(Term(word, CHOICE, about) for word, about in described.items())


def first_places(forms: Iterable[SentenceForm]) -> Iterator[Expected]:
    """Yield what can be written directly after the first words of some forms."""
    yield from (one.expected for form in forms for one in form.clauses if not one.word)


def together(every: Iterable[Expected]) -> Expected:
    """Return the union of several sets of completions."""
    found = list(every)
    terms = dict[str, Term]()
    for known in (known for one in found for known in one.terms):
        terms = {**known, **terms}
    dimensions = [one.dimension for one in found if one.dimension is not None]
    return Expected(
        (terms,) if terms else (),
        tuple(dict.fromkeys(name for one in found for name in one.names)),
        declares=next((one.declares for one in found if one.declares), ""),
        files=next((one.files for one in found if one.files), ""),
        unit=any(one.unit for one in found),
        dimension=dimensions[0] if dimensions else None,
    )
