"""The language server: between the protocol and the pure functions of this package."""

import logging
from collections import defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar, cast

from lsprotocol import types as lsp

from tissuec.core.errors import TissueError
from tissuec.lsp import completion, navigation
from tissuec.lsp.findings import Checked, fixes_at
from tissuec.lsp.hover import hover
from tissuec.lsp.positions import ProtocolPosition, Replacement, formatted, replaced
from tissuec.lsp.semantic_tokens import KINDS, tokens_of
from tissuec.lsp.session import Session, names_in
from tissuec.lsp.signatures import signature

T = TypeVar("T")

_log = logging.getLogger(__name__)

_TOKEN_TYPES = {
    "comment": "comment", "string": "string", "number": "number", "unit": "type",
    "keyword": "keyword", "part": "class", "entry": "property", "verb": "function",
    "measure": "method", "word": "enumMember", "name": "variable", "sign": "operator",
}  # fmt: skip
_QUICK_FIX = lsp.CodeActionKind.QuickFix.value
_ITEM = lsp.CompletionItemKind
_ITEM_KINDS = {
    "part": _ITEM.Class, "entry": _ITEM.Property, "verb": _ITEM.Function,
    "measure": _ITEM.Method, "word": _ITEM.EnumMember, "keyword": _ITEM.Keyword,
    "unit": _ITEM.Unit, "file": _ITEM.File, "param": _ITEM.Constant, "let": _ITEM.Variable,
    "function": _ITEM.Function, "variable": _ITEM.Variable,
    "property": _ITEM.Property, "quantity": _ITEM.Property, "hedge": _ITEM.Operator,
}  # fmt: skip
_SYMBOL = lsp.SymbolKind
_SYMBOL_KINDS = {
    "param": _SYMBOL.Constant, "let": _SYMBOL.Variable, "set": _SYMBOL.Array,
    "function": _SYMBOL.Function,
    "body": _SYMBOL.Class, "joint": _SYMBOL.Interface, "tool": _SYMBOL.Object,
    "force": _SYMBOL.Object,
    "tissue": _SYMBOL.Struct, "property": _SYMBOL.Property, "quantity": _SYMBOL.Number,
    "rules": _SYMBOL.Namespace, "law": _SYMBOL.Function, "hedge": _SYMBOL.Operator,
    "table": _SYMBOL.Array, "script": _SYMBOL.Event, "order": _SYMBOL.Event,
    "region": _SYMBOL.Field, "expect": _SYMBOL.Boolean,
}  # fmt: skip


def make_server(libraries: tuple[Path, ...] = ()) -> Session:
    """Return a server that answers requests of editors."""
    server = Session(libraries)
    for feature, answer in _ANSWERS.items():
        options = _OPTIONS.get(feature)
        server.feature(feature, options)(_bound(server, answer))
    return server


def _bound(server: Session, answer: Callable[[Session, Any], T]) -> Callable[[Any], T | None]:
    """Return an answer that is empty, and logged, where it fails."""

    def give(parameters: Any) -> T | None:
        try:
            return answer(server, parameters)
        except TissueError as error:
            server.window_show_message(lsp.ShowMessageParams(lsp.MessageType.Info, str(error)))
            return None
        except Exception:
            _log.exception("%s failed", answer.__name__)
            return None

    return give


# --- what is open -----------------------------------------------------------------------------


def _initialised(server: Session, parameters: lsp.InitializeParams) -> None:
    options = parameters.initialization_options
    if isinstance(options, dict):
        given = cast("dict[str, Any]", options)
        server.documents.libraries += tuple(
            Path(str(one)) for one in given.get("libraries", ())
        )


def _opened(server: Session, parameters: lsp.DidOpenTextDocumentParams) -> None:
    document = parameters.text_document
    server.uris[path := server.path(document.uri)] = document.uri
    server.documents.put(path, document.text)
    server.changed(path, everything=True)


def _changed(server: Session, parameters: lsp.DidChangeTextDocumentParams) -> None:
    path = server.path(parameters.text_document.uri)
    text = server.documents.raw(path)
    for change in parameters.content_changes:
        text = _after(server, text, change)
    server.documents.put(path, text)
    server.changed(path)


def _after(server: Session, text: str, change: lsp.TextDocumentContentChangeEvent) -> str:
    """Return a text after a change.

    The library would do so, too, but it takes more characters for line ends than the protocol.
    """
    if isinstance(change, lsp.TextDocumentContentChangeWholeDocument):
        return change.text
    start, end = (
        ProtocolPosition(place.line, place.character)
        for place in (change.range.start, change.range.end)
    )
    return replaced(text, [Replacement(start, end, change.text)], server.encoding)


def _saved(server: Session, parameters: Any) -> None:
    server.changed(Path(), everything=True)


