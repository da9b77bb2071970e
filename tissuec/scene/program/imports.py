"""Files and their imports: the modules of a scene, used ones before their users."""

import os.path
import re
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Annotated, Self

from msgspec import Struct

from tissuec.core.data import printable
from tissuec.core.errors import CompileError, Diagnostic, Note
from tissuec.core.files import read_bytes
from tissuec.core.hints import Edit, Hint, nearby_file
from tissuec.core.source import Source, Span
from tissuec.lang import syntax as s
from tissuec.lang.characters import normalise
from tissuec.lang.parser import WrongNumbers
from tissuec.meshes.formats import IMAGES
from tissuec.scene.program.library import (
    LARGEST_FILE,
    LINK,
    LINKED,
    SUFFIX,
    Library,
    belongs_to_scenes,
    parsed,
)
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import declare
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import FilesClause


class UsedWords(VerbSentence, frozen=True):
    """The name of a file in quotes."""

    file: Annotated[str, FilesClause("", place='"FILE"')]


declare(
    "use",
    "Includes the definitions of another file: a vocabulary, tissues, or a whole "
    "scene.", 0, "text",
    sentences=(UsedWords,), example='use "fuzzy/soft_tissue"',
)  # fmt: skip
MOST_IN_A_ROW = 50  # files that use one another; nobody loses track of so many by hand
HDF5 = b"\x89HDF"  # how result files begin
MESHES = (".stl", ".obj", ".ply", ".vtk", ".vtu", ".msh", ".feb", *IMAGES)


class Program(Struct, frozen=True):
    """A scene's own module and everything it uses.

    Attributes:
        modules: Each module once, imported ones before those that use them, the scene last.
        library: Where the scene finds files to use.
    """

    modules: tuple[s.Module, ...]
    library: Library

    @property
    def main(self) -> s.Module:
        return self.modules[-1]

    @property
    def is_scene(self) -> bool:
        """Return whether there is a body, or something else that only scenes have."""
        return any(belongs_to_scenes(item) for module in self.modules for item in module.items)


def read_source(path: Path, name: str | None = None) -> Source:
    """Return the text of a file, normalised.

    Args:
        name: What a text calls the file; only regular files can be named there.

    Raises:
        CompileError: The file cannot be read, is far too large or is not text. Where there is
            none, the error names one like it.
    """
    is_named, name = name is not None, name or printable(str(path))
    try:
        data = read_bytes(path, LARGEST_FILE, regular=is_named)
        if hint := _of_another_kind(data, name):
            raise CompileError([Diagnostic("TIS604", f'"{name}" is not a scene', None, hint)])
        return normalise(data, name, path)
    except OSError as error:
        reason = error.strerror or type(error).__name__
        message = f'cannot read "{name}": {reason.lower()}'
        hint = "" if os.path.exists(path) else nearby_file(path, SUFFIX)
        raise CompileError([Diagnostic("TIS604", message, None, hint)]) from error


def _of_another_kind(data: bytes, name: str) -> str:
    """Return a remedy if a result or a mesh is given as a scene; empty for other files."""
    if data.startswith(HDF5):
        return f"it is a result file; to view it: tissuec view {name}"
    if name.lower().endswith(MESHES):
        return f"it is a mesh file; to create a scene from it: tissuec import {name}"
    return ""


class Files:
    """How the files that a text uses are found, read and parsed: from disk, each time.

    An editor puts texts that are not saved yet in their places.

    Attributes:
        kept: Texts by the names under which they were found once; where there are any, no file
            counts beside them.
    """

    kept: Mapping[str, str] | None = None

    def has(self, path: Path) -> bool:
        """Return whether there is such a file; a name that no system allows is none."""
        try:
            return path.is_file()
        except (OSError, ValueError):
            return False

    def read(self, path: Path, name: str) -> Source:
        """Return the text of a file as ``read_source`` does."""
        return read_source(path, name)

    def parse(self, source: Source) -> s.Module:
        """Return the syntax nodes of a text as ``parse`` does; shipped ones are parsed once."""
        return parsed(source)


DISK = Files()


class ParsedOnce(Files):
    """Files from disk for several readings of one text, which is parsed for the first only."""

    def __init__(self) -> None:
        self._modules: dict[tuple[str, str, Path | None], s.Module] = {}

    def __reduce__(self) -> tuple[type[Self], tuple[()]]:
        return type(self), ()  # another process parses what it needs

    def parse(self, source: Source) -> s.Module:
        key = source.name, source.text, source.path
        if key not in self._modules:
            self._modules[key] = super().parse(source)
        return self._modules[key]


class StoredTexts(Files):
    """The texts that a result keeps, so that a scene compiles without its files."""

    def __init__(self, texts: Mapping[str, str]):
        self.kept = self._texts = texts

    def read(self, path: Path, name: str) -> Source:
        return Source(name, self._texts[name], path)


def load(
    source: Source, libraries: Sequence[Path], findings: Findings, files: Files = DISK
) -> Program:
    """Return the module of a source with all its imports; findings go to ``findings``.

    Args:
        libraries: Folders in which ``use`` finds files.
        files: Where texts are read from.

    Raises:
        CompileError: The source itself cannot be parsed.
    """
    loader = _Loader(libraries, findings, files)
    loader.visit(source, chain=())
    if not loader.modules:
        findings.raise_errors()
    return Program(tuple(loader.modules), Library.of(source, libraries, files.kept))


