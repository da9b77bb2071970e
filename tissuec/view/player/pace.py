"""Playback speed of a run, and units of time."""

from math import floor, log10

_SHORTEST, _LONGEST, _USUAL = 1.5, 12.0, 6.0  # [s] of showing

#: Unit prefixes that people use, from small to large.
PREFIXES = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"))

_VOLUMES = ((1e-9, "µl"), (1e-6, "ml"), (1e-3, "l"))


def pace(duration: float) -> float:
    """Return how much simulated time passes in a second of showing.

    1 where that takes neither too long nor too little, otherwise the nearest of 1, 2, 5, 10, …
    """
    if _SHORTEST <= duration <= _LONGEST or not duration > 0.0:
        return 1.0
    return near(duration / _USUAL)


def near(value: float) -> float:
    """Return the nearest of …, 0.5, 1, 2, 5, 10, … to a number above zero."""
    power = 10.0 ** floor(log10(value))
    steps = (1.0, 2.0, 5.0, 10.0)
    return float(f"{min(steps, key=lambda step: abs(log10(step * power / value))) * power:.0e}")


def scaled(most: float, unit: str) -> tuple[float, str]:
    """Return by what to divide numbers up to ``most``, and the unit that they are then in."""
    if unit == "m^3":
        fitting = [pair for pair in _VOLUMES if pair[0] <= abs(most) * (1.0 + 1e-9)]
        return fitting[-1] if fitting else _VOLUMES[0] if most else (1.0, unit)
    if unit not in ("m", "s", "N", "J", "Pa", "W", "m/s"):
        return 1.0, unit
    fitting = [(size, name) for size, name in PREFIXES if size <= abs(most) * (1.0 + 1e-9)]
    if unit == "s":
        fitting = [pair for pair in fitting if pair[0] <= 1.0]
    size, name = fitting[-1] if fitting and most else (1.0, "") if not most else PREFIXES[0]
    return size, f"{name}{unit}"
