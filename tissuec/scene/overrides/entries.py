"""``--set``: other values for params, and for entries of blocks, before anything is read.

``hardness of gland is slightly hard`` replaces an entry of the block that is called so, or adds
it; ``cells of lobe = 20`` finds one of the mesh inside a body, and ``tissue of scar of lobe is
fat`` one of its region. Entries of ``simulate`` and ``environment`` need no such name.
"""

import re
from collections.abc import Collection, Iterator, Sequence
from typing import Any, NoReturn, TypeAlias, cast

from msgspec import Struct

from tissuec.core.errors import CompileError, Diagnostic, Note
from tissuec.core.hints import Hint, alternatives, did_you_mean
from tissuec.core.names import key_of
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import parse
from tissuec.meshes.generators import MESHES
from tissuec.scene.bodies.block import ENTRIES
from tissuec.scene.program.declarations import Declarations, Declared, without
from tissuec.scene.program.parameters import refuse_override
from tissuec.scene.reading.entries import Written
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import entries_in, parts, settable
from tissuec.scene.tissues.evidence import KNOWN

SET = "--set"
_OF = re.compile(r'\s+of\s+(?=[^"]*(?:"[^"]*"[^"]*)*$)')  # outside of quotes
_OWNED = re.compile(
    r'\s*(?P<entry>(?:"[^"]*"|[^="])+?)(?P<owner>\s+of\s+(?:"[^"]*"|[^="])+?)\s*(?==|\bis\b)'
)
#: Entries of simulate that exclude each other; who sets one leaves out the other.
_RIVALS = {"step": "tolerance", "tolerance": "step"}

Entry: TypeAlias = s.Assign | s.Sentence | s.Block
#: The path to an item: its place among the items of a block, and so on inside that.
_Path: TypeAlias = tuple[int, ...]


class Override(Struct, frozen=True):
    """One text of ``--set``.

    Attributes:
        item: Without the names of blocks.
        owners: Names after ``of``: of the innermost block first; none for a param or an entry
            of simulate or environment.
    """

    item: Entry
    owners: tuple[s.Name, ...]

    @property
    def entry(self) -> str:
        """Return the text of the entry, without the names of blocks."""
        name, whole = self.item.name.span, self.item.span
        after = self.owners[-1].span.end if self.owners else name.end
        text = whole.source.text
        return f"{text[whole.start : name.end].rstrip()} {text[after : whole.end].lstrip()}"


class _Home(Struct, frozen=True):
    """A block where an entry may belong, inside of one that is declared.

    Attributes:
        kind: Of the declared block.
        path: From that to the block, empty for itself.
    """

    kind: str
    declared: Declared
    path: _Path
    block: s.Block

    @property
    def name(self) -> str:
        return f"{self.kind} {self.declared.name.text}".strip()


def read_overrides(
    texts: Sequence[str], declarations: Declarations, findings: Findings
) -> dict[str, s.Assign]:
    """Return the assignments of ``--set`` to params by name; entries go to the declarations.

    Args:
        texts: The arguments of ``--set``.
        declarations: Of the scene; blocks are replaced in place.
    """
    given: dict[str, s.Assign] = {}
    for text in texts:
        with findings.item():
            override = read_override(text, findings)
            if declarations.functions is not None:
                item = declarations.functions.applied(override.item)
                override = replace(override, item=item)
            item, params = override.item, declarations.of("param")
            if isinstance(item, s.Assign) and not override.owners and item.name.key in params:
                given[item.name.key] = item
            else:
                override_entry(override, declarations, findings)
    return given


def read_override(text: str, findings: Findings) -> Override:
    """Return one text of ``--set``, or reject it.

    Args:
        text: Such as "lift = 2 mm" or "hardness of fallopian tube is soft".
    """
    item, owners = None, ()
    try:
        # The text of a command line is as foreign as that of a file.
        source = normalise(text, SET)
        item, owners = _read(source)
    except CompileError as error:
        findings.extend(error.diagnostics)
        findings.stop()
    if not isinstance(item, Entry) or _is_more(item):
        message = f'cannot read {SET} "{text}"'
        hint = 'for example: --set "lift = 2 mm", or --set "hardness of gland is soft"'
        findings.reject("TIS505", message, None, hint=hint)
    return Override(item, owners)


