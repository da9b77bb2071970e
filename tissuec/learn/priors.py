"""What was expected of parameters before anything was measured."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What was expected of one parameter: its place, its value, and its standard deviation."""

    place: int
    value: float
    spread: float
