"""The page of all messages, as a file that an editor can open at a code."""

import re
from functools import cache
from hashlib import sha256
from pathlib import Path

from tissuec.core.cache import cache_folder
from tissuec.core.catalogue import reference
from tissuec.core.files import write_file

_HEAD = re.compile(r"^## (\w+):", re.MULTILINE)


@cache
def _page() -> tuple[Path | None, dict[str, int]]:
    """Return where the page is, and the line of each code from 1."""
    text, folder = reference(), cache_folder()
    lines = {found[1]: text.count("\n", 0, found.start()) + 1 for found in _HEAD.finditer(text)}
    if folder is None:
        return None, lines
    path = folder / f"messages-{sha256(text.encode()).hexdigest()[:16]}.md"
    try:
        if not path.exists():
            write_file(path, text)
    except OSError:
        return None, lines
    return path, lines


def address_of(code: str) -> str | None:
    """Return the address of the documentation of a code."""
    path, lines = _page()
    return f"{path.as_uri()}#L{lines[code]}" if path is not None and code in lines else None
