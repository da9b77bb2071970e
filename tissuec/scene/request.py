"""Requests to compile a scene: its text, and what was given with it."""

from collections.abc import Sequence
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
