"""Declarations and references of names, and the outline of a text."""

from collections.abc import Iterator
from pathlib import Path

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.resources import library
from tissuec.core.source import Span
from tissuec.core.units import SYMBOLS
from tissuec.lang import syntax as s
from tissuec.lang.tokens import STRING, WORD, Token, tokens
from tissuec.lang.tree import Statement, Tree
from tissuec.lang.words import written_name
from tissuec.lsp.expected import NUMBERS, ONE_NAMESPACE, SUBJECTS
from tissuec.lsp.symbols import Symbol
from tissuec.lsp.views import View, view_of
from tissuec.scene.program.imports import Program
from tissuec.scene.program.library import SUFFIX, Library
from tissuec.scene.reading.parts import parts as text_parts


class Place(Struct, frozen=True):
    """A stretch of a file, as offsets in the text that the compiler reads."""

    path: Path
    start: int
    stop: int


def definitions(view: View, offset: int) -> list[Place]:
    """Return where the name at an offset is declared, or the file that is used there."""
    if found := view.symbols_at(offset):
        return [place for one, *_ in found if (place := _place(one.span)) is not None]
    part, phrase = view.structure.lexeme_at(offset), view.phrase_at(offset)
    if part is None or part.kind != STRING or phrase is None or phrase.expected.files != "use":
        return []
    path = used_file(view, part.text.strip('"'))
    return [Place(path, 0, 0)] if path else []


def used_file(view: View, wanted: str) -> Path | None:
    """Return the file that ``use`` would take."""
    where = Library.of(view.source, view.documents.libraries)
    name = wanted if wanted.endswith(SUFFIX) else wanted + SUFFIX
    hits = (place / name for place in where.places(wanted) if view.documents.has(place / name))
    return next(hits, None) if wanted else None


def _place(span: Span) -> Place | None:
    path = span.source.path
    return Place(path, span.start, span.end) if path else None


# --- uses -------------------------------------------------------------------------------------


def references(views: list[View], symbol: Symbol) -> list[Place]:
    """Return every place that names a symbol, its declaration among them, in some texts."""
    found: dict[tuple[Path, int], Place] = {}
    for view in views:
        path = view.source.path
        for other, start, stop in view.occurrences():
            if path is not None and _same(other, symbol):
                found.setdefault((path.resolve(), start), Place(path, start, stop))
    return list(found.values())


def _same(one: Symbol, other: Symbol) -> bool:
    """Return whether two texts mean the same declaration."""
    paths = [symbol.span.source.path for symbol in (one, other)]
    if (one.kind, one.key, one.within) != (other.kind, other.key, other.within):
        return False
    return one.span.start == other.span.start and (
        paths[0] == paths[1] or (None not in paths and _real(paths[0]) == _real(paths[1]))
    )


def _real(path: Path | None) -> Path | None:
    return path.resolve() if path else None


def around(view: View) -> list[View]:
    """Return the view of a text and of all that it uses."""
    program: Program | None = view.program
    modules = program.modules if program else ()
    paths = [m.source.path for m in modules if m.source.path and m.source is not view.source]
    views = (view_of(view.documents, path) for path in paths)
    return [view, *(other for other in views if other is not None)]


class Renaming(Struct, frozen=True):
    """New name and its places."""

    places: tuple[Place, ...]
    text: str


def rename(view: View, views: list[View], offset: int, name: str) -> Renaming:
    """Return the edits that rename a name everywhere.

    Args:
        views: The texts in which the name may occur.
        offset: Place of the name.
        name: The new name.

    Raises:
        TissueError: There is nothing to rename, or the new name is not allowed.
    """
    symbol = renamable(view, offset)
    text = " ".join(name.split())
    parts = list(tokens(text))
    if not text or '"' in text or "#" in text:
        raise TissueError("a name consists of words without quotes and #")
    if symbol.kind in ONE_NAMESPACE and text in SYMBOLS:
        raise TissueError(f'"{text}" is a unit and cannot be a name')
    if symbol.kind in ("property", "quantity", "word", "hedge") and any(
        part.kind != WORD for part in parts
    ):
        raise TissueError("words of a vocabulary must not be in quotes")
    kinds = ONE_NAMESPACE if symbol.kind in ONE_NAMESPACE else (symbol.kind,)
    for other in view.of_kind(*kinds):
        if other.key == s.key_of(text) != symbol.key and other.within == symbol.within:
            raise TissueError(f'"{text}" is already defined at {other.span.place}')
    return Renaming(tuple(references(views, symbol)), written_name(text))


