"""Values as plain data, for JSON."""

from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any, cast

from msgspec import Struct
from msgspec.structs import asdict

from tissuec.core.printable import printable


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