def override_entry(override: Override, declarations: Declarations, findings: Findings) -> None:
    """Replace an entry of a block, or add it, or reject the override.

    Args:
        override: What is to be written.
        declarations: Of the scene; the block is replaced in place.
    """
    home = _home(override, declarations, findings)
    inner, path = _place(home, override.item, findings)
    key = override.item.name.key
    rival = _RIVALS.get(key, "") if home.kind == "simulate" else ""
    replaced = [at for at in _written(inner, key) if at == path]
    replaced += _written(inner, rival) if rival else ()
    declarations.replaced += tuple(_item_at(inner, at) for at in replaced)
    block = _with(inner, path, override.item)
    if rival:
        kept = (i for i in block.items if not (isinstance(i, Entry) and i.name.key == rival))
        block = replace(block, items=tuple(kept))
    whole = _with(home.declared.item, home.path, block) if home.path else block
    if home.kind in declarations.single:
        declarations.single[home.kind] = whole
    else:
        declared = Declared(home.declared.name, whole)
        declarations.named[home.kind][home.declared.name.key] = declared


def written_entry(
    override: Override, declarations: Declarations, findings: Findings
) -> s.Item | None:
    """Return the item that an override would replace; None if it would add one.

    Args:
        override: What is to be written.
        declarations: Of the scene.
        findings: Takes diagnostics, where there is no such block or entry.
    """
    block, path = _place(_home(override, declarations, findings), override.item, findings)
    return (
        _item_at(block, path) if path in set(_written(block, override.item.name.key)) else None
    )


def written_place(override: Override, declarations: Declarations, findings: Findings) -> Span:
    """Return the text that an override would replace; an empty place in a block to add it.

    Args:
        override: What is to be written.
        declarations: Of the scene.
        findings: Takes diagnostics, where there is no such block or entry.
    """
    home = _home(override, declarations, findings)
    block, path = _place(home, override.item, findings)
    rival = _RIVALS.get(override.item.name.key, "") if home.kind == "simulate" else ""
    for key in (override.item.name.key, rival):
        for written in _written(block, key):
            if written == path or key == rival:
                return _item_at(block, written).span
    inner = _item_at(block, path[:-1]) if path[:-1] else block
    close = inner.span.end - 1
    return Span(inner.span.source, close, close)


# --- reading ----------------------------------------------------------------------------------


def _read(source: Source) -> tuple[s.Item | None, tuple[s.Name, ...]]:
    """Return the item that a text contains and the names after ``of``.

    Raises:
        CompileError: It cannot be parsed.
    """
    found, text = _OWNED.match(source.text), source.text
    start, end = found.span("owner") if found else (0, 0)
    bare = Source(source.name, text[:start] + " " * (end - start) + text[end:])
    try:
        items = parse(bare, has_heading=False).items
    except CompileError as error:
        entry, owner = bare.text[:start].strip(), text[start:end].rstrip()
        raise CompileError(
            [_owned(_moved(one, source), entry, owner) for one in error.diagnostics]
        ) from None
    item = _moved(items[0], source) if len(items) == 1 else None
    return item, tuple(_owners(source, start, end))


def _owners(source: Source, start: int, end: int) -> Iterator[s.Name]:
    """Yield the names after ``of`` in a part of a text."""
    for part in _OF.split(f" {source.text[start:end]}")[1:]:
        place = source.text.index(part, start)
        start = place + len(part)
        words, _, quoted = part.strip().partition('"')
        name = words.strip(), quoted.rstrip('"') if quoted else None
        yield s.Name(" ".join(name[0].split()), name[1], Span(source, place, start))


def _moved(node: Any, source: Source) -> Any:
    """Return a node, or a finding, whose places are in another source of the same length."""
    match node:
        case Span():
            return Span(source, node.start, node.end)
        case tuple():
            return tuple(_moved(part, source) for part in cast(tuple[Any, ...], node))
        case Struct():
            fields = {name: getattr(node, name) for name in node.__struct_fields__}
            return replace(
                node, **{name: _moved(part, source) for name, part in fields.items()}
            )
        case _:
            return node


def _owned(finding: Diagnostic, entry: str, owner: str) -> Diagnostic:
    """Return a finding whose hint names an entry with its block: "rows of strip = 5".

    Args:
        finding: Of the text without the name of the block.
        owner: The name of the block after "of", with that word and a blank before it.
    """
    hint = finding.hint.replace(f'"{entry} ', f'"{entry}{owner} ') if owner else finding.hint
    return replace(finding, hint=Hint(hint, *finding.edits))


