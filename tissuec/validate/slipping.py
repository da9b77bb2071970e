"""When bristles of faces begin to slip, or stick again, within a step.

Between two changes each bristle either sticks, z' = u, or slips: it bears G and has the length
G/k. It begins to slip when it is as long as that. It sticks again when G/k grows faster than
the surface lengthens it, u·e < (G/k)'.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from tissuec.model.network import Floats
from tissuec.validate.equations import Equations

LOOKS = 8  # in a step
LATE = 1e-9  # part of the largest G/k by which bristles are longer when they begin to slip
SHARP = 1e-10  # part of a step to which a change is located


class SlipChange(NamedTuple):
    """The first change in a step.

    Attributes:
        time: When it happens [s].
        changed: Which bristles slip or stick from then on, shape (bristle,).
    """

    time: float
    changed: NDArray[np.bool_]


def first_change(
    equations: Equations, start: float, stop: float, near: Callable[[float], Floats]
) -> SlipChange | None:
    """Return the first change of a bristle in a step, if there is one.

    Args:
        equations: Of the stretch.
        start, stop: Of the step [s].
        near: Returns the unknowns at a time within [s], in SI units, shape (unknown,).
    """
    step, before = _SlipStep(equations, start, stop, near), start
    for time in np.linspace(start, stop, LOOKS + 1)[1:]:
        if step.excess(time).max() > 0.0:
            when = step.crossing(before, time)
            return SlipChange(when, step.excess(when) > 0.0)
        before = time
    return None


class _SlipStep:
    """A step in which bristles stick or slip; for arguments see ``first_change``."""

    def __init__(
        self, equations: Equations, start: float, stop: float, near: Callable[[float], Floats]
    ):
        assert equations.cut is not None, "otherwise nothing slips"
        self._equations, self._cut, self._near = equations, equations.cut, near
        self._start, self._stop, self._size = start, stop, stop - start

    def crossing(self, low: float, high: float) -> float:
        """Return a time just after the largest excess becomes positive [s]."""

        def largest(time: float) -> float:
            return float(self.excess(time).max())

        if largest(low) < 0.0:
            low = float(brentq(largest, low, high, xtol=SHARP * self._size))
        way = SHARP * self._size
        while low + way < high and largest(low + way) <= 0.0:
            way *= 2.0
        return min(low + way, high)

    def excess(self, time: float) -> Floats:
        """Return how far bristles are beyond a change [m], shape (bristle,)."""
        length, most, ahead = self._lengths(time)
        slides, late = self._cut.slides, LATE * most.max()
        excess: Floats = np.where(slides | (most == 0.0), 0.0, length - most) - late
        sticks: Floats = -ahead * self._size - late
        return np.where(slides & (ahead < 0.0), sticks, excess)

    def _lengths(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return lengths [m], those at which bristles slip [m] and their growth [m/s]."""
        moved, velocity = self._equations.spread(time, self._near(time))
        return self._cut.lengths(self._equations.drawn + moved, velocity)