def renamable(view: View, offset: int) -> Symbol:
    """Return the symbol at an offset.

    Raises:
        TissueError: It cannot be renamed.
    """
    found = view.symbol_at(offset)
    if found is None or view.in_remark(offset):
        raise TissueError("there is no defined name at this position")
    symbol = found[0]
    path = symbol.span.source.path
    if path is None or library().resolve() in path.resolve().parents:
        raise TissueError(f'"{symbol.name}" is defined in the shipped library')
    if symbol.kind == "quantity":
        raise TissueError("quantities of the language cannot be renamed")
    return symbol


# --- outline ----------------------------------------------------------------------------------


class Outlined(Struct, frozen=True):
    """A part of a text, for the outline.

    Attributes:
        kind: "body", "script", "param" and so on.
        start: Of all of it.
        at: Of its name.
    """

    name: str
    kind: str
    start: int
    stop: int
    at: int
    end: int
    inner: "tuple[Outlined, ...]" = ()


def outline(tree: Tree) -> list[Outlined]:
    """Return the parts of a text in order, right or wrong."""
    return [found for statement in tree.items if (found := _outlined(statement)) is not None]


def _outlined(statement: Statement) -> Outlined | None:
    parts = statement.parts
    if not parts:
        return None
    first = parts[0].text.lower()
    stop = statement.close if statement.is_head else parts[-1].stop
    if first in text_parts("single") and statement.is_head:
        inner = tuple(_lines(statement)) if first == "script" else ()
        return Outlined(
            first, first, parts[0].start, stop, parts[0].start, parts[0].stop, inner
        )
    if first == "expect":
        text = " ".join(part.text for part in parts[1:])
        return Outlined(
            text or first, first, parts[0].start, stop, parts[0].start, parts[-1].stop
        )
    if first not in (*text_parts("named"), *NUMBERS, *SUBJECTS, "hedge", "table"):
        return None
    name: list[Token] = []
    for part in parts[1:]:
        if not part.is_name and not (first == "table" and part.text == "of"):
            break
        name.append(part)
    if not name:
        return None
    text = " ".join(part.text.strip('"') for part in name)
    inner = tuple(_regions(statement)) if first == "body" else ()
    return Outlined(text, first, parts[0].start, stop, name[0].start, name[-1].stop, inner)


def _regions(body: Statement) -> Iterator[Outlined]:
    for item in body.items:
        words = item.words
        if words[:1] == ["region"] and words[1:]:
            first, last = item.parts[1], item.parts[len(words) - 1]
            yield Outlined(
                " ".join(words[1:]), "region", item.parts[0].start, item.close, first.start,
                last.stop,
            )  # fmt: skip


def _lines(script: Statement) -> Iterator[Outlined]:
    """Yield the orders of a script."""
    for item in script.items:
        if item.parts:
            first, last = item.parts[0], item.parts[-1]
            text = " ".join(_order_text(item).split())
            stop = item.close if item.is_head else last.stop
            yield Outlined(text, "order", first.start, stop, first.start, last.stop)


def _order_text(item: Statement) -> str:
    """Return an order on one line."""
    pieces: list[str] = []
    before = item.parts[0]
    for part in item.parts:
        pieces += ["" if part.start == before.stop else " ", part.text]
        before = part
    return "".join(pieces)


class FoldingRange(Struct, frozen=True):
    """Lines that can be folded away, as offsets."""

    start: int
    stop: int


def folds(view: View) -> Iterator[FoldingRange]:
    """Yield the blocks of a text."""
    for statement in view.structure.statements:
        if statement.is_head and statement.parts:
            yield FoldingRange(statement.parts[0].start, statement.close)
