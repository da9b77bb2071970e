"""Knots: places of a scale that move without meeting or passing one another.

Corners of words at one place are one knot, so that shared corners stay shared and sharp edges
stay sharp. The ends of the range, corners outside of it, and those of frozen words stay where
they are; between two knots that stay, m knots part the way into m + 1 gaps

    g_j = f g0_j + (1 - f) R s_j,    s_j = g0_j e^(l_j) / Σ_i g0_i e^(l_i),
    l_j = -Σ_(k<=j) θ_k,

of the expert's widths g0_j and their sum R. A gap keeps at least the part f of its width. At
θ = 0 it has all of it, and a positive θ_k moves knot k up: by its exponential, the gaps below
grow relative to those above.
"""

from bisect import bisect_right
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from tissuec.fuzzy.axis import Axis
from tissuec.fuzzy.duals import Slopes
from tissuec.model.network import Floats

FLOOR = 0.1
"""Part of its width that every gap keeps."""

_NEGLIGIBLE = 1e-9  # of the range; corners closer than this are at one place


class Knots:
    """The places of all corners of a scale, and the numbers by which they move.

    Attributes:
        places: Where the expert has them, ascending, in the coordinate of the axis.
        movable: Indices of the knots that move, one number each, ascending.
    """

    def __init__(self, axis: Axis, corners: Iterable[float], fixed: Iterable[float] = ()):
        low, high = axis.bounds
        fixed = set(fixed)
        self._near = _NEGLIGIBLE * (high - low)
        places: list[float] = []
        stays: list[bool] = []
        last = low
        for x in sorted({low, high, *corners, *fixed}):
            is_fixed = not low < x < high or x in fixed
            if places and x - last <= self._near:
                stays[-1] |= is_fixed
            else:
                places.append(x)
                stays.append(is_fixed)
            last = x
        self.places = tuple(places)
        self.movable = tuple(i for i, stay in enumerate(stays) if not stay)
        self._anchors = [i for i, stay in enumerate(stays) if stay]

    @property
    def size(self) -> int:
        return len(self.movable)

    def index(self, place: float) -> int:
        """Return the knot at a place where the expert has a corner."""
        return bisect_right(self.places, place + self._near) - 1

    def moves(self, theta: Floats) -> tuple[Floats, Slopes]:
        """Return how far each knot moves, and the derivatives of that.

        Args:
            theta: Dimensionless, shape (number,), one for each movable knot; any numbers.

        Returns:
            Shapes (knot,) and (knot, number), in the coordinate of the axis. At zero nothing
            moves at all, not even by rounding.
        """
        moves, slopes = np.zeros(len(self.places)), np.zeros((len(self.places), self.size))
        first = 0
        for start, end in pairwise(self._anchors):
            count = end - start - 1
            if count:
                mine, inner = slice(first, first + count), slice(start + 1, end)
                gaps = np.diff(self.places[start : end + 1])
                moves[inner], slopes[inner, mine] = _parted(gaps, theta[mine])
                first += count
        return moves, slopes


def _parted(gaps: Floats, theta: Floats) -> tuple[Floats, Slopes]:
    """Return how far the knots between two that stay move, and the derivatives of that.

    Args:
        gaps: The expert's widths, shape (knot + 1,).
        theta: Shape (knot,).
    """
    logs = np.concatenate(([0.0], -np.cumsum(theta)))
    grown = gaps * np.exp(logs - logs.max())
    parts, whole = grown / grown.sum(), (1.0 - FLOOR) * gaps.sum()
    moves = whole * np.cumsum(parts - gaps / gaps.sum())[:-1]
    # Number k lowers the logarithms of gaps k and above: d s_j = s_j ([k > j] - Σ_(i<k) s_i).
    below = np.cumsum(parts)[:-1]
    order = np.arange(len(gaps))
    slopes = parts[:, None] * ((order[:, None] <= order[:-1]) - below)
    return moves, whole * np.cumsum(slopes, axis=0)[:-1]
