"""Structs with other values in some of their fields."""

from typing import Any, TypeVar

from msgspec import Struct, structs

_Struct = TypeVar("_Struct", bound=Struct)


def replace(struct: _Struct, **changes: Any) -> _Struct:
    """Return a struct with other values in some fields, and without results that are kept.

    ``msgspec.structs.replace`` copies what ``cached_property`` and ``keeping.kept_on_owner``
    have stored, although it may follow from the fields that change.
    """
    found = structs.replace(struct, **changes)  # noqa: TID251
    if kept := getattr(found, "__dict__", None):
        kept.clear()
    return found
