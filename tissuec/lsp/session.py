"""One editor's session: its texts, its findings, and names in the files of its folder."""

import asyncio
import logging
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from msgspec import Struct
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.keeping import Memory
from tissuec.core.source import Span
from tissuec.core.version import __version__
from tissuec.lang.known_statements import MOST_STATEMENTS
from tissuec.lsp import navigation
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import Checked, QuickFix, address_of, check
from tissuec.lsp.navigation import Outlined, outline
from tissuec.lsp.positions import Positions
from tissuec.lsp.views import View, view_of
from tissuec.scene.program.library import LARGEST_FILE, SUFFIX
from tissuec.scene.reading.findings import Findings

#: Seconds without a keystroke before a text is checked, and then checked more closely.
PAUSE, LONG_PAUSE = 0.05, 0.5

_log = logging.getLogger(__name__)

_SEVERITY = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
}


class _Outdated(Exception):
    """The text has changed since its check began."""


class Session(LanguageServer):
    """One editor's session."""

    def __init__(self, libraries: tuple[Path, ...] = ()):
        super().__init__(  # pyright: ignore[reportUnknownMemberType]  # keywords of pygls
            "tissuec", __version__, text_document_sync_kind=lsp.TextDocumentSyncKind.Incremental
        )
        self.documents = OpenDocuments(libraries)
        self.checked: dict[Path, Checked] = {}
        self.found: dict[Path, dict[str, list[lsp.Diagnostic]]] = {}
        self.waiting: dict[Path, asyncio.Task[None]] = {}
        self.versions: dict[Path, int] = {}
        self.early: set[Path] = set()  # texts of which errors of names are shown
        self.uris: dict[Path, str] = {}
        self.shown: set[str] = set()
        self.known_words = Memory(MOST_STATEMENTS)
        # Two threads, so that a keystroke does not wait for a text that is checked closely.
        self.pool = ThreadPoolExecutor(2, "check")

    # --- texts and places ---------------------------------------------------------------------

    def path(self, uri: str) -> Path:
        """Return the path of a text; one that was never saved gets a name of its own."""
        found = to_fs_path(uri) if uri.startswith("file:") else None
        path = Path(found) if found else Path(uri.replace(":", "-").replace("/", "-"))
        self.uris.setdefault(path, uri)
        return path

    def uri(self, path: Path) -> str:
        """Return the address of a file, as the editor spelt it."""
        return self.uris.get(path) or from_fs_path(str(path.resolve())) or ""

    def positions(self, path: Path) -> Positions:
        """Return how offsets of a text become positions of the protocol."""
        raw = self.documents.raw(path)
        return self.documents.memory.recall(
            ("positions", raw, self.encoding), lambda: Positions(raw, self.encoding)
        )

    @property
    def encoding(self) -> str:
        """Return the name of what the editor counts characters in."""
        return lsp.PositionEncodingKind(self.workspace.position_encoding or "utf-16").value

    def folders(self) -> list[Path]:
        """Return the folders that are open in the editor."""
        uris = list(self.workspace.folders) or [self.workspace.root_uri or ""]
        return [Path(found) for uri in uris if (found := to_fs_path(uri))]

    def range(self, path: Path, start: int, stop: int) -> lsp.Range:
        """Return a part of a text as a range of the protocol.

        Args:
            start: Offset of the first character.
            stop: Offset of the end.
        """
        positions = self.positions(path)
        return lsp.Range(
            lsp.Position(*positions.position(start)), lsp.Position(*positions.position(stop))
        )

    def location(self, place: navigation.Place) -> lsp.Location:
        """Return a place as a location of the protocol."""
        return lsp.Location(
            self.uri(place.path), self.range(place.path, place.start, place.stop)
        )

    def look(self, uri: str) -> tuple[Path, View] | None:
        """Return the view of a text; None where it is no text."""
        path = self.path(uri)
        view = view_of(self.documents, path)
        return (path, view) if view else None

    def at(self, parameters: Any) -> tuple[Path, View, int] | None:
        """Return the view of a text and the offset that a request is about."""
        found = self.look(parameters.text_document.uri)
        if found is None:
            return None
        place = parameters.position
        return *found, self.positions(found[0]).offset(place.line, place.character)

    def views(self, view: View) -> list[View]:
        """Return the views in which a name may occur: of imports, and of open texts."""
        opened = (view_of(self.documents, path) for path in self.documents.opened())
        every = [*navigation.around(view), *(other for other in opened if other is not None)]
        return list({id(one): one for one in every}.values())

    # --- diagnostics --------------------------------------------------------------------------

    def changed(self, path: Path, *, everything: bool = False) -> None:
        """Check a text soon, and those open ones that use it; or all that are open."""
        for other in self.documents.opened():
            if everything or other == path or self._uses(other, path):
                self.versions[other] = self.versions.get(other, 0) + 1
                if other in self.waiting:
                    self.waiting[other].cancel()
                self.waiting[other] = asyncio.get_running_loop().create_task(self._later(other))

    def _uses(self, path: Path, used: Path) -> bool:
        view = view_of(self.documents, path)
        if view is None or view.program is None:
            return True
        paths = (module.source.path for module in view.program.modules)
        return any(one is not None and one.resolve() == used.resolve() for one in paths)

    async def _later(self, path: Path) -> None:
        """Check a text after a pause, and more closely after a longer one."""
        loop, version = asyncio.get_running_loop(), self.versions[path]

        def resolved(findings: Findings) -> None:
            if self.versions[path] != version:
                raise _Outdated
            errors, warnings = tuple(findings.errors), tuple(findings.warnings)
            loop.call_soon_threadsafe(self._tell_early, path, version, errors, warnings)

        for pause, thorough in ((PAUSE, False), (LONG_PAUSE, True)):
            await asyncio.sleep(pause)
            found = await loop.run_in_executor(self.pool, self._check, path, thorough, resolved)
            if found is None:
                return
            # Had the text changed meanwhile, this would have been cancelled.
            self.checked[path] = found
            self.found[path] = self._by_file(path, found.diagnostics)
            self.publish()
            if found.is_thorough:
                return

    def _tell_early(
        self,
        path: Path,
        version: int,
        errors: tuple[Diagnostic, ...],
        warnings: tuple[Diagnostic, ...],
    ) -> None:
        """Send errors of names, or that there are none any longer, before nets are drawn."""
        if self.versions[path] != version or not (errors or path in self.early):
            return
        if errors:
            self.early.add(path)
        else:
            self.early.discard(path)
        self.found[path] = self._by_file(path, errors or warnings)
        self.publish()

    def _check(
        self, path: Path, thorough: bool, resolved: Callable[[Findings], None]
    ) -> Checked | None:
        try:
            return check(self.documents, path, thorough=thorough, resolved=resolved)
        except _Outdated:
            return None
        except Exception:  # a fault of the compiler must not end the session
            _log.exception("checking %s failed", path)
            return None

    def _by_file(
        self, path: Path, diagnostics: Iterable[Diagnostic]
    ) -> dict[str, list[lsp.Diagnostic]]:
        """Return the diagnostics of a text, grouped by the file they are in."""
        found: dict[str, list[lsp.Diagnostic]] = {self.uri(path): []}
        for one in diagnostics:
            where = (one.span.source.path if one.span else path) or path
            found.setdefault(self.uri(where), []).append(self._shown(one, where))
        return found

    def publish(self) -> None:
        """Send the findings in each file to the editor, whichever text uses it."""
        every: dict[str, list[lsp.Diagnostic]] = {uri: [] for uri in self.shown}
        for found in self.found.values():
            for uri, diagnostics in found.items():
                known = every.setdefault(uri, [])
                known += (one for one in diagnostics if one not in known)
        for uri, diagnostics in every.items():
            self.text_document_publish_diagnostics(
                lsp.PublishDiagnosticsParams(uri, diagnostics)
            )
        self.shown = {uri for uri, diagnostics in every.items() if diagnostics}

    def _shown(self, one: Diagnostic, path: Path) -> lsp.Diagnostic:
        """Return a finding as the protocol has it."""
        extra = [f"hint: {one.hint}"] if one.hint else []
        extra += (f"note: {note.message}" for note in one.remarks if note.span is None)
        address = address_of(one.code)
        start, stop = (one.span.start, one.span.end) if one.span else (0, 0)
        return lsp.Diagnostic(
            self.range(path, start, stop),
            "\n".join((one.message, *extra)),
            _SEVERITY[one.severity],
            one.code,
            lsp.CodeDescription(address) if address else None,
            "tissuec",
            related_information=self._related(one),
        )

    def action(self, fix: QuickFix) -> lsp.CodeAction:
        """Return a quick fix as the protocol has it."""
        where = fix.finding.span
        assert where is not None and where.source.path is not None
        place = self.range(fix.path, fix.place.start, fix.place.end)
        return lsp.CodeAction(
            fix.title,
            lsp.CodeActionKind.QuickFix,
            [self._shown(fix.finding, where.source.path)],
            is_preferred=fix.is_preferred,
            edit=lsp.WorkspaceEdit({self.uri(fix.path): [lsp.TextEdit(place, fix.text)]}),
        )

    def _related(self, one: Diagnostic) -> list[lsp.DiagnosticRelatedInformation]:
        return [
            lsp.DiagnosticRelatedInformation(location, note.message)
            for note in one.notes
            if note.span is not None and (location := self._location_of(note.span)) is not None
        ]

    def _location_of(self, span: Span) -> lsp.Location | None:
        path = span.source.path
        return (
            lsp.Location(self.uri(path), self.range(path, span.start, span.end))
            if path
            else None
        )


