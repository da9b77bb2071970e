"""Entries of blocks: each is declared once, where it is read.

A declaration says how an entry is written, what it takes and what it means. From it follow the
checks and hints of the compiler, the tables of the reference, and what editors complete, show
and colour.
"""

import re
from collections.abc import Callable, Collection, Mapping
from functools import cache
from typing import Any, TypeAlias, cast

import numpy as np
from msgspec import NODEFAULT, Struct
from msgspec.structs import fields

from tissuec.core.annotations import WrongAnnotation, hints_of, refuse_field
from tissuec.core.fields import FileIn, FromTo, Named, OneOf, Point, Real, Several, Whole
from tissuec.core.markdown import code, table
from tissuec.core.registry import Family
from tissuec.core.structs import replace
from tissuec.core.units import (
    ACCELERATION,
    FREQUENCY,
    Dimension,
    describe,
    show,
    suggested_unit,
    written_unit,
)
from tissuec.script.forms import VerbSentence, form_of, texts_of_sentences
from tissuec.script.parts import ChoiceClause

#: The default of an entry that a block must have.
NEEDED = NODEFAULT


class Written(Struct, frozen=True):
    """An entry whose forms are classes of sentences.

    Attributes:
        dimension: Of its number, if it takes one.
    """

    dimension: Dimension | None = None


Kind = Real | Whole | OneOf | Point | FromTo | Several | FileIn | Named | Written


class Entry(Struct, frozen=True):
    """One entry of a block: its name in the language, its kind, default and description.

    Attributes:
        repeats: Whether a block can have it several times.
        begins: What an editor writes after its name; by default what its forms have in common.
        opens: The block that it can open, if not one of a member of a family alone.
        sentences: Classes of its forms, beside that of its kind.
        reads: Returns its value from its item and the scope, if its kind does not say how.
        has_section: Whether the reference describes it in a section of its own, which its
            description fills, and not in the table of the block.
    """

    name: str
    field: str
    kind: Kind
    default: Any
    about: str = ""
    repeats: bool = False
    begins: str = ""
    opens: "BlockEntries | None" = None
    sentences: tuple[type[VerbSentence], ...] = ()
    reads: Callable[[Any, Any], Any] | None = None
    has_section: bool = False
    examples: tuple[str, ...] = ()

    @property
    def is_required(self) -> bool:
        return self.default is NEEDED

    @property
    def forms(self) -> tuple[str, ...]:
        """The ways to write it, such as ``radius = …``."""
        if self.examples:
            return self.examples
        own = () if isinstance(self.kind, Written) else (_form(self),)
        if isinstance(self.kind, FromTo) and self.kind.may_bend:
            own = (*own, f"{self.name} through [ … ]")
        if isinstance(self.kind, Real) and self.kind.by_axis:
            own = (*own, f"{self.name} = (x, y, z)")
        return (*own, *texts_of_sentences(self.name, self.sentences))

    @property
    def dimension(self) -> Dimension | None:
        """The dimension of its numbers, if it takes some."""
        return getattr(self.kind, "dimension", None)

    @property
    def words(self) -> Mapping[str, object]:
        """The words of which one can be chosen, each with its meaning or description."""
        if isinstance(self.kind, OneOf):
            words = self.kind.words
            if isinstance(words, Mapping):
                return cast("Mapping[str, object]", words)
            return dict.fromkeys(words, "")
        parts = (form_of(kind).of_word("is") for kind in self.sentences)
        choices = (part.words.items() for part in parts if isinstance(part, ChoiceClause))
        return {word: about for several in choices for word, about in several}

    @property
    def inside(self) -> "BlockEntries | None":
        """The block that it can open."""
        members = self.members
        if members and self.opens is None:
            return BlockEntries(lambda chosen: entries_of_members(members, chosen))
        return self.opens

    @property
    def members(self) -> Mapping[str, type]:
        """The classes with the entries of the block, one for each word of the block."""
        return self.kind.inside if isinstance(self.kind, OneOf) else dict[str, type]()

    @property
    def example(self) -> str:
        """An example of how it can be written."""
        match self.kind:
            case Real(dimension=dimension, example=example):
                amount = example or f"1 {suggested_unit(dimension)}".rstrip()
                return f"{self.name} = {amount}"
            case Whole(at_least=low):
                return f"{self.name} = {max(low, 10)}"
            case OneOf(words=words):
                return f"{self.name} is {next(iter(words))}"
            case Point(dimension=dimension):
                down = -9.81 if dimension == ACCELERATION else 1
                return f"{self.name} = (0, 0, {down}) {suggested_unit(dimension)}".rstrip()
            case Several(dimension=dimension):
                unit = suggested_unit(dimension)
                return f"{self.name} = [1 {unit}, 2 {unit}]"
            case FromTo(dimension=dimension):
                unit = suggested_unit(dimension)
                return f"{self.name} from (0, 0, 0) {unit} to (10, 10, 10) {unit}"
            case FileIn():
                return f'{self.name} "liver.stl" in mm'
            case Named(example=example):
                return f'{self.name} "{example}"'
            case Written():
                return self.forms[0]


