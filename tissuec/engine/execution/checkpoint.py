"""Values of a run as text and arrays, to store a run in a file and resume it.

Structs of this package and of plug-ins, tuples, lists, dictionaries, numbers, texts and arrays
are written out; what network and plan hold anyway (``known``) is only referred to. Numbers come
back to the last bit. Reading makes nothing but such values: a file cannot run anything.
"""

import json
from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Any, cast

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.plugins import packages

TEXT = "text"


def write_state(value: object, known: Iterable[object]) -> dict[str, str | NDArray[Any]]:
    """Return a value as one text and numbered arrays of any shape, in their own units.

    Args:
        value: Made of what the module names, at any depth.
        known: Objects that are referred to by their place in this sequence.

    Raises:
        TypeError: The value contains something else.
    """
    places = {id(item): place for place, item in enumerate(known)}
    arrays: list[NDArray[Any]] = []

    def plain(value: Any) -> Any:
        if id(value) in places:
            return {"known": places[id(value)]}
        match value:
            case None | bool() | str():
                return value
            case np.generic():
                number = cast("np.generic[Any]", value)
                return number.item()
            case int() | float():
                return value
            case np.ndarray():
                arrays.append(cast("NDArray[Any]", value))
                return {"array": len(arrays) - 1}
            case tuple():
                items = cast("tuple[Any, ...]", value)
                return {"tuple": [plain(item) for item in items]}
            case list():
                listed = cast("list[Any]", value)
                return [plain(item) for item in listed]
            case Mapping():
                named = cast("Mapping[Any, Any]", value)
                return {"pairs": [[plain(key), plain(item)] for key, item in named.items()]}
            case _:
                return _plain_record(value)

    def _plain_record(value: object) -> Any:
        kind = type(value)
        if not isinstance(value, Struct) or kind.__module__.partition(".")[0] not in packages():
            raise TypeError(f"a checkpoint cannot hold {kind.__module__}.{kind.__qualname__}")
        content = {name: plain(getattr(value, name)) for name in value.__struct_fields__}
        return {"record": f"{kind.__module__}:{kind.__qualname__}", "fields": content}

    text = json.dumps(plain(value))
    return {TEXT: text} | {f"array {number}": array for number, array in enumerate(arrays)}


def read_state(state: Mapping[str, Any], known: Iterable[object]) -> Any:
    """Return the value that :func:`write_state` was given, with the same ``known`` objects.

    Raises:
        ValueError: The text is not one that was written there.
    """
    places = list(known)

    def value(data: Any) -> Any:
        match data:
            case list():
                listed = cast("list[Any]", data)
                return [value(item) for item in listed]
            case {"known": place}:
                return places[place]
            case {"array": number}:
                return np.array(state[f"array {number}"])
            case {"tuple": items}:
                return tuple(value(item) for item in items)
            case {"pairs": pairs}:
                return {value(key): value(item) for key, item in pairs}
            case {"record": name, "fields": content}:
                return _record_class(name)(
                    **{key: value(item) for key, item in content.items()}
                )
            case dict():
                raise ValueError("this is not the checkpoint of a run")
            case _:
                return data

    return value(json.loads(state[TEXT]))


def _record_class(name: str) -> Any:
    """Return a class of this package, or of a plug-in, by ``module:name``."""
    module, _, qualified = name.partition(":")
    if module.partition(".")[0] not in packages():
        raise ValueError(f'"{name}" is not a record of tissuec or a plug-in')
    found = getattr(import_module(module), qualified, None)
    if not isinstance(found, type) or not issubclass(found, Struct):
        raise ValueError(f'"{name}" is not a record of tissuec or a plug-in')
    return found