#: Number of files of a folder that are read at most, and of names that are returned.
MOST_FILES, MOST_NAMES = 2000, 1000
#: Kinds of names that other parts of a text use.
_KINDS = frozenset({
    "param", "let", "function", "set", "body", "joint", "tool", "force", "tissue", "property",
    "quantity", "rules", "law", "hedge", "region", "study", "learn",
})  # fmt: skip


class FoundName(Struct, frozen=True):
    """A declared name.

    Attributes:
        path: The file.
        part: The declaration.
        within: The body of a region; empty for others.
    """

    path: Path
    part: Outlined
    within: str = ""


def names_in(
    folders: Iterable[Path], documents: OpenDocuments, query: str
) -> Iterator[FoundName]:
    """Yield names that contain the letters of a query in their order, in any case.

    Args:
        folders: Folders with files.
        documents: Open texts, which count in place of files.
        query: What is looked for; empty for all names.
    """
    wanted, many = query.casefold().replace(" ", ""), 0
    paths = [path for folder in folders for path in _files(folder)]
    for path in dict.fromkeys((*documents.opened(), *paths)):
        for found in _declared(path, documents):
            if _has(found.part.name.casefold(), wanted):
                many += 1
                yield found
                if many == MOST_NAMES:
                    return


def _files(folder: Path) -> Iterator[Path]:
    """Yield the scenes in a folder and in those inside, but for hidden ones."""
    many = 0
    for place, inner, names in os.walk(folder):
        inner[:] = sorted(name for name in inner if name[0] != "." and name != "node_modules")
        for name in sorted(names):
            path = Path(place, name)
            if path.suffix == SUFFIX:
                many += 1
                yield path
                if many == MOST_FILES:
                    return


def _declared(path: Path, documents: OpenDocuments) -> Iterator[FoundName]:
    try:
        if not documents.is_open(path) and path.stat().st_size > LARGEST_FILE:
            return
        source = documents.read(path, str(path))
    except (CompileError, OSError):
        return
    for part in outline(documents.tree(source)):
        if part.kind in _KINDS:
            yield FoundName(path, part)
        for inner in part.inner:
            if inner.kind in _KINDS:
                yield FoundName(path, inner, part.name)


def _has(name: str, letters: str) -> bool:
    """Return whether a name contains letters in their order."""
    place = 0
    for letter in letters:
        place = name.find(letter, place) + 1
        if not place:
            return False
    return True