Entries: TypeAlias = Mapping[str, Entry]


class BlockEntries(Struct, frozen=True):
    """What can be written inside the braces of a block.

    Attributes:
        entries: Its entries by name, from the member that the block chooses; all for "".
        chooser: The entry that chooses the member, such as "kind", if an entry does so.
        free: Classes of entries that have names of the author's own.
        elsewhere: Entries that the reference describes on a page about several blocks.
    """

    entries: Callable[[str], Entries]
    chooser: str = ""
    free: tuple[type[VerbSentence], ...] = ()
    elsewhere: frozenset[str] = frozenset()


def entry(name: str, kind: Kind, about: str, default: Any = None, **more: Any) -> Entry:
    """An entry that is no field of a class.

    Args:
        name: In the language.
        kind, about, default, more: Attributes of ``Entry``.
    """
    return Entry(name, name.replace(" ", "_"), kind, default, about, **more)


def written(
    name: str,
    about: str,
    *sentences: type[VerbSentence],
    dimension: Dimension | None = None,
    **more: Any,
) -> Entry:
    """An entry with forms of its own.

    Args:
        name: In the language.
        about: What it means, in one sentence.
        sentences: Classes of its forms.
        dimension: Of its number, if it takes one.
        more: Other attributes of ``Entry``.
    """
    return entry(name, Written(dimension), about, sentences=sentences, **more)


def by_name(*entries: Entry) -> dict[str, Entry]:
    """Entries by their names, as names are compared."""
    return {one.name.lower(): one for one in entries}


def entries_of(cls: type) -> dict[str, Entry]:
    """The entries that a class declares, by name in the language.

    Raises:
        WrongAnnotation: A field has no kind of entry.
    """
    return dict(_entries_of(cls))


@cache
def _entries_of(cls: type) -> Entries:
    about: dict[str, str] = {}
    for one in reversed(cls.__mro__):
        about |= _attributes(one.__doc__ or "")
    entries: dict[str, Entry] = {}
    try:
        found = fields(cls)
    except Exception:
        hints_of(cls)  # says where and why
        raise
    for field in found:
        kinds = getattr(field.type, "__metadata__", ())
        if not kinds or not isinstance(kinds[0], Kind):
            one = f'{field.name}: Annotated[str, OneOf(("one", "both"))]'
            refuse_field(
                cls, field.name, field.type,
                says="how the entry is written, as tissuec.core.fields does",
                examples=f"{field.name}: Length, or {one}",
            )  # fmt: skip
        name = field.name.rstrip("_").replace("_", " ")
        entries[name] = Entry(
            name, field.name, kinds[0], field.default, about.get(field.name, "")
        )
    return entries


def entries_of_members(members: Mapping[str, type], chosen: str) -> dict[str, Entry]:
    """The entries of one member of a family; of all where it is not known which.

    Args:
        members: Classes by name. Those with fields that are no entries have none, such as a
            mesh from tables.
        chosen: Name of a member.
    """
    known = [members[chosen]] if chosen in members else members.values()
    found: dict[str, Entry] = {}
    for member in known:
        try:
            found |= _entries_of(member)
        except WrongAnnotation:
            continue
    return found


