"""Values as plain data, for JSON, and text as any terminal, page and encoding takes it."""

import re
from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any, cast

from msgspec import Struct
from msgspec.structs import asdict


def as_data(value: Any) -> Any:
    """Return a value, and all that it is made of, as JSON has it.

    Records become dictionaries, arrays lists, numbers that are not finite None, and what else
    JSON does not have, such as a path, text.
    """
    if isinstance(value, Struct):
        value = asdict(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        entries = cast("Mapping[Any, Any]", value)
        return {printable(str(key)): as_data(entry) for key, entry in entries.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [as_data(entry) for entry in cast("Iterable[Any]", value)]
    if isinstance(value, float):
        return value if isfinite(value) else None
    return value if value is None or isinstance(value, int) else printable(str(value))


ODD = "\ufffd"
#: Control characters but line break and tab, marks that turn the direction of writing, and
#: bytes of file names that are no UTF-8, which Python keeps as surrogates.
_ODD = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    """Return text with a sign in the place of what would disturb who shows it."""
    return _ODD.sub(ODD, text)
