"""Digests of the data that something was learnt from."""

from hashlib import file_digest
from pathlib import Path
from typing import Any

from tissuec.core.files import open_regular


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file in hexadecimal digits; it is read in blocks.

    Raises:
        OSError: It cannot be read, or is no regular file.
    """
    with open_regular(path) as file:
        readable: Any = file  # which is buffered
        return file_digest(readable, "sha256").hexdigest()
