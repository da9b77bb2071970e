"""Sentences of verbs: their base class, and the forms in which they can be written."""

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import product
from types import MappingProxyType
from typing import Any, ClassVar, cast, get_args

from msgspec import Struct

from tissuec.core.annotations import hints_of, refuse_field
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, Dimension, written_unit
from tissuec.script.parts import (
    AngleClause,
    CasePart,
    Cases,
    ChoiceClause,
    ClausePart,
    ColumnsClause,
    ConditionClause,
    DirectedClause,
    DirectionClause,
    EitherClause,
    FlagPart,
    LastingPart,
    LimitsClause,
    NameClause,
    NumberClause,
    Part,
    ProfileClause,
    RangeClause,
    Refusal,
    SubjectPart,
    ToolClause,
    UnionClause,
    UnitClause,
    ValueClause,
    VectorClause,
)
from tissuec.script.verbs import VERBS, Action, Order

#: What follows ``using`` or ``along`` for a path, and the joining words that can be there.
PATH, PATH_WORDS = 'table "path.csv" in mm', ("using", "along")


class VerbSentence(Struct, frozen=True):
    """What one sentence says; the annotations of the fields of a subclass are its parts.

    Attributes:
        span: The sentence.
        refused: Clauses that are not taken, although they might be expected, by joining word.
        instead: Sentences that take amounts of other dimensions, by dimension; {} stands for
            what follows the verb.
        literal: Words after the first ones by which a sentence of a block has this form.
    """

    literal: ClassVar[str] = ""
    refused: ClassVar[Mapping[str, Refusal]] = MappingProxyType({})
    instead: ClassVar[Mapping[Dimension, str]] = MappingProxyType({})

    span: Span

    def action(self, order: Order) -> Action:
        """Return the action of the sentence: this value itself, unless a subclass differs.

        Conditions that no declaration can express are checked here; ``order.reject`` reports
        violations.
        """
        return cast(Action, self)


class VerbForm(Struct, frozen=True, eq=False):
    """A class of sentences with its parts, in the order in which they are written.

    Attributes:
        kind: The class.
        parts: By field.
        optional: Fields that need not be written.
        cases: Where its words are chosen; None for a verb with one form.
        literal: The words; empty for a form without them.
    """

    kind: type[VerbSentence]
    parts: Mapping[str, Part]
    optional: frozenset[str]
    cases: Cases | None = None
    literal: str = ""

    @property
    def subjects(self) -> list[SubjectPart | ToolClause]:
        """The parts that may directly follow the verb or the words of the form."""
        parts = self.parts.values()
        return [p for p in parts if isinstance(p, SubjectPart | ToolClause) and not p.word]

    @property
    def clauses(self) -> Iterator[tuple[str, Part | str, str]]:
        """Joining words, what is after them, and the word that is needed before, if any."""
        if self.cases is not None and self.cases.word and self.literal:
            yield self.cases.word, self.literal, ""
        for part in self.parts.values():
            word = _word(part)
            match part:
                case EitherClause(clauses=clauses):
                    yield from ((one.word, one, "") for one in clauses)
                    continue
                case CasePart() | LastingPart():
                    continue
                case SubjectPart() | ToolClause() if not word:
                    continue
                case _:
                    yield word, part, ""
            match part:
                case DirectedClause(along=along, direction=example):
                    yield along, DirectionClause(along, example=example), ""
                case RangeClause(dimension=dimension):
                    yield "to", NumberClause("to", dimension), word
                case LimitsClause():
                    yield "and", ValueClause("and"), word
                case ProfileClause(path=path) if path:
                    yield "along", "table", ""
                case ColumnsClause(dimension=dimension):
                    yield "in", UnitClause("in", dimension=dimension), word
                case NameClause(owners=owners) if owners:
                    yield word, NameClause(word, places=owners), word
                case _:
                    pass

    def of_word(self, word: str) -> Part | None:
        """The part after a joining word; None without it."""
        return next((p for w, p, _ in self.clauses if w == word and isinstance(p, Part)), None)

    def unit_of(self, word: str) -> str:
        """Return the SI unit of the numbers after a joining word; empty for ratios."""
        is_angle = isinstance(self.of_word(word), AngleClause)
        return "rad" if is_angle else written_unit(self.dimension_of(word))

    def dimension_of(self, word: str) -> Dimension:
        """The dimension of the numbers after a joining word; that of a ratio without any."""
        match self.of_word(word):
            case NumberClause(dimension=Mapping() as of_case):
                return of_case.get(self.literal, NUMBER)
            case (
                VectorClause(dimension=dimension)
                | DirectedClause(dimension=dimension)
                | RangeClause(dimension=dimension)
                | NumberClause(dimension=Dimension() as dimension)
                | ValueClause(dimension=Dimension() as dimension)
                | UnitClause(dimension=Dimension() as dimension)
            ):
                return dimension
            case _:
                return NUMBER