def with_choices(
    cls: type, name: str, choices: Collection[str], inside: Mapping[str, type] | None = None
) -> dict[str, Entry]:
    """The entries that a class declares, one of them with the names of a family.

    Args:
        cls: See ``entries_of``.
        name: Of the entry, in the language.
        choices: What can be written there; other packages may add to them.
        inside: See ``OneOf``.
    """
    entries = entries_of(cls)
    kind = OneOf(choices, opens=True, inside=inside or {})
    entries[name] = replace(entries[name], kind=kind)
    return entries


def _attributes(docstring: str) -> dict[str, str]:
    """The lines of the "Attributes:" section of a docstring, by field name."""
    _, _, section = docstring.partition("Attributes:\n")
    found = re.findall(r"^ {4,12}(\w+): (.*(?:\n {12,}\S.*)*)", section, re.MULTILINE)
    return {name: " ".join(text.split()) for name, text in found}


# --- for people -------------------------------------------------------------------------------


def entry_table(entries: Entries) -> str:
    """A table of the entries of a block."""
    heads = ("entry", "is", "without it", "meaning")
    return table(heads, [_row(entry) for entry in entries.values()])


def _row(entry: Entry) -> tuple[str, ...]:
    forms = " or ".join(map(code, entry.forms))
    about = f"{entry.about[:1].upper()}{entry.about[1:]}"
    return forms, taken_in_words(entry), default_in_words(entry), about


def sentence(text: str) -> str:
    """A text as a sentence, with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


def _form(entry: Entry) -> str:
    match entry.kind:
        case OneOf():
            return f"{entry.name} is …"
        case Point():
            return f"{entry.name} = (x, y, z)"
        case FromTo():
            return f"{entry.name} from … to …"
        case Several():
            return f"{entry.name} = [x, y, …]"
        case FileIn():
            return f'{entry.name} "…" in mm'
        case Named():
            return f'{entry.name} "…"'
        case _:
            return f"{entry.name} = …"


def taken_in_words(entry: Entry) -> str:
    """What can be written for an entry; nothing if its form says it."""
    match entry.kind:
        case Real(dimension, above, at_least, at_most, by_axis=by_axis):
            limits = (("above", above), ("at least", at_least), ("at most", at_most))
            within = "".join(
                f", {word} {_writable(limit, dimension)}"
                for word, limit in limits
                if limit is not None
            )
            return f"{describe(dimension)}{within}{'; one, or three' if by_axis else ''}"
        case Whole(at_least, at_most):
            most = "" if at_most == Whole().at_most else f" and at most {at_most}"
            return f"a whole number, at least {at_least}{most}"
        case OneOf(words):
            is_family = isinstance(words, Family)  # the members are described elsewhere
            return "" if is_family else " or ".join(map(code, words)) or "a word"
        case Point(dimension):
            return f"a vector: {describe(dimension)}"
        case FromTo(may_bend=may_bend):
            return "two points, or a list of points" if may_bend else "two points"
        case Several(dimension, at_least):
            return f"a list of at least {at_least}: {describe(dimension)}"
        case FileIn(dimension):
            return f"a file and its unit: {describe(dimension)}"
        case Named():
            return "a name in quotes"
        case Written():
            is_said = f"{entry.name} is …" not in entry.forms
            return "" if is_said else " or ".join(map(code, entry.words))


def default_in_words(entry: Entry) -> str:
    """What holds without an entry, as code; "needed", or nothing."""
    if entry.is_required:
        return "needed"
    if entry.default is None or entry.default == "":
        return ""
    if isinstance(entry.default, str):
        return code(entry.default)
    assert isinstance(entry.kind, Real | Whole)
    dimension = entry.kind.dimension if isinstance(entry.kind, Real) else None
    if dimension is None or not np.any(dimension):
        return code(f"{entry.default:g}")
    return code(_writable(entry.default, dimension))


def _writable(value: float, dimension: Dimension) -> str:
    """A value as a scene writes it, where no number precedes ``1/s``."""
    if dimension == FREQUENCY:
        return f"{value:g} {written_unit(dimension)}"
    return show(value, dimension)