def _is_more(item: Entry) -> bool:
    """Return whether an item is more than an entry, or less: has limits, or no value."""
    if isinstance(item, s.Assign):
        return bool(item.keyword or item.bounds)
    return isinstance(item, s.Sentence) and not item.phrase and item.name.quoted is None


# --- places -----------------------------------------------------------------------------------


def _home(override: Override, declarations: Declarations, findings: Findings) -> _Home:
    """Return the block where an entry is written, or could be; reject ambiguous ones."""
    item, key = override.item, override.item.name.key
    if not override.owners:
        homes = [_single(kind, declarations) for kind, entries in _singles().items()
                 if kind in declarations.single and key in entries]  # fmt: skip
        if not homes:
            _refuse_unowned(item, declarations, findings)
        return homes[0]
    *inner, outer = override.owners
    homes = [_inside(home, inner) for home in _named(outer, declarations)]
    found = [home for home in homes if home is not None]
    if not found:
        _refuse_owner(override, bool(homes), declarations, findings)
    if len(found) > 1:
        there = [home for home in found if any(_written(home.block, key))]
        found = there or [home for home in found if _takes(home, key, declarations)]
        if not found:
            _refuse_entry(item, outer, declarations, findings)
    if len(found) > 1:
        names = " or ".join(f'"{item.name.text} of {home.name}"' for home in found)
        findings.reject(
            "TIS505",
            f'"{outer.text}" can be {" or ".join(home.name for home in found)}',
            outer.span,
            hint=f"write {names}",
        )
    return found[0]


def _singles() -> dict[str, Collection[str]]:
    return {
        word: [
            name
            for name, entry in entries_in(word).items()
            if not isinstance(entry.kind, Written)
        ]
        for word in settable("single")
    }


def _single(kind: str, declarations: Declarations) -> _Home:
    block = declarations.single[kind]
    return _Home(kind, Declared(s.Name("", None, block.head), block), (), block)


def _named(name: s.Name, declarations: Declarations) -> list[_Home]:
    """Return the declared blocks that a name can mean, with or without its kind."""
    if name.key in declarations.single:
        return [_single(name.key, declarations)]
    homes: list[_Home] = []
    for kind in parts("named"):
        rest = without(name, kind)
        for key in {name.key, rest.key if rest is not None else name.key}:
            declared = declarations.of(kind).get(key)
            if declared is not None and isinstance(declared.item, s.Block):
                homes.append(_Home(kind, declared, (), declared.item))
    return homes


def _blocks(declarations: Declarations) -> Iterator[_Home]:
    """Yield the blocks whose entries are likely to be set."""
    for kind in settable("named"):
        for declared in declarations.of(kind).values():
            if isinstance(declared.item, s.Block):
                yield _Home(kind, declared, (), declared.item)


def _inside(home: _Home, names: Sequence[s.Name]) -> _Home | None:
    """Return the block inside of one with names, the outermost last; None without it."""
    for name in reversed(names):
        blocks = (
            (place, item)
            for place, item in enumerate(home.block.items)
            if isinstance(item, s.Block)
        )
        ways = ((place, item) for place, item in blocks if name.key in _names_of(item))
        found = next(ways, None)
        if found is None:
            return None
        home = replace(home, path=(*home.path, found[0]), block=found[1])
    return home


def _names_of(block: s.Block) -> set[str]:
    """Return how an inner block can be called: "region scar", or "scar"."""
    return {block.name.key, key_of(block.name.text.partition(" ")[2])}


def _written(block: s.Block, key: str, path: _Path = ()) -> Iterator[_Path]:
    """Yield where an entry is written in a block, or in blocks inside."""
    for place, item in enumerate(block.items):
        if isinstance(item, Entry) and item.name.key == key:
            yield (*path, place)
        if isinstance(item, s.Block):
            yield from _written(item, key, (*path, place))


def _place(home: _Home, item: Entry, findings: Findings) -> tuple[s.Block, _Path]:
    """Return a block and where in it an entry goes; after the last item if it is new."""
    paths = list(_written(home.block, item.name.key))
    nearest = [path for path in paths if len(path) == min(map(len, paths))]
    if len(nearest) > 1:
        notes = tuple(Note("here", _item_at(home.block, path).span) for path in nearest)
        inner = (_item_at(home.block, path[:-1]) for path in nearest)
        names = " or ".join(
            f'"{item.name.text} of {block.name.text} of {home.declared.name.text}"'
            for block in inner
            if isinstance(block, s.Block)
        )
        findings.reject(
            "TIS505",
            f'"{item.name.text}" is written {len(nearest)} times in {home.name}',
            item.name.span,
            notes=notes,
            hint=f"write {names}",
        )
    if nearest:
        return home.block, nearest[0]
    for place, inner in enumerate(home.block.items):
        if home.kind == "body" and item.name.key in _of_mesh(inner) - set(ENTRIES):
            assert isinstance(inner, s.Block)
            return home.block, (place, len(inner.items))
    return home.block, (len(home.block.items),)