@cache
def form_of(kind: type[VerbSentence]) -> VerbForm:
    """Return the form of a class of sentences."""
    hints = hints_of(kind)
    names, defaults = kind.__struct_fields__, kind.__struct_defaults__
    with_default = names[len(names) - len(defaults) :]
    parts, optional = dict[str, Part](), set[str]()
    for name in names:
        found = getattr(hints[name], "__metadata__", ())
        part = next((one for one in found if isinstance(one, Part)), None)
        if part is None:
            if name in with_default or name in VerbSentence.__struct_fields__:
                continue
            refuse_field(
                kind, name, hints[name],
                says="which part of the sentence it is, as tissuec.script.parts does",
                examples=f'{name}: Annotated[float, NumberClause("to", FORCE, what="force")]',
            )  # fmt: skip
        parts[name] = part
        may_miss = type(None) in get_args(hints[name].__origin__) or name in with_default
        if (
            may_miss
            or isinstance(part, FlagPart)
            or (isinstance(part, ProfileClause) and part.over)
        ):
            optional.add(name)
    return VerbForm(kind, parts, frozenset(optional), literal=kind.literal)


@cache
def forms_of(verb: str) -> tuple[VerbForm, ...]:
    """Return the forms of a verb."""
    member: Any = VERBS[verb]
    cases: Cases | None = getattr(member, "cases", None)
    if cases is None:
        return (form_of(member),)
    return tuple(
        VerbForm(kind, (form := form_of(kind)).parts, form.optional, cases, literal)
        for literal, kind in cases.forms.items()
    )


def synonyms(verb: type[object]) -> list[str]:
    """Return other words for what a verb does, which hints recognise."""
    return str(getattr(verb, "meant", "")).split()


# --- as text ------------------------------------------------------------------------------


@cache
def texts_of(verb: str, *, every: bool = False) -> tuple[str, ...]:
    """Return the forms of a verb as the reference has them: "move SET by VECTOR".

    Args:
        every: Whether to return all parts of each form with each choice, also of those that
            hints leave out.
    """
    lines, seen = dict[str, None](), set[str]()
    for form in forms_of(verb):
        shown = form.cases.shown if form.cases is not None else ()
        usual = _usual(form)
        if every:
            for chosen in _choices(form, usual):
                lines |= dict.fromkeys(_lines(verb, form, chosen, set()))
        elif not shown or form.literal in shown:
            lines |= dict.fromkeys(_lines(verb, form, usual, seen))
    return tuple(lines)


def text_of(verb: str, form: VerbForm) -> str:
    """Return the usual text of a form."""
    return _line(verb, form, _usual(form))


@cache
def texts_of_sentences(
    first: str, kinds: tuple[type[VerbSentence], ...], *, as_examples: bool = False
) -> tuple[str, ...]:
    """Return the texts of sentences that are no orders, each with all of its parts.

    Args:
        first: Their first words.
        kinds: Their classes.
        as_examples: Whether to write the examples of parts that have some.
    """
    lines = dict[str, None]()
    for form in map(form_of, kinds):
        texts = {name: text for name, part in form.parts.items() for text in _written(part)[:1]}
        if as_examples:
            texts |= {name: part.example for name, part in form.parts.items() if part.example}
        if form.parts.keys() - form.optional <= texts.keys():
            for chosen in _choices(form, texts):
                lines[_line(first, form, chosen)] = None
    return tuple(lines)


def brief_texts(first: str, kinds: tuple[type[VerbSentence], ...]) -> tuple[str, ...]:
    """Return texts of sentences with what each needs, and at most one part that it can have.

    Args:
        first, kinds: See ``texts_of_sentences``.
    """
    lines = dict[str, None]()
    for form in map(form_of, kinds):
        texts = {n: text for n, part in form.parts.items() for text in _written(part)[:1]}
        needed = {n: text for n, text in texts.items() if n not in form.optional}
        for name in [one for one in texts if one in form.optional] or [""]:
            more = {name: texts[name]} if name else {}
            lines[_line(first, form, {**needed, **more})] = None
    return tuple(lines)