_USE = re.compile(r'^[ \t]*use[ \t]+"([^"\n]+)"', re.MULTILINE)


class _Loader:
    """One walk over the imports."""

    def __init__(self, libraries: Sequence[Path], findings: Findings, files: Files):
        self.libraries = libraries
        self.findings = findings
        self.files = files
        self.modules: list[s.Module] = []
        self.seen: set[Path] = set()
        #: Names and texts: a library may be in two folders, and each finds its own copy.
        self.texts: set[tuple[str, str]] = set()

    def visit(self, source: Source, chain: tuple[Path, ...]) -> None:
        if source.path is not None:
            chain = (*chain, source.path.resolve())
            self.seen.add(chain[-1])
        module = self._parse(source)
        if module is None:
            self.findings.doubt_all()  # any name may be one that it declares
            return
        for item in module.items:
            if isinstance(item, s.Sentence) and item.name.words.lower() == "use":
                with self.findings.item():
                    self._follow(item, source, chain)
                    continue
                self.findings.doubt_all()  # likewise
        if (source.name, source.text) not in self.texts:
            self.texts.add((source.name, source.text))
            self.modules.append(module)

    def _parse(self, source: Source) -> s.Module | None:
        """Return the module of a source; None if more is wrong with it than numbers."""
        try:
            return self.files.parse(source)
        except WrongNumbers as error:
            self.findings.extend(error.diagnostics)
            return error.module
        except CompileError as error:
            self.findings.extend(error.diagnostics)
            return None

    def _follow(self, item: s.Sentence, source: Source, chain: tuple[Path, ...]) -> None:
        wanted = item.name.quoted
        if not wanted or item.clauses or item.phrase:
            self.findings.reject("TIS312", 'write: use "tissues/fallopian_tube"', item.span)
        parts = PurePosixPath(wanted).parts
        if (
            ".." in parts
            or PurePosixPath(wanted).is_absolute()
            or "\\" in wanted
            or ":" in wanted
        ):
            hint = 'use "./name" beside this file, or permit its folder with --library DIR'
            if "\\" in wanted and ":" not in wanted and ".." not in wanted:
                slashed = re.sub(r"\\+", "/", wanted).removeprefix("/")
                hint = Hint(f'write "{slashed}"', Edit(slashed, old=wanted))
            message = f'"{wanted}" is outside the permitted folders'
            self.findings.reject("TIS603", message, item.span, hint=hint)
        path, name = self._find(wanted, item, source)
        if path.resolve() in chain:
            self.findings.reject(
                "TIS602",
                f'"{wanted}" uses this file again: the imports form a circle',
                item.span,
            )
        if path.resolve() not in self.seen:
            if len(chain) > MOST_IN_A_ROW:
                self.findings.reject(
                    "TIS116",
                    f"more than {MOST_IN_A_ROW} files use one another in a row",
                    item.span,
                )
            self.visit(self._read(path, name), chain)

    def _used_beside(self, item: s.Sentence) -> list[str]:
        """Return the files that other sentences of the same text use."""
        text = item.span.source.text
        return [
            found[1]
            for found in _USE.finditer(text)
            if not item.span.start <= found.start() < item.span.end
        ]

    def _read(self, path: Path, name: str) -> Source:
        try:
            return self.files.read(path, name)
        except CompileError as error:
            self.findings.extend(error.diagnostics)
            self.findings.stop()

    def _find(self, wanted: str, item: s.Sentence, source: Source) -> tuple[Path, str]:
        file = wanted if wanted.endswith(SUFFIX) else wanted + SUFFIX
        name = str(PurePosixPath(file))
        if self.files.kept is not None:
            if name not in self.files.kept:
                self.findings.reject(
                    "TIS601", f'"{name}" is not stored in the result', item.span
                )
            return Path(name), name
        library = Library.of(source, self.libraries)
        places = library.places(wanted)
        hits = [place / file for place in places if self.files.has(place / file)]
        if not hits:
            searched = tuple(Note(f"searched {place / file}") for place in places)
            self.findings.reject(
                "TIS601",
                f'cannot find the file "{file}"',
                item.span,
                hint=library.near(wanted, self._used_beside(item)),
                notes=searched,
            )
        if library.leads_out(hits[0]):
            self.findings.reject("TIS603", LINK.format(wanted), item.span, hint=LINKED)
        others = {hit.resolve() for hit in hits[1:] if _differ(hit, hits[0])}
        if others:
            names = ", ".join(str(other) for other in sorted(others))
            self.findings.add("W601", f'"{hits[0]}" hides {names}', item.span)
        return hits[0], name


def _differ(path: Path, other: Path) -> bool:
    """Return whether two files hold different bytes; one that cannot be read may."""
    try:
        return read_bytes(path, LARGEST_FILE) != read_bytes(other, LARGEST_FILE)
    except OSError:
        return True


def whole(module: s.Module) -> Span:
    """Return the first line of a module, to point at where a thing is missing altogether."""
    return Span(module.source, 0, len(module.source.line_text(1)))
