"""Scenes read again with other texts in place of some of their files."""

from collections.abc import Mapping
from pathlib import Path

from tissuec.core.errors import Diagnostic
from tissuec.core.source import Source
from tissuec.pipeline import check_request
from tissuec.scene.model import Scene
from tissuec.scene.program.imports import DISK, Files, StoredTexts, load
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request
from tissuec.scene.resolve import resolve


class Replaced(Files):
    """Files of which some have other texts than on disk, by the names that messages print."""

    def __init__(self, texts: Mapping[str, str], others: Files = DISK):
        self._texts = texts
        self._others = others

    def read(self, path: Path, name: str) -> Source:
        if name in self._texts:
            return Source(name, self._texts[name], path)
        return self._others.read(path, name)


def request_of(scene: Scene, texts: Mapping[str, str]) -> Request:
    """Return the request that compiles a scene with new texts of some of its files."""
    source, library = scene.source, scene.declarations.library
    main = Source(source.name, texts.get(source.name, source.text), source.path)
    kept = library.kept
    files = Replaced(texts) if kept is None else StoredTexts({**kept, **texts})
    # The first and last folders are there for every text.
    return Request(main, scene.overrides, library.folders[1:-1], files=files)


def reread(scene: Scene, texts: Mapping[str, str]) -> Scene:
    """Return a scene with new texts of some of its files.

    Raises:
        CompileError: It is none any more.
    """
    findings = Findings()
    request = request_of(scene, texts)
    program = load(request.source, request.libraries, findings, request.files)
    again = resolve(program, findings, request.overrides)
    findings.raise_errors()
    return again


def warnings_of(scene: Scene, texts: Mapping[str, str]) -> tuple[Diagnostic, ...]:
    """Return the warnings of ``check`` about a scene with new texts.

    Raises:
        CompileError: It finds an error.
    """
    return check_request(request_of(scene, texts), thorough=False, levels=False)[1]
