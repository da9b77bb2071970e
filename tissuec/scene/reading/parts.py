"""Parts of a text: blocks, and sentences outside of all blocks.

Each is declared once, in the file of ``scene`` that reads it. From its declaration follow which
words begin a part, hints about its form, its row in the reference, and completion, hovers and
colours in editors.
"""

from collections.abc import Callable, Collection, Mapping
from functools import cache, lru_cache
from typing import Any, Literal, TypeAlias

from msgspec import Struct

from tissuec.core.fields import OneOf
from tissuec.core.registry import Family
from tissuec.lang.unopened import add_vocabulary
from tissuec.scene.reading.entries import (
    NEEDED,
    BlockEntries,
    Entries,
    Entry,
    by_name,
    entries_of_members,
    entry,
    written,
)
from tissuec.script.forms import VerbSentence, form_of, texts_of_sentences
from tissuec.script.parts import NameClause

Sort: TypeAlias = Literal["text", "named", "single", "sentence"]


class TextPart(Struct, frozen=True, kw_only=True):
    """A kind of block, or of sentence outside of all blocks.

    Attributes:
        about: What it is, in one sentence.
        place: Its place among all parts in lists; they begin with what a text is, then words,
            bodies and instruments, settings, and sentences.
        sort: ``text`` is followed by a text in quotes, ``named`` by a name and a block,
            ``single`` by a block, which a scene has once; ``sentence`` is none of these.
        sentences: Classes of its forms; by default, it consists of its word, of a name if it
            has one, and of a block.
        example: How it is written, in messages; by default the first form.
        block: What its braces contain.
        names: Which parts have names that must differ, since sentences use them without their
            kinds; by default only those of its kind.
        within: Kinds of blocks that can contain such sentences as well.
        entries_vary: Whether its entries are likely to be set from outside.
        read: Reads a named block as far as it needs no mesh, from a ``ResolvedProgram`` and a
            ``Declared``. ``Scene.blocks`` contains what it returns.
    """

    about: str
    place: int = 90
    sort: Sort = "named"
    sentences: tuple[type[VerbSentence], ...] = ()
    example: str = ""
    block: BlockEntries | None = None
    names: str = ""
    within: tuple[str, ...] = ()
    entries_vary: bool = False
    read: Callable[[Any, Any], Any] | None = None

    @property
    def clauses(self) -> frozenset[str]:
        """The joining words that can follow its name."""
        return frozenset(word for kind in self.sentences for word, *_ in form_of(kind).clauses)


#: ``names`` of what a scene contains.
SCENE = "scene"
#: Leads to what something is based on.
LIKE = "like"
#: Begins what repeats statements.
REPEAT = "repeat"
#: Every part by the word that it begins with; blocks of other packages are ``tissuec.block``.
PARTS: Family[TextPart] = Family("tissuec.scene", "block")


def declare(
    word: str,
    about: str,
    place: int,
    sort: Sort = "named",
    *,
    read: Callable[[Any, Any], Any] | None = None,
    **more: Any,
) -> None:
    """Declare a part.

    Args:
        word: That it begins with.
        about, place, sort, read, more: Attributes of ``TextPart``.
    """
    PARTS.member(word)(TextPart(about=about, place=place, sort=sort, read=read, **more))
    forget()


def forget() -> None:
    """Forget everything that was derived from the parts, because there are others now."""
    for known in (parts, blocks, _heads, entries_in):
        known.cache_clear()


@cache
def parts(*sorts: str) -> dict[str, TextPart]:
    """The parts of some sorts, by default of all, in their order in lists."""
    found = [(part.place, word, part) for word, part in PARTS.items()]
    return {
        word: part
        for _, word, part in sorted(found, key=lambda one: one[:2])
        if part.sort in sorts or not sorts
    }


def settable(sort: Sort) -> list[str]:
    """The parts of a sort whose entries are likely to be set from outside."""
    return [word for word, part in parts(sort).items() if part.entries_vary]


def forms_of(word: str) -> tuple[str, ...]:
    """How a part is written; words in capitals are placeholders."""
    part = PARTS[word]
    head = {"named": " NAME", "single": " { … }"}
    derived = texts_of_sentences(word, part.sentences)
    return derived or (f"{word}{head.get(part.sort, '')}",)


def example_of(word: str) -> str:
    """An example of how a part is written, for messages."""
    part = PARTS[word]
    block = " { … }" if part.sort == "named" else ""
    return part.example or f"{forms_of(word)[0]}{block}"


def share_names(word: str, other: str) -> bool:
    """Whether the names of two parts must differ, as those of one part must."""
    names = PARTS[word].names
    return word == other or (names != "" and PARTS[other].names == names)


@cache
def blocks() -> Mapping[str, BlockEntries]:
    """What the braces of each kind of block contain, also of blocks inside others.

    These are called as the entry that opens them: "mesh", "spring law".
    """
    outer = {word: part.block for word, part in parts().items() if part.block is not None}
    inner: dict[str, BlockEntries] = {}
    for block in outer.values():
        for name, one in block.entries("").items():
            if (inside := one.inside) is not None:
                inner.setdefault(name, inside)
    return inner | outer


def names_something(kind: type[VerbSentence]) -> bool:
    """Return whether the first words of a sentence are followed by a name that is new."""
    part = form_of(kind).of_word("")
    return isinstance(part, NameClause) and any(place.new for place in part.places)


@cache
def _heads() -> dict[str, bool]:
    """The words that begin blocks, and whether a name follows them."""
    known = (one for block in blocks().values() for one in block.entries("").values())
    inner = (
        one.name
        for one in known
        if one.opens is not None and any(map(names_something, one.sentences))
    )
    outer = {word: part.sort == "named" for word, part in parts("named", "single").items()}
    return {**dict.fromkeys(inner, True), **outer}


add_vocabulary(_heads)


@lru_cache(maxsize=1024)
def entries_in(kind: str, member: str = "") -> Entries:
    """The entries of a kind of block; see ``blocks``.

    Args:
        kind: First word of a part, or the name of the entry that opens the block.
        member: The member that the block chooses, if it is known.
    """
    found = blocks().get(kind)
    if found is None:
        return {}
    others = (
        written(word, part.about, *part.sentences, repeats=True, begins=" ")
        for word, part in parts("sentence").items()
        if kind in part.within
    )
    return {**found.entries(member), **by_name(*others)}


def block(
    entries: Entries | Callable[[], Entries],
    *free: type[VerbSentence],
    elsewhere: Collection[str] = (),
) -> BlockEntries:
    """What a block contains whose entries do not depend on a choice.

    Args:
        entries: The entries, or what returns them.
        free, elsewhere: See ``BlockEntries``.
    """
    others = frozenset(elsewhere)
    if callable(entries):
        return BlockEntries(lambda _: entries(), free=free, elsewhere=others)
    return BlockEntries(lambda _: entries, free=free, elsewhere=others)


def block_of(
    members: Mapping[str, type], about: str, *others: Entry, default: Any = NEEDED
) -> BlockEntries:
    """What a block contains whose entry ``kind`` chooses a member of a family.

    Args:
        members: Classes by name, whose fields are entries.
        about, default: Of the entry ``kind``.
        others: Entries that all of them have.
    """
    own = by_name(entry("kind", OneOf(members), about, default), *others)
    return BlockEntries(lambda kind: {**own, **entries_of_members(members, kind)}, "kind")
