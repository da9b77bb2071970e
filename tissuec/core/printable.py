"""Text as any terminal, page and encoding takes it."""

import re

ODD = "\ufffd"
#: Control characters but line break and tab, marks that turn the direction of writing, and
#: bytes of file names that are no UTF-8, which Python keeps as surrogates.
_ODD = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    """Return text with a sign in the place of what would disturb who shows it."""
    return _ODD.sub(ODD, text)
