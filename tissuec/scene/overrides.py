"""Values of params that are given from Python, as the texts that ``--set`` takes."""

from collections.abc import Mapping, Sequence
from math import isfinite
from numbers import Real
from typing import TypeAlias

import numpy as np

from tissuec.core.names import key_of
from tissuec.core.units import NUMBER, Dimension, written_unit
from tissuec.scene.parameters import Parameter

#: A text as in a scene, such as "0.9 s"; or one number or three, in SI units.
Given: TypeAlias = "str | float | Sequence[float]"


def overrides(given: Mapping[str, Given], known: Sequence[Parameter]) -> tuple[str, ...]:
    """Return assignments such as "cut time = 0.9 s".

    Args:
        given: Values by name; an underscore may stand for a blank.
        known: The params of the scene. A name that is none of them is passed on, so that the
            scene says so.

    Raises:
        ValueError: A value is no text, number or vector, or one name is given twice.
    """
    by_key = {parameter.item.name.key: parameter for parameter in known}
    found: dict[str, str] = {}
    for name, value in given.items():
        key = key_of(name)
        if key not in by_key:
            key = key_of(name.replace("_", " "))
        if key in found:
            raise ValueError(f'"{key}" is given twice')
        found[key] = _assignment(key, value, by_key.get(key))
    return tuple(found.values())


def _assignment(key: str, value: Given, parameter: Parameter | None) -> str:
    if parameter is None:
        return f"{key} = {_text(value, key, NUMBER)}"
    name = parameter.item.name
    shown = f'"{name.text}"' if name.quoted is not None else name.text
    return f"{shown} = {_text(value, name.text, parameter.value.dimension)}"


def _text(value: Given, name: str, dimension: Dimension) -> str:
    """Return a value as a scene has it."""
    if isinstance(value, str):
        return value
    if not isinstance(value, bool) and isinstance(value, Real):
        numbers, form = [float(value)], "{}"
    else:
        numbers, form = _vector(value, name), "({}, {}, {})"
    if not all(map(isfinite, numbers)):
        raise ValueError(f"{name} = {value} is not a usable number")
    unit = written_unit(dimension)
    if any(exponent != int(exponent) for exponent in dimension):
        raise ValueError(
            f"the unit of {name} cannot be written as a product of powers; write it as text"
        )
    written = [repr(number).removesuffix(".0") for number in numbers]
    return f"{form.format(*written)} {unit}".rstrip()


def _vector(value: object, name: str) -> list[float]:
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (3,) or isinstance(value, bool):
        raise ValueError(
            f'{name} = {value!r} is not a text such as "0.9 s", a number or a vector'
        )
    return numbers.tolist()
