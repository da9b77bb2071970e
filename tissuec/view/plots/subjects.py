"""Subjects of plots, read from files: results, words, tables, and JSON of benches."""

import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Literal, cast

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.results.places import SUFFIX as RESULT
from tissuec.scene.program.library import SUFFIX as SCENE
from tissuec.scene.program.library import find_words
from tissuec.scene.program.metadata import TEXTS
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.studies.table import StudyTable
from tissuec.studies.table_files import is_table, read_table

Kind = Literal["result", "words", "table", "bench", "stress", "laboratory"]
#: What the kinds are called in messages.
CALLED: dict[str, str] = {
    "result": f"a result ({RESULT})",
    "words": f"a vocabulary or scene ({SCENE})",
    "table": "the table of a study (.csv, .h5)",
    "bench": 'the JSON of "tissuec bench"',
    "stress": 'the JSON of "python -m benchmarks.stability"',
    "laboratory": 'the JSON of "tissuec lab"',
}


class PlotSubject(Struct, frozen=True, eq=False):
    """A subject of a plot.

    Attributes:
        name: What it is called in legends.
        content: A `Trajectory`, `ResolvedProgram`, `StudyTable`, or what a bench found, as its
            JSON has it.
    """

    kind: Kind
    name: str
    content: Any


def credits_of(subject: PlotSubject) -> dict[str, str]:
    """Return the title and the metadata of a result or a scene; see ``formats``."""
    if subject.kind == "result":
        manifest: dict[str, Any] = subject.content.manifest
        texts = {word: str(manifest[word]) for word in TEXTS if manifest.get(word)}
    elif subject.kind == "words":
        texts = subject.content.declarations.metadata.written
    else:
        return {}
    return {"title": subject.name, **texts}


@contextmanager
def opened(
    given: Sequence[Any],
    *,
    overrides: Sequence[str] = (),
    libraries: Sequence[Path] = (),
    strict: bool = False,
) -> Generator[list[PlotSubject]]:
    """Yield the subjects of files, or of what has been read from them already.

    Results that are opened here are closed at the end of the block.

    Args:
        given: Names of files, or results.
        overrides: The arguments of ``--set``.
        libraries: Folders of ``--library``.
        strict: Whether warnings count as errors.

    Raises:
        TissueError: There is no such file, or nothing in it that can be plotted.
        CompileError: A text is wrong.
    """
    options = {"overrides": overrides, "libraries": libraries, "strict": strict}
    with ExitStack() as stack:
        subjects = [_subject(one, stack, options) for one in given]
        yield _told_apart(subjects, given)


def _subject(given: Any, stack: ExitStack, options: Mapping[str, Any]) -> PlotSubject:
    if isinstance(given, ResolvedProgram):
        return PlotSubject("words", "words", given)
    if isinstance(given, Mapping):
        return _benched(given, "bench")
    if isinstance(given, StudyTable):
        return PlotSubject("table", given.head.name, given)
    if not isinstance(given, str | Path):
        from tissuec.results.trajectory import Trajectory

        if isinstance(given, Trajectory):
            return PlotSubject("result", given.path.stem, given)
        raise ValueError(f"{type(given).__name__} cannot be plotted")
    path = Path(given)
    if path.suffix == ".json":
        return _benched(_read_json(path), path.stem, path)
    if is_table(path):
        return PlotSubject("table", path.stem, read_table(path))
    if path.suffix == SCENE or (not path.is_file() and path.suffix != RESULT):
        return _words(str(given), options)
    from tissuec.results.trajectory import Trajectory

    return PlotSubject("result", path.stem, stack.enter_context(Trajectory.open(path)))


def _words(name: str, options: Mapping[str, Any]) -> PlotSubject:
    from tissuec.core.errors import CompileError
    from tissuec.pipeline import read_words
    from tissuec.scene.request import Request

    path = find_words(name, options["libraries"])
    words, warnings = read_words(Request.file(path, **options))
    if options["strict"] and warnings:
        raise CompileError(warnings)
    return PlotSubject("words", path.stem, words)


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise TissueError(f'cannot read "{path}": {reason}') from error
    except ValueError as error:
        raise TissueError(f'"{path}" is not JSON: {error}') from error


def _benched(document: Any, name: str, path: Path | None = None) -> PlotSubject:
    if isinstance(document, Mapping):
        known = cast("Mapping[str, Any]", document)
        if "points" in known and "reference" in known:
            return PlotSubject("bench", _scene(known) or name, known)
        if "verdicts" in known and "methods" in known:
            return PlotSubject("stress", name, known)
        if "tissues" in known and all("curves" in one for one in known["tissues"]):
            return PlotSubject("laboratory", name, known)
        if known.get("ok") is False and "error" in known:
            raise TissueError(f'"{path or name}" contains an error: {known["error"]}')
    raise TissueError(
        f'"{path or name}" contains nothing to plot; plots accept the JSON of '
        '"tissuec bench SCENE --json", "tissuec lab FILE --json" or '
        '"python -m benchmarks.stability --json"'
    )


def _scene(document: Mapping[str, Any]) -> str:
    return Path(str(document.get("scene", ""))).name


def _told_apart(subjects: list[PlotSubject], given: Sequence[Any]) -> list[PlotSubject]:
    """Return subjects with names of their own: where two are alike, the whole path."""
    names = [subject.name for subject in subjects]
    return [
        PlotSubject(one.kind, str(said), one.content)
        if names.count(one.name) > 1 and isinstance(said, str | Path)
        else one
        for one, said in zip(subjects, given, strict=True)
    ]
