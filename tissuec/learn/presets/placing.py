"""Presets on disk: files of users are never overwritten, and writing is atomic."""

from collections.abc import Iterable
from pathlib import Path

from tissuec.core.errors import TissueError
from tissuec.core.files import write_file
from tissuec.learn.presets.marks import is_ours
from tissuec.learn.presets.preset import Preset


def refuse_others(paths: Iterable[Path]) -> None:
    """Check that only files of an earlier learning would be overwritten.

    Raises:
        TissueError: A file is there that was not written by learning.
    """
    for path in paths:
        if path.is_dir():
            raise TissueError(f'"{path}" is a folder; give the name of a file')
        if path.exists() and not is_ours(path):
            raise TissueError(
                f'"{path}" was not written by learning and would be overwritten; '
                "name another file with -o, or use --force"
            )


def place(preset: Preset, *, force: bool) -> list[Path]:
    """Write a preset with what lies beside it; returns the files, the preset first.

    Raises:
        TissueError: A file is there that was not written by learning, and not ``force``.
        OSError: The files cannot be written.
    """
    files = preset.files
    if not force:
        refuse_others(files)
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, text)
    return list(reversed(files))
