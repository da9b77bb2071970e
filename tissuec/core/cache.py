"""The user's cache of what takes long to make: machine code, and parse tables.

What is kept there is run as code. So it is read only if nobody but this user can have written
it: that is tested on the open file, as the meaning of a name may change in between.
"""

import os
import stat
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path

from tissuec.core.files import replacing

MOST = 500  # files in one folder; then those go that were not used for the longest time
_DIGEST = 32  # bytes before what is kept, lest a damaged file is run


@cache
def cache_folder() -> Path | None:
    """Return a folder that only this user can write to, or None."""
    import tempfile  # late, like the others: most commands make nothing

    from platformdirs import user_cache_path

    own = user_cache_path("tissuec", appauthor=False)
    user = getattr(os, "getuid", lambda: "user")()
    for folder in (own, Path(tempfile.gettempdir()) / f"tissuec-cache-{user}"):
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if _is_ours(folder.lstat()):
                with tempfile.TemporaryFile(dir=folder):
                    return folder
        except OSError:
            continue
    return None


def recalled(name: str, make: Callable[[], bytes]) -> bytes:
    """Return the value kept under a name; it is made if it is missing or damaged.

    Args:
        name: Path below the folder, with a digest of all that the content depends on.
        make: Returns the content.
    """
    folder = cache_folder()
    path = None if folder is None else folder / name
    content = None if path is None else _read(path)
    if content is None:
        content = make()
        if path is not None:
            with suppress(OSError):  # it is made again next time
                path.parent.mkdir(mode=0o700, exist_ok=True)
                with replacing(path, private=True) as beside:
                    beside.write_bytes(sha256(content).digest() + content)
                _thin(path.parent)
    return content


def _read(path: Path) -> bytes | None:
    """Return the content of a file of this user's own; None if there is none."""
    flags = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        with open(path, "rb", opener=lambda name, usual: os.open(name, usual | flags)) as file:
            status = os.fstat(file.fileno())
            is_ours = stat.S_ISREG(status.st_mode) and _is_ours(status)
            stored = file.read() if is_ours else b""
    except OSError:
        return None
    digest, content = stored[:_DIGEST], stored[_DIGEST:]
    return content if content and sha256(content).digest() == digest else None


def _is_ours(status: os.stat_result) -> bool:
    """Return whether a file or folder, and no link, can be written by this user alone."""
    if stat.S_ISLNK(status.st_mode):
        return False
    return not hasattr(os, "getuid") or (
        status.st_uid == os.getuid() and not status.st_mode & 0o022
    )


def _thin(folder: Path) -> None:
    """Remove what was not used for the longest time, once there is too much."""
    import shutil

    with os.scandir(folder) as found:
        entries = list(found)
    if len(entries) > MOST:
        used = {one.path: max(one.stat().st_atime, one.stat().st_mtime) for one in entries}
        for path in sorted(used, key=used.__getitem__)[: len(entries) - MOST // 2]:
            if os.path.isdir(path):
                shutil.rmtree(path, ignore_errors=True)
            else:
                with suppress(OSError):
                    os.unlink(path)