def _closed(server: Session, parameters: lsp.DidCloseTextDocumentParams) -> None:
    path = server.path(parameters.text_document.uri)
    server.documents.take_away(path)
    if path in server.waiting:
        server.waiting.pop(path).cancel()
    server.checked.pop(path, None)
    server.shown |= server.found.pop(path, {}).keys()
    server.publish()
    server.changed(path, everything=True)


# --- requests ---------------------------------------------------------------------------------


def _hover(server: Session, parameters: lsp.HoverParams) -> lsp.Hover | None:
    found = server.at(parameters)
    if found is None:
        return None
    path, view, offset = found
    checked = server.checked.get(path) or Checked((), None, is_thorough=False)
    said = hover(view, offset, checked.compiled, checked.diagnostics)
    if said is None:
        return None
    content = lsp.MarkupContent(lsp.MarkupKind.Markdown, said.text)
    return lsp.Hover(content, server.range(path, said.start, said.stop))


def _completion(server: Session, parameters: lsp.CompletionParams) -> lsp.CompletionList | None:
    found = server.at(parameters)
    if found is None:
        return None
    path, view, offset = found
    proposals = completion.complete(view, offset)
    items = [_item(server, path, one, number) for number, one in enumerate(proposals)]
    # What is typed so far may be several words, so that the editor must repeat the request.
    return lsp.CompletionList(is_incomplete=True, items=items)


def _item(
    server: Session, path: Path, one: completion.Proposal, number: int
) -> lsp.CompletionItem:
    about = lsp.MarkupContent(lsp.MarkupKind.Markdown, one.about) if one.about else None
    return lsp.CompletionItem(
        one.label,
        kind=_ITEM_KINDS.get(one.kind, _ITEM.Variable),
        detail=one.detail or None,
        documentation=about,
        sort_text=f"{number:04}",
        text_edit=lsp.TextEdit(server.range(path, one.start, one.stop), one.insert),
    )


def _definition(server: Session, parameters: lsp.DefinitionParams) -> list[lsp.Location]:
    found = server.at(parameters)
    places = navigation.definitions(found[1], found[2]) if found else []
    return [server.location(place) for place in places]


def _references(server: Session, parameters: lsp.ReferenceParams) -> list[lsp.Location]:
    found = server.at(parameters)
    hit = found[1].symbol_at(found[2]) if found else None
    if found is None or hit is None:
        return []
    places = navigation.references(server.views(found[1]), hit[0])
    if not parameters.context.include_declaration:
        places = [place for place in places if place.start != hit[0].span.start]
    return [server.location(place) for place in places]


def _highlights(
    server: Session, parameters: lsp.DocumentHighlightParams
) -> list[lsp.DocumentHighlight]:
    found = server.at(parameters)
    hit = found[1].symbol_at(found[2]) if found else None
    if found is None or hit is None:
        return []
    places = navigation.references([found[1]], hit[0])
    return [
        lsp.DocumentHighlight(server.range(found[0], place.start, place.stop))
        for place in places
    ]


def _can_rename(server: Session, parameters: lsp.PrepareRenameParams) -> lsp.Range | None:
    found = server.at(parameters)
    if found is None:
        return None
    path, view, offset = found
    navigation.renamable(view, offset)
    _, start, stop = view.symbol_at(offset) or (None, offset, offset)
    return server.range(path, start, stop)


def _rename(server: Session, parameters: lsp.RenameParams) -> lsp.WorkspaceEdit | None:
    found = server.at(parameters)
    if found is None:
        return None
    _, view, offset = found
    renaming = navigation.rename(view, server.views(view), offset, parameters.new_name)
    changes: dict[str, list[lsp.TextEdit]] = defaultdict(list)
    for place in renaming.places:
        where = server.location(place)
        changes[where.uri].append(lsp.TextEdit(where.range, renaming.text))
    return lsp.WorkspaceEdit(changes=dict(changes))


