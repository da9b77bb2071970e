"""``body B like A { … }``: the entries of another body, with some in place of its own."""

from collections.abc import Callable, Iterator
from typing import Annotated, Any

from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.scene.bodies.placement import is_placement
from tissuec.scene.program.declarations import Declarations, Declared
from tissuec.scene.program.dependency_order import Definitions
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import LIKE
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import BODY, NameClause, new_name


class BodyWords(VerbSentence, frozen=True):
    """A body, and the one that it is like."""

    name: Annotated[s.Name, new_name("body")]
    like: Annotated[s.Name | None, NameClause(LIKE, places=(BODY,))]


BODY_KIND = SentenceKind((BodyWords,))


def read_each_like(
    kind: str,
    read: Callable[[Declared], Any],
    declarations: Declarations,
    findings: Findings,
) -> dict[str, Any]:
    """Return all blocks of a kind by key; an error rejects one, and those that are like it.

    Args:
        kind: Of the blocks.
        read: Reads a block with all that it inherits, or rejects it.
        declarations: Of the scene.
    """

    def read_one(key: str) -> Any:
        bases = tuple(needs(key))
        if any(not blocks.find(name.key).is_whole for name in bases):
            findings.stop()  # what is wrong with the other one is reported there
        return read(_whole(known[key], declarations, findings))

    def needs(key: str) -> Iterator[s.Name]:
        base = _base(known[key], findings)
        return iter(() if base is None else (declarations.find(kind, base, findings).name,))

    known = declarations.of(kind)
    blocks = Definitions("bodies", needs, read_one, findings)
    found: dict[str, Any] = {}
    for key in known:
        with findings.item():
            found[key] = blocks.find(key)
    return found


def names_like(
    name: s.Name, declarations: Declarations, findings: Findings
) -> tuple[s.Name, ...]:
    """Return the name of a body, and those of the bodies that it is like, the nearest first.

    Args:
        name: Of a body that is like none of those that are like it.
        declarations: Of the scene.
    """
    declared = declarations.find("body", name, findings)
    return tuple(one.name for one in _chain(declared, declarations, findings))


def _chain(
    declared: Declared, declarations: Declarations, findings: Findings
) -> list[Declared]:
    """Return a body, and those that it is like, the nearest first."""
    chain = [declared]
    while (base := _base(chain[-1], findings)) is not None:
        chain.append(declarations.find("body", base, findings))
    return chain


def _whole(declared: Declared, declarations: Declarations, findings: Findings) -> Declared:
    """Return a body with the entries that it inherits, each before its own.

    Entries that place a body follow on those of the other one.
    """
    items: tuple[s.Item, ...] = ()
    for one in reversed(_chain(declared, declarations, findings)):
        assert isinstance(one.item, s.Block)
        own = {_key(item) for item in one.item.items} - {""}
        items = (*(item for item in items if _key(item) not in own), *one.item.items)
    assert isinstance(declared.item, s.Block)
    return Declared(declared.name, replace(declared.item, items=items))


def _base(declared: Declared, findings: Findings) -> s.Name | None:
    """Return the body that another one is like; None if it is like none."""
    assert isinstance(declared.item, s.Block)
    if not declared.item.clauses:
        return None
    said: BodyWords = SentenceReader("body", BODY_KIND, declared.item, Scope(findings)).get()
    return said.like


def _key(item: s.Item) -> str:
    """Return the subject of an item of a body; "" if several such items can hold."""
    if not isinstance(item, s.Assign | s.Sentence | s.Block):
        return ""
    key = item.name.key
    is_part = key == "springs" or (key == "interface" and bool(getattr(item, "clauses", ())))
    if is_part or is_placement(item):
        return ""
    return "made" if key.startswith("made") else key
