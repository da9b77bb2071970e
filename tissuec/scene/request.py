"""Requests to compile a scene: its text, and the values given with it."""

import shlex
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path

from msgspec import Struct

from tissuec.core.source import Source
from tissuec.scene.program.imports import DISK, Files, read_source


class Request(Struct, frozen=True):
    """A request to compile a scene.

    Attributes:
        source: The text of the scene.
        overrides: Texts of ``--set``, such as "cut time=0.9 s".
        libraries: Folders of ``--library``.
        strict: Whether warnings count as errors.
        files: How the files that the scene uses are read.
    """

    source: Source
    overrides: tuple[str, ...] = ()
    libraries: tuple[Path, ...] = ()
    strict: bool = False
    files: Files = DISK

    @classmethod
    def file(
        cls,
        path: Path,
        *,
        overrides: Sequence[str] = (),
        libraries: Sequence[Path] = (),
        strict: bool = False,
    ) -> "Request":
        """Return a request for a file.

        Args:
            path: The file.
            overrides: Texts of ``--set``.
            libraries: Folders of ``--library``.
            strict: Whether warnings count as errors.

        Raises:
            CompileError: The file cannot be read.
        """
        return cls(read_source(path), tuple(overrides), tuple(libraries), strict)


def run_command(
    scene: str | PathLike[str],
    options: Iterable[tuple[str, str | PathLike[str] | None]],
    *,
    resume: bool = False,
    strict: bool = False,
    blocks: bool = False,
) -> str:
    """Return the command line of a run; options without a value are left out.

    Args:
        options: Options with their values.
        resume: Whether ``--resume`` is given.
        strict: Whether ``--strict`` is given.
        blocks: Whether ``--blocks`` is given.
    """
    given = [str(word) for pair in options if pair[1] is not None for word in pair]
    head = ["tissuec", "run", str(scene), *(["--resume"] if resume else [])]
    flags = [
        name for name, is_given in (("--strict", strict), ("--blocks", blocks)) if is_given
    ]
    return shlex.join([*head, *given, *flags])


def set_options(
    overrides: Iterable[str], libraries: Iterable[str | PathLike[str]]
) -> list[tuple[str, str | PathLike[str] | None]]:
    """Return the settings of a scene, as options."""
    return [
        *(("--set", text) for text in overrides),
        *(("--library", place) for place in libraries),
    ]
