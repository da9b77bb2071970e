"""Prior expectations about parameters."""

from msgspec import Struct


class Prior(Struct, frozen=True, eq=False):
    """Prior of one parameter: its place, its value, and its standard deviation."""

    place: int
    value: float
    spread: float
