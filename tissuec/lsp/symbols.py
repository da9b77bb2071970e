"""Names that a text declares, with those inside of blocks: words, regions, columns."""

from collections.abc import Iterable, Iterator

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.program.declarations import Declarations, Declared, without
from tissuec.script.tools import GROUPS, TOOLS, kinds_in


class Symbol(Struct, frozen=True):
    """A name and where it is declared.

    Attributes:
        kind: "param", "body", "property", "region", "word" and so on.
        within: For a word its property or quantity, for a region its body, for a column of a
            table its study; by key.
        sorts: Of a set what it holds, "nodes" or "springs"; of a tool its kind, and "holding"
            if it can hold nodes. All that it may be while that is not written.
    """

    kind: str
    name: str
    span: Span
    within: str = ""
    sorts: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        return s.key_of(self.name)


def symbols_of(declarations: Declarations) -> Iterator[Symbol]:
    """Yield all names that are declared, and those inside of their blocks."""
    for name in declarations.indices:
        yield Symbol("let", name.text, name.span)
    for kind, names in declarations.named.items():
        written = set[int]()  # starts of names that hold the index of a repetition
        for declared in names.values():
            name, sorts = declared.name, _sorts(declared, declarations)
            yield Symbol(kind, name.text, name.span, "", sorts)
            if name.span.repetition and name.quoted is None and name.span.start not in written:
                written.add(name.span.start)
                yield Symbol(kind, name.span.one_line, name.span, "", sorts)
            yield from _inside(kind, declared)


def _sorts(declared: Declared, declarations: Declarations) -> tuple[str, ...]:
    """Return the sorts of a set or tool."""
    sets, joints = declarations.of("set"), declarations.of("joint")
    for _ in range(len(sets) + 1):  # sets that hold each other in a circle have no end
        match declared.item:
            case s.Assign(keyword="set", value=s.Name(key="nodes" | "springs" as sort)):
                return (sort,)
            case s.Assign(keyword="set", value=s.Listing(items=(s.Name(key=key), *_))):
                if key not in sets:
                    return ("springs",) if key in joints else ("nodes",)
                declared = sets[key]
            case s.Assign(keyword="set"):
                break
            case s.Block(name=name, items=items) if name.words.startswith("tool"):
                return _sorts_of_tool(items)
            case _:
                return ()
    return ("nodes", "springs")


def _sorts_of_tool(items: Iterable[s.Item]) -> tuple[str, ...]:
    said = (
        item.phrase.words[0].key
        for item in items
        if isinstance(item, s.Sentence) and item.name.key == "kind" and item.phrase
    )
    kind = next(said, "")
    kinds = (kind,) if kind in TOOLS else tuple(TOOLS)
    groups = tuple(one for one in GROUPS if kind not in TOOLS or kind in kinds_in(one))
    return (*kinds, *groups) if kind == "scissors" else (*kinds, *groups, "holding")


def _inside(kind: str, declared: Declared) -> Iterator[Symbol]:
    """Yield the words of a scale, the regions of a body, or the columns of a study."""
    if not isinstance(declared.item, s.Block):
        return
    within = declared.name.key
    for item in declared.item.items:
        if kind in ("property", "quantity"):
            for name in _words_in(item):
                yield Symbol("word", name.text, name.span, within)
        elif kind == "study" and isinstance(item, s.Assign):
            name = without(item.name, "measure")
            if name is not None:
                yield Symbol("column", name.text, name.span, within)
        elif kind == "body" and isinstance(item, s.Block):
            first, _, rest = item.name.words.partition(" ")
            if first.lower() == "region" and (rest or item.name.quoted):
                text = rest or item.name.quoted or ""
                start = item.name.span.start + item.name.span.text.find(text, len(first))
                span = Span(item.name.span.source, start, item.name.span.end)
                yield Symbol("region", text, span, within)


def _words_in(item: s.Item) -> Iterator[s.Name]:
    match item:
        case s.Assign(name=s.Name(key="evenly"), value=s.Listing(items=names)):
            yield from (name for name in names if isinstance(name, s.Name))
        case s.Sentence(name=s.Name(key="applies" | "otherwise")):
            pass
        case s.Assign(name=name) | s.Sentence(name=name):
            yield name
        case _:
            pass
