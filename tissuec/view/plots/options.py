"""Options of plots: their form on the command line, and their meaning."""

import re
from collections.abc import Callable
from typing import Annotated, Any, get_args, get_type_hints

from msgspec import Struct

from tissuec.core.units import TIME, Dimension, UnitError, describe, parse_unit

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


class Option(Struct, frozen=True):
    """An option of a plot on the command line.

    Attributes:
        help: What it does.
        metavar: Placeholder of its value in help.
        read: Makes a value of a text, or raises ValueError with a sentence.
        spellings: If not the name of the field.
    """

    help: str
    metavar: str = ""
    read: Callable[[str], Any] = str
    spellings: tuple[str, ...] = ()


def reader(dimension: Dimension) -> Callable[[str], float]:
    """Return a reader of numbers in SI units, or with a unit such as "40 ms"."""

    def read(text: str) -> float:
        found, wrong = _QUANTITY.fullmatch(text), f'"{text}" is not {describe(dimension)}'
        if found is None:
            raise ValueError(wrong)
        if not found[2]:
            return float(found[1])
        try:
            unit = parse_unit(found[2])
        except UnitError:
            raise ValueError(wrong) from None
        if unit.dimension != dimension:
            raise ValueError(wrong)
        return float(found[1]) * unit.factor

    return read


def read_view(text: str) -> tuple[float, float]:
    """Read azimuth and elevation [deg].

    Raises:
        ValueError: The text is no direction.
    """
    try:
        azimuth, elevation = (float(part) for part in text.split(","))
    except ValueError:
        message = f'"{text}" is not a direction; write AZIMUTH,ELEVATION in degrees: -110,22'
        raise ValueError(message) from None
    if not (-90.0 <= elevation <= 90.0 and abs(azimuth) <= 360.0):
        raise ValueError(f'"{text}": the elevation must be between -90 and 90 degrees')
    return azimuth, elevation


read_time = reader(TIME)
Start = Annotated[float | None, Option("Begin at this time.", "TIME", read_time)]
Stop = Annotated[float | None, Option("End at this time.", "TIME", read_time)]
Direction = Annotated[
    tuple[float, float] | None,
    Option(
        "Direction of view in degrees: -90,0 is from the front, -90,90 from above.",
        "AZIMUTH,ELEVATION",
        read_view,
        ("--from",),
    ),
]


def options_of(member: type) -> dict[str, Option]:
    """Return the options of a plot by its fields."""
    hints = get_type_hints(member, include_extras=True)
    found: dict[str, Option] = {}
    for name, hint in hints.items():
        option = next((part for part in get_args(hint) if isinstance(part, Option)), None)
        if option is not None:
            found[name] = option
    return found