def _choices(form: VerbForm, usual: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """Yield the usual text of each part, with each choice."""
    chosen = [name for name in usual if isinstance(form.parts[name], ChoiceClause)]
    for texts in product(*(_written(form.parts[name]) for name in chosen)):
        yield {**usual, **dict(zip(chosen, texts, strict=True))}


def _lines(
    verb: str, form: VerbForm, usual: Mapping[str, str], seen: set[str]
) -> Iterator[str]:
    """Yield a text of a form, and those in which one part is written otherwise.

    Args:
        usual: Texts of parts by field.
        seen: Clauses that were shown before and need not be again; the new ones are added.
    """
    yield _line(verb, form, usual)
    for name, part in form.parts.items():
        texts = _written(part)
        for text in (one for one in texts if one != usual.get(name)):
            rest = {n: t for n, t in usual.items() if not _excludes(form, name, n, text)}
            if text not in seen or isinstance(part, SubjectPart):
                yield _line(verb, form, {**rest, name: text})
            seen.add(text)
        if isinstance(part, SubjectPart) and name in form.optional & usual.keys():
            yield _line(verb, form, {n: t for n, t in usual.items() if n != name})


def _usual(form: VerbForm) -> dict[str, str]:
    """Return the usual text of each part that is needed, and of the subject."""
    profiles = (part for part in form.parts.values() if isinstance(part, ProfileClause))
    paths = [profile.path for profile in profiles if profile.path]
    texts = {
        name: _written(part)[0]
        for name, part in form.parts.items()
        if _written(part) and (name not in form.optional or _word(part) in paths)
    }
    subject = {
        name: _written(part)[0]
        for name, part in form.parts.items()
        if part in form.subjects and name in form.optional and texts
    }
    return {**subject, **texts}


def _excludes(form: VerbForm, name: str, other: str, text: str) -> bool:
    """Return whether one part with some text is in place of another part."""
    path = getattr(form.parts[name], "path", "")
    return text.endswith(PATH) and _word(form.parts[other]) == path


def _line(verb: str, form: VerbForm, texts: Mapping[str, str]) -> str:
    """Return a text of a form with some of its parts."""
    written = [name for name in form.parts if name in texts]
    subjects = [texts[name] for name in written if form.parts[name] in form.subjects]
    clauses = [texts[name] for name in written if form.parts[name] not in form.subjects]
    literal = [form.literal] if form.literal else []
    if form.cases is not None and form.cases.word and literal:
        return " ".join((verb, *subjects, form.cases.word, *literal, *clauses))
    return " ".join(filter(None, (verb, *literal, *subjects, *clauses)))


def _word(part: Part) -> str:
    return getattr(part, "word", "")


def _written(part: Part) -> list[str]:
    """Return how a part can be written, the usual way first; nothing if it is not written."""
    match part:
        case SubjectPart(word=word, places=places):
            return [f"{word} {place.text}".strip() for place in places]
        case ToolClause(word=word, entries=False):
            return [f"{word} {part.placeholder}".strip()]
        case NumberClause(word=word, words=words):
            return [f"{word} {text}" for text in (part.placeholder, *list(words)[:1])]
        case VectorClause(word=word) | DirectionClause(word=word):
            return [f"{word} {part.placeholder}"]
        case RangeClause(word=word):
            return [f"{word} {part.placeholder} to {part.placeholder}"]
        case LimitsClause(word=word):
            return [f"{word} {part.placeholder} and {part.placeholder}"]
        case DirectedClause(word=word, along=along):
            return [f"{word} {part.placeholder}S", f"{word} {part.placeholder} {along} VECTOR"]
        case ChoiceClause(in_forms=False):
            return []
        case ChoiceClause(word=word, words=words, place=place):
            return [f"{word} {one}" for one in ([place] if place else words)]
        case EitherClause(clauses=clauses):
            return [f"{one.word} {one.placeholder}" for one in clauses]
        case FlagPart(text=text):
            return [text]
        case ProfileClause(path=path):
            paths = [f"{word} {PATH}" for word in PATH_WORDS] if path else []
            return ["using PROFILE", *paths]
        case NameClause(word=word, places=places):
            return [f"{word} {place.text}".strip() for place in places]
        case UnionClause(word=word, places=(place, *_), count=count):
            return [f"{word} [{', '.join([place.text] * count)}]"]
        case ConditionClause(word=word) | ValueClause(word=word) | UnitClause(word=word):
            return [f"{word} {part.placeholder}".strip()]
        case ClausePart(word=word, place=place) if place:
            return [f"{word} {place}".strip()]
        case _:
            return []
