"""Playback speed of a run."""

from math import floor, log10

_SHORTEST, _LONGEST, _USUAL = 1.5, 12.0, 6.0  # [s] of showing


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