def _item_at(block: s.Block, path: _Path) -> s.Item:
    """Return the item at a place inside a block."""
    first, *rest = path
    item = block.items[first]
    return _item_at(cast(s.Block, item), tuple(rest)) if rest else item


def _with(block: s.Item, path: _Path, item: Entry) -> s.Block:
    """Return a block with another item at a place, or one more after the last."""
    assert isinstance(block, s.Block)
    first, *rest = path
    items = list(block.items)
    items[first : first + 1] = [_with(items[first], tuple(rest), item) if rest else item]
    return replace(block, items=tuple(items))


def _of_mesh(item: s.Item) -> set[str]:
    """Return the entries of a mesh, from its block; none for another item."""
    if not isinstance(item, s.Block) or item.name.key != "mesh" or item.phrase is None:
        return set()
    kind = item.phrase.words[0].key
    return set(entries_in("mesh", kind)) if kind in MESHES else set()


def _takes(home: _Home, key: str, declarations: Declarations) -> bool:
    """Return whether a block can have an entry; of some kinds it is not known here."""
    known = _known(home, declarations)
    return not known or key in known


def _known(home: _Home, declarations: Declarations) -> Collection[str]:
    """Return the entries that a block of tissue or a body can have; none for other blocks."""
    if home.kind == "tissue":
        return {*entries_in("tissue"), *declarations.of("property")} - {KNOWN}
    if home.kind == "body":
        return set(ENTRIES).union(*map(_of_mesh, home.block.items))
    return ()


# --- what is refused --------------------------------------------------------------------------


def _refuse_unowned(item: Entry, declarations: Declarations, findings: Findings) -> NoReturn:
    """Reject an entry without the name of a block that is neither a param nor of simulate."""
    key = item.name.key
    findings.pass_over_doubtful(key)
    is_let = key in declarations.of("let")
    if key in declarations.of("param"):  # a sentence
        message = f'"{item.name.text}" is a param: write = and a number'
        findings.reject("TIS505", message, item.span, hint=f"for example: {key} = 1")
    for home in _blocks(declarations):
        if key in _known(home, declarations) or any(_written(home.block, key)):
            message = f'"{item.name.text}" cannot be set: there is no such param'
            text = f"{item.name.text} of {home.declared.name.text}"
            hint = f'name the block of the entry, such as "{text}"'
            findings.reject("TIS505", message, item.name.span, hint=hint)
    known = [declared.name.text for declared in declarations.of("param").values()]
    entries = [entry for several in _singles().values() for entry in several]
    if isinstance(item, s.Sentence) or did_you_mean(key, entries):
        known += entries
    refuse_override(item, known, findings, is_let)


def _refuse_entry(
    item: Entry, owner: s.Name, declarations: Declarations, findings: Findings
) -> NoReturn:
    """Reject an entry that no block with a name can have."""
    homes = _named(owner, declarations)
    names = " or ".join(home.name for home in homes)
    known = {entry: None for home in homes for entry in sorted(_known(home, declarations))}
    hint = alternatives(item.name.key, list(known), what="entries")
    findings.refuse_entry(item.name, names, hint=hint, code="TIS505")


def _refuse_owner(
    override: Override, is_found: bool, declarations: Declarations, findings: Findings
) -> NoReturn:
    """Reject the name of a block that is not there.

    Args:
        override: What cannot be written.
        is_found: Whether the outermost block is there, and one inside of it is not.
        declarations: Of the scene.
    """
    *inner, outer = override.owners
    if is_found:
        message = f'"{outer.text}" has no block called "{inner[-1].text}"'
        findings.reject("TIS505", message, inner[-1].span)
    findings.pass_over_doubtful(outer.key)
    names = dict.fromkeys(
        one.name.text for kind in settable("named") for one in declarations.of(kind).values()
    )
    findings.reject(
        "TIS505",
        f'there is no block called "{outer.text}"',
        outer.span,
        hint=alternatives(outer.text, [*names, *declarations.single], what="blocks"),
    )
