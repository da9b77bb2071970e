"""Colours of numbers, and lines in dashes."""

import numpy as np

from tissuec.core.arrays import counted_up
from tissuec.model.network import Floats, Indices
from tissuec.view.player.rules import RULES

_MOST_DASHES = 24  # of a line


def rgb(text: str) -> Floats:
    """Return red, green and blue of ``#rrggbb``, dimensionless, from 0 to 1, shape (3,)."""
    return np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0


def ramp(colours: tuple[str, ...], value: Floats) -> Floats:
    """Return colours of dimensionless numbers from -1 to 1, shape (number, 3)."""
    table = np.array([rgb(text) for text in colours])
    place = np.linspace(-1.0, 1.0, len(table))
    return np.stack([np.interp(value, place, table[:, k]) for k in range(3)], axis=1)


def dashed(ends: Floats, dashes: Floats) -> tuple[Indices, Floats]:
    """Return lines cut into dashes.

    Args:
        ends: In any unit, shape (line, 2, 3).
        dashes: How many of them fit on each line; 0 for one that stays whole, shape (line,).

    Returns:
        The line of each dash, shape (dash,), and its ends, shape (dash, 2, 3).
    """
    count = np.clip(np.ceil(dashes), 1, _MOST_DASHES).astype(int)
    which = np.repeat(np.arange(len(ends)), count)
    size = np.where(dashes > 0.0, 1.0 / count, 1.0)[which]
    start = counted_up(count) * size
    stop = start + np.where(dashes > 0.0, RULES.inked, 1.0)[which] * size
    way = ends[which, 1] - ends[which, 0]
    places = (ends[which, 0] + part[:, None] * way for part in (start, stop))
    return which, np.stack(list(places), axis=1)
