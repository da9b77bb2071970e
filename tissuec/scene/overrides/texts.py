"""Values of params and entries that are given from Python, as texts that ``--set`` takes."""

import re
from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from tissuec.core import arguments
from tissuec.core.names import key_of
from tissuec.core.units import NUMBER, Dimension, written_unit
from tissuec.scene.program.parameters import Parameter

#: A text as in a scene, such as "0.9 s"; one number or three, in SI units; or such with a unit
#: of pint, which has the type Any.
Given: TypeAlias = "str | float | Sequence[float]"
_HEAD = re.compile(r".*?\s(=|is)\s")  # of an assignment
#: Words, which an entry takes after "is".
WORDS = re.compile(r"\s*[^\W\d][\w\s\"'-]*")


def overrides(given: Mapping[str, Given], known: Sequence[Parameter]) -> tuple[str, ...]:
    """Return texts such as "cut time = 0.9 s", or "hardness of fallopian tube is soft".

    Args:
        given: Values by name; an underscore may replace a blank.
        known: The params of the scene. A name that is none of them is that of an entry.

    Raises:
        TypeError: A name is no text.
        ValueError: A value is no text, number or vector, or one name is given twice.
    """
    by_key = {parameter.item.name.key: parameter for parameter in known}
    found: dict[str, str] = {}
    for name, value in given.items():
        key = key_of(arguments.text(name, "the name of a param"))
        if key not in by_key:
            key = key_of(name.replace("_", " "))
        if key in found:
            raise ValueError(f'"{key}" is given twice')
        found[key] = _assignment(key, value, by_key.get(key))
    return tuple(found.values())


def listed(
    given: "Mapping[str, Given | Iterable[Given]]", known: Sequence[Parameter]
) -> dict[str, str]:
    """Return the values of factors of a study as texts: a text as it is, others as a list.

    Args:
        given: Values by name: a text, or texts and numbers in SI units.
        known: The params of the scene.

    Raises:
        ValueError: A value is no text, number or vector.
    """
    found: dict[str, str] = {}
    for name, values in given.items():
        if isinstance(values, str):
            found[name] = values
            continue
        each = values if isinstance(values, Iterable) else [values]
        texts = [overrides({name: one}, known)[0] for one in each]
        heads = [_HEAD.match(text) for text in texts]
        listing = ", ".join(
            text[head.end() :] for text, head in zip(texts, heads, strict=True) if head
        )
        found[name.replace("_", " ")] = f"[{listing}]"
    return found


def _assignment(key: str, value: Given, parameter: Parameter | None) -> str:
    if parameter is None:
        verb = "is" if isinstance(value, str) and WORDS.fullmatch(value) else "="
        return f"{key} {verb} {_text(value, key, NUMBER)}"
    name = parameter.item.name
    shown = f'"{name.text}"' if name.quoted is not None else name.text
    return f"{shown} = {_text(value, name.text, parameter.value.dimension)}"


def _text(value: Given, name: str, dimension: Dimension) -> str:
    """Return a value as a scene has it."""
    if hasattr(value, "to_base_units"):
        return _with_own_unit(value, name)
    text = without_unit(value, name)
    if isinstance(value, str):
        return text
    if any(exponent != int(exponent) for exponent in dimension):
        raise ValueError(
            f"the unit of {name} cannot be written as a product of powers; write it as text"
        )
    return f"{text} {written_unit(dimension)}".rstrip()


def _with_own_unit(quantity: Any, name: str) -> str:
    """Return a quantity of pint as a scene has it; that its unit fits is checked there."""
    base = quantity.to_base_units()
    unit = f"{base.units:~C}".replace("**", "^")
    return f"{without_unit(base.magnitude, name)} {unit}".rstrip()


def without_unit(value: Given, name: str) -> str:
    """Return a value as a scene has it, numbers without their unit.

    Args:
        value: A text as it is; or one number or three, in SI units.
        name: What messages call it.

    Raises:
        ValueError: It is no text, number or vector.
    """
    if isinstance(value, str):
        return value
    if not isinstance(value, bool) and isinstance(value, Real):
        numbers, form = [value], "{}"
    else:
        numbers, form = _vector(value, name), "({}, {}, {})"
    numbers = [arguments.number(each, name) for each in numbers]
    return form.format(*(repr(number).removesuffix(".0") for number in numbers))


def _vector(value: object, name: str) -> list[float]:
    try:
        numbers = np.asarray(value, dtype=float)
    except OverflowError:  # a whole number of hundreds of digits
        raise ValueError(f"{name} is too large for a floating-point number") from None
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (3,) or isinstance(value, bool):
        raise ValueError(
            f'{name} = {value!r} is not a text such as "0.9 s", a number or a vector'
        )
    return numbers.tolist()
