"""Open texts of an editor, which replace those on disk, and cached facts about each.

What was found out about a text is kept until the text, or one that it uses, has changed.
"""

from collections.abc import Hashable
from pathlib import Path

from tissuec.core.errors import CompileError
from tissuec.core.keeping import Memory
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.known_statements import KnownStatements
from tissuec.lang.parser import WrongNumbers, parse_tree, readable_part
from tissuec.lang.tree import Tree
from tissuec.lang.tree_builder import tree_of
from tissuec.scene.program.imports import Files, read_source

MOST_KEPT, MOST_NETS = 128, 4096


class OpenDocuments(Files):
    """Files as an editor shows them.

    Attributes:
        libraries: Folders to search for what texts use, beside their own.
        memory: What was found out about texts.
        nets: What was found out about bodies, of which one text has many.
        statements: Statements of all texts so far.
    """

    def __init__(self, libraries: tuple[Path, ...] = ()):
        self.libraries = libraries
        self.memory = Memory(MOST_KEPT)
        self.nets = Memory(MOST_NETS)
        self.statements = KnownStatements()
        self._open: dict[Path, tuple[Path, str]] = {}  # by what links lead to
        self._sources: dict[tuple[Path, str], tuple[Hashable, Source]] = {}

    # --- what is open -------------------------------------------------------------------------

    def put(self, path: Path, text: str) -> None:
        """Open a text, or change it."""
        self._open[_real(path)] = path, text

    def take_away(self, path: Path) -> None:
        """Close a text; the file on disk counts again."""
        self._open.pop(_real(path), None)

    def opened(self) -> list[Path]:
        """Return the texts that are open, as they were named."""
        return [path for path, _ in self._open.values()]

    def is_open(self, path: Path) -> bool:
        """Return whether a file is open in the editor."""
        return _real(path) in self._open

    def _shown(self, path: Path) -> str | None:
        found = self._open.get(_real(path))
        return found[1] if found else None

    def raw(self, path: Path) -> str:
        """Return a text as the editor or the disk has it; empty where there is none."""
        shown = self._shown(path)
        if shown is not None:
            return shown
        try:
            return path.read_bytes().decode("utf-8", errors="replace")
        except OSError:
            return ""

    # --- Files --------------------------------------------------------------------------------

    def has(self, path: Path) -> bool:
        return self.is_open(path) or super().has(path)

    def read(self, path: Path, name: str) -> Source:
        shown = self._shown(path)
        state = shown if shown is not None else _state(path)
        known = self._sources.get((path, name))
        if known is not None and known[0] == state:
            return known[1]
        source = read_source(path, name) if shown is None else normalise(shown, name, path)
        self._sources[path, name] = state, source
        return source

    def tree(self, source: Source) -> Tree:
        """Return the tree of a text."""
        return self.memory.recall(("tree", source), lambda: tree_of(source))

    def parse(self, source: Source) -> s.Module:
        tree = self.tree(source)
        result = self.memory.recall(("parsed", source), lambda: self._parsed(tree))
        if isinstance(result, CompileError):
            raise result
        return result

    def _parsed(self, tree: Tree) -> s.Module | CompileError:
        try:
            return parse_tree(tree, known=self.statements)
        except CompileError as error:
            return error


class Lenient(Files):
    """The same files, in which texts that are wrong count as far as they can be read."""

    def __init__(self, documents: OpenDocuments):
        self.documents = documents

    def has(self, path: Path) -> bool:
        return self.documents.has(path)

    def read(self, path: Path, name: str) -> Source:
        return self.documents.read(path, name)

    def parse(self, source: Source) -> s.Module:
        try:
            return self.documents.parse(source)
        except WrongNumbers as error:
            return error.module
        except CompileError:
            tree = self.documents.tree(source)
            known = self.documents.statements
            return self.documents.memory.recall(
                ("mended", source), lambda: readable_part(tree, known)
            )


def _state(path: Path) -> Hashable:
    """Return a value that changes whenever the file on disk changes."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def _real(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, ValueError, RuntimeError):
        return path
