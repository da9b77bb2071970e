"""Records as plain data, for programs that read JSON."""

from typing import Any

from msgspec import Struct, to_builtins


def as_data(record: Struct) -> dict[str, Any]:
    """Return a record, and all that it is made of, as dictionaries, lists and plain numbers."""
    found: dict[str, Any] = to_builtins(record, enc_hook=lambda value: value.tolist())
    return found
