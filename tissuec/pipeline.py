"""The whole of tissuec on one page: text -> Module -> Scene -> Network and Plan -> Outcome.

Each stage is one function of immutable values, so that any of them can be shown or tested:

    source  = read_source(path)                the text
    program = load(source, libraries, …)       syntax nodes, imports included
    scene   = resolve(program, …)              names bound, SI numbers
    compiled = compile_scene(scene, …)         arrays and a plan
    outcome = run(compiled, …)                 motion, in one HDF5 file
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tissuec.checks import check_all
from tissuec.compiler import Compiled, compile_scene
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source
from tissuec.scene.findings import Findings
from tissuec.scene.imports import load, read_source
from tissuec.scene.model import Scene
from tissuec.scene.resolve import Words, resolve, resolve_words


@dataclass(frozen=True, slots=True)
class Request:
    """What a user asks to be compiled.

    Attributes:
        source: The text of the scene.
        overrides: Texts of ``--set``, such as "cut time=0.9 s".
        libraries: Folders of ``--library``.
        strict: Whether warnings count as errors.
    """

    source: Source
    overrides: tuple[str, ...] = ()
    libraries: tuple[Path, ...] = ()
    strict: bool = False

    @classmethod
    def file(
        cls, path: Path, *, overrides: Sequence[str] = (), libraries: Sequence[Path] = (), strict: bool = False
    ) -> "Request":
        """Return a request for a file; raises CompileError if it cannot be read."""
        return cls(read_source(path), tuple(overrides), tuple(libraries), strict)


def read_words(request: Request) -> tuple[Words, tuple[Diagnostic, ...]]:
    """Return vocabulary and tissues of a file that need not be a scene, and its warnings."""
    findings = Findings()
    program = load(request.source, request.libraries, findings)
    findings.raise_errors()
    words = resolve_words(program, findings, request.overrides)
    words.constants.evaluate_all()
    findings.raise_errors()
    return words, tuple(findings.warnings)


def read_scene(request: Request, findings: Findings) -> Scene:
    """Return the scene of a request, before any mesh is built."""
    program = load(request.source, request.libraries, findings)
    findings.raise_errors()
    return resolve(program, findings, request.overrides)


def compile_request(request: Request) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    """Return a scene in arrays and what there is to warn about.

    Raises:
        CompileError: The text is wrong, or ``strict`` and there is a warning.
    """
    findings = Findings()
    compiled = compile_scene(read_scene(request, findings), findings)
    warnings = (*findings.warnings, *check_all(compiled))
    if request.strict and warnings:
        raise CompileError(warnings)
    return compiled, warnings


def check_request(request: Request) -> tuple[Compiled | None, tuple[Diagnostic, ...]]:
    """Return like ``compile_request``; a file without bodies is checked as a vocabulary."""
    words, warnings = read_words(request)
    if not words.declarations.of("body") and not words.declarations.single:
        return None, warnings
    return compile_request(request)
