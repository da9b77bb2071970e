"""Results that are computed once: kept in memory, or in the user's cache of what takes long.

``functools.lru_cache`` would hold whole nets that nobody else needs any more.

What the cache of a user keeps is run as code. So it is read only if nobody but this user can
have written it: that is tested on the open file, as the meaning of a name may change in
between.
"""

import os
import stat
from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import suppress
from functools import cache, wraps
from hashlib import sha256
from pathlib import Path
from threading import Lock, RLock
from typing import Any, Concatenate, ParamSpec, TypeVar

from tissuec.core.files import replacing

Owner = TypeVar("Owner")
P = ParamSpec("P")
Result = TypeVar("Result")
_lock = Lock()


def kept_on_owner(
    most: int,
) -> Callable[
    [Callable[Concatenate[Owner, P], Result]], Callable[Concatenate[Owner, P], Result]
]:
    """Keep results of a function on its first argument, so that they go along with it.

    Args:
        most: How many results one owner keeps, the latest ones. It has a ``__dict__``, and the
            other arguments of the function can be hashed.
    """

    def decorate(
        function: Callable[Concatenate[Owner, P], Result],
    ) -> Callable[Concatenate[Owner, P], Result]:
        name = f"{function.__module__}.{function.__qualname__}"

        @wraps(function)
        def recall(owner: Owner, *rest: P.args, **named: P.kwargs) -> Result:
            results: dict[Any, Result] = vars(owner).setdefault(name, {})
            return _recalled(results, rest, lambda: function(owner, *rest, **named), most)

        return recall

    return decorate


def _recalled(
    results: dict[Any, Result], key: Hashable, compute: Callable[[], Result], most: int
) -> Result:
    """Return a result that is there, or compute and add it; threads may do so at once."""
    with _lock:
        if key in results:
            return results[key]
    result = compute()
    with _lock:
        while len(results) >= most:
            del results[next(iter(results))]
        results[key] = result
    return result


T = TypeVar("T")


class Memory:
    """Results by their keys; the least recently used one is dropped first. Thread-safe."""

    def __init__(self, most: int):
        self.most = most
        self._found: OrderedDict[Hashable, Any] = OrderedDict()
        self._lock = RLock()

    def get(self, key: Hashable) -> Any:
        """Return the result of a key; None if there is none."""
        with self._lock:
            if key not in self._found:
                return None
            self._found.move_to_end(key)
            return self._found[key]

    def keep(self, key: Hashable, made: object) -> None:
        """Store a result, and drop the least recently used ones above the limit."""
        with self._lock:
            self._found[key] = made
            self._found.move_to_end(key)
            while len(self._found) > self.most:
                self._found.popitem(last=False)

    def recall(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return the result of a key, computed now if it is not stored."""
        with self._lock:
            if key in self._found:
                return self.get(key)
        made = make()
        self.keep(key, made)
        return made


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