def _fixes(server: Session, parameters: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    """Return the edits that hints propose for findings at a place."""
    path, place = server.path(parameters.text_document.uri), parameters.range
    only = parameters.context.only
    if only is not None and not any(_QUICK_FIX.startswith(kind) for kind in only):
        return []
    found = fixes_at(
        path, place.start.line, place.end.line, server.checked.values(), server.documents
    )
    return [server.action(fix) for fix in found]


def _symbols(server: Session, parameters: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    found = server.look(parameters.text_document.uri)
    return (
        _shown_symbols(server, found[0], navigation.outline(found[1].structure))
        if found
        else []
    )


def _shown_symbols(
    server: Session, path: Path, parts: Iterable[navigation.Outlined]
) -> list[lsp.DocumentSymbol]:
    return [
        lsp.DocumentSymbol(
            part.name,
            _SYMBOL_KINDS.get(part.kind, _SYMBOL.Module),
            server.range(path, part.start, part.stop),
            server.range(path, part.at, part.end),
            detail=part.kind,
            children=_shown_symbols(server, path, part.inner),
        )
        for part in parts
    ]


def _workspace_symbols(
    server: Session, parameters: lsp.WorkspaceSymbolParams
) -> list[lsp.WorkspaceSymbol]:
    found = names_in(server.folders(), server.documents, parameters.query)
    return [
        lsp.WorkspaceSymbol(
            server.location(navigation.Place(one.path, one.part.at, one.part.end)),
            one.part.name,
            _SYMBOL_KINDS.get(one.part.kind, _SYMBOL.Module),
            container_name=one.within or one.path.name,
        )
        for one in found
    ]


def _signatures(
    server: Session, parameters: lsp.SignatureHelpParams
) -> lsp.SignatureHelp | None:
    found = server.at(parameters)
    said = signature(found[1], found[2]) if found else None
    if said is None:
        return None
    about = lsp.MarkupContent(lsp.MarkupKind.Markdown, said.about) if said.about else None
    forms = [
        lsp.SignatureInformation(
            form.text, about, [lsp.ParameterInformation(place) for place in form.places]
        )
        for form in said.forms
    ]
    return lsp.SignatureHelp(forms, said.active, said.place)


def _folds(server: Session, parameters: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
    found = server.look(parameters.text_document.uri)
    if found is None:
        return []
    path, view = found
    places = (server.range(path, fold.start, fold.stop) for fold in navigation.folds(view))
    # The line of the closing brace stays.
    return [
        lsp.FoldingRange(place.start.line, place.end.line - 1)
        for place in places
        if place.end.line > place.start.line
    ]


def _format(
    server: Session, parameters: lsp.DocumentFormattingParams
) -> list[lsp.TextEdit] | None:
    path = server.path(parameters.text_document.uri)
    raw = server.documents.raw(path)
    new = formatted(raw)
    if new is None or new == raw:
        return None if new is None else []
    lines = server.positions(path).lines
    whole = lsp.Range(lsp.Position(0, 0), lsp.Position(len(lines), 0))
    return [lsp.TextEdit(whole, new)]


def _coloured(server: Session, parameters: lsp.SemanticTokensParams) -> lsp.SemanticTokens:
    found = server.look(parameters.text_document.uri)
    if found is None:
        return lsp.SemanticTokens([])
    path, view = found
    positions, data = server.positions(path), list[int]()
    line = column = 0
    for start, stop, kind in tokens_of(view.structure, server.known_words):
        at, end = positions.position(start), positions.position(stop)
        data += (
            at.line - line,
            at.character - (column if at.line == line else 0),
            end.character - at.character,
            KINDS.index(kind),
            0,
        )
        line, column = at
    return lsp.SemanticTokens(data)


_ANSWERS: dict[str, Callable[[Session, Any], Any]] = {
    lsp.INITIALIZE: _initialised,
    lsp.TEXT_DOCUMENT_DID_OPEN: _opened,
    lsp.TEXT_DOCUMENT_DID_CHANGE: _changed,
    lsp.TEXT_DOCUMENT_DID_SAVE: _saved,
    lsp.TEXT_DOCUMENT_DID_CLOSE: _closed,
    lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES: _saved,
    lsp.TEXT_DOCUMENT_HOVER: _hover,
    lsp.TEXT_DOCUMENT_COMPLETION: _completion,
    lsp.TEXT_DOCUMENT_DEFINITION: _definition,
    lsp.TEXT_DOCUMENT_REFERENCES: _references,
    lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: _highlights,
    lsp.TEXT_DOCUMENT_PREPARE_RENAME: _can_rename,
    lsp.TEXT_DOCUMENT_RENAME: _rename,
    lsp.TEXT_DOCUMENT_CODE_ACTION: _fixes,
    lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: _symbols,
    lsp.TEXT_DOCUMENT_FOLDING_RANGE: _folds,
    lsp.TEXT_DOCUMENT_SIGNATURE_HELP: _signatures,
    lsp.WORKSPACE_SYMBOL: _workspace_symbols,
    lsp.TEXT_DOCUMENT_FORMATTING: _format,
    lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: _coloured,
}
_OPTIONS: dict[str, Any] = {
    lsp.TEXT_DOCUMENT_COMPLETION: lsp.CompletionOptions(
        trigger_characters=['"', "/", " ", "("]
    ),
    lsp.TEXT_DOCUMENT_SIGNATURE_HELP: lsp.SignatureHelpOptions(
        trigger_characters=[" ", "(", ","]
    ),
    lsp.TEXT_DOCUMENT_CODE_ACTION: lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix]),
    lsp.TEXT_DOCUMENT_RENAME: lsp.RenameOptions(prepare_provider=True),
    lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: lsp.SemanticTokensLegend(
        [_TOKEN_TYPES[kind] for kind in KINDS], []
    ),
}
