"""Values of options that several words make up."""

import re
from collections.abc import Callable, Iterable
from math import isfinite
from typing import Any, cast

import click

from tissuec.core.units import TIME, parse_unit


class OptionReader(click.ParamType):  # pyright: ignore[reportMissingTypeArgument]  # generic in newer click only
    """A value that a function reads from a text; its ValueError describes the error."""

    def __init__(self, read: Callable[[str], Any]):
        self.read, self.name = read, "text"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """Return the value of an option.

        Args:
            param: The parameter.
            ctx: Context of click.
        """
        try:
            return self.read(value) if isinstance(value, str) else value
        except ValueError as error:
            self.fail(str(error), param, ctx)


class LateChoice(click.Choice):  # pyright: ignore[reportMissingTypeArgument]  # generic in newer click only
    """One of some words that are found when the option is used or explained."""

    def __init__(self, find: Callable[[], Iterable[str]]):
        self._find, self.case_sensitive = find, True

    @property
    def choices(self) -> tuple[str, ...]:  # pyright: ignore[reportIncompatibleVariableOverride]  # found late
        """Return the words."""
        return tuple(self._find())


class TimeArgument(click.ParamType):  # pyright: ignore[reportMissingTypeArgument]  # generic in newer click only
    """A time, in seconds or with its unit."""

    name = "time"

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Return the time [s].

        Args:
            value: The text, or a time.
            param: The parameter.
            ctx: Context of click.
        """
        if isinstance(value, float):
            return value
        try:
            return seconds(value)
        except ValueError:
            self.fail(f'"{value}" is not a time; write 0.5 or "20 ms"', param, ctx)


def seconds(text: str) -> float:
    """Return the time that is written, in seconds or with a unit [s].

    Raises:
        ValueError: It is none.
    """
    found = re.fullmatch(r"\s*([-+]?[\d.]+(?:e[-+]?\d+)?)\s*(\S*)\s*", text, re.IGNORECASE)
    if found is None:
        raise ValueError(text)
    unit = parse_unit(found[2] or "s")  # an error of units is one of values
    time = float(found[1]) * unit.factor
    if unit.dimension != TIME or not isfinite(time):
        raise ValueError(text)
    return time


class Pair(click.ParamType):  # pyright: ignore[reportMissingTypeArgument]  # generic in newer click only
    """Two numbers with a sign between."""

    def __init__(self, between: str, example: str, low: float, high: float):
        self.between, self.example, self.low, self.high = between, example, low, high
        self.name = example

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, float]:
        """Return both numbers.

        Args:
            value: The text, or both numbers.
            param: The parameter.
            ctx: Context of click.
        """
        if isinstance(value, tuple):
            given = cast("tuple[float, float]", value)
            return given
        try:
            first, second = map(float, value.lower().split(self.between))
        except ValueError:
            self.fail(f'"{value}" does not have the form {self.example}', param, ctx)
        if not all(self.low <= number <= self.high for number in (first, second)):
            limits = f"{self.low:g} and {self.high:g}"
            self.fail(f'both numbers of "{value}" must be between {limits}', param, ctx)
        return first, second
