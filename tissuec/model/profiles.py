"""Time profiles: the factor of a load or a prescribed motion over time.

A profile is a plain record of numbers, so that kernels, the reference and the file can all hold
it; the value before ``start`` is that at ``start``, after ``stop`` that at ``stop``.
"""

from collections.abc import Sequence
from typing import Literal, overload

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.arrays import distinct
from tissuec.core.structs import replace

Floats = NDArray[np.float64]
ProfileKind = Literal["constant", "ramp", "smooth", "sine", "table"]

POWERS = 6  # coefficients of the quintic, the highest polynomial among the profiles


def _empty() -> Floats:
    return np.zeros(0)


class TimeProfile(Struct, frozen=True, eq=False):
    """A scalar function of time.

    With p = (t - start) / (stop - start), clipped to 0…1:
    ``constant`` is 1; ``ramp`` is p; ``smooth`` is 10 p³ - 15 p⁴ + 6 p⁵, whose velocity and
    acceleration vanish at both ends (minimum jerk: Flash & Hogan 1985); ``sine`` is
    sin(2π f (t - start)); ``table`` is a cubic Hermite interpolant through ``values`` at
    ``start + times`` with the given ``slopes``.

    Attributes:
        start: Time at which the profile begins [s].
        stop: Time at which it ends [s]; may be infinite for constant and sine.
        frequency: Of the sine [Hz].
        times: Knots of the table after the start [s], shape (knot,), ascending from 0.
        values: Factors at the knots, shape (knot,).
        slopes: Their rates [1/s], shape (knot,).
    """

    kind: ProfileKind
    start: float
    stop: float
    frequency: float = 0.0
    times: Floats = field(default_factory=_empty)
    values: Floats = field(default_factory=_empty)
    slopes: Floats = field(default_factory=_empty)

    @overload
    def at(self, time: float) -> tuple[float, float]: ...

    @overload
    def at(self, time: Floats | float) -> tuple[Floats | float, Floats | float]: ...

    def at(self, time: Floats | float) -> tuple[Floats | float, Floats | float]:
        """Return the factor, dimensionless, and its rate [1/s] at each time.

        Args:
            time: A number or an array of any shape [s]; the results have the same shape.
        """
        if not isinstance(time, np.ndarray):
            return self._at(time)
        found = np.array([self._at(t) for t in time.ravel().tolist()]).reshape(-1, 2)
        return found[:, 0].reshape(time.shape), found[:, 1].reshape(time.shape)

    def _at(self, time: float) -> tuple[float, float]:
        since = min(max(time, self.start), self.stop) - self.start
        moving = self.start <= time <= self.stop
        match self.kind:
            case "constant":
                return 1.0, 0.0
            case "sine":
                angle = 2.0 * np.pi * self.frequency
                rate = angle * np.cos(angle * since) if moving else 0.0
                return float(np.sin(angle * since)), float(rate)
            case "table":
                value, rate = _hermite(self.times, self.values, self.slopes, since)
                return value, rate if moving else 0.0
            case "ramp":
                length = self.stop - self.start
                return since / length, 1.0 / length if moving else 0.0
            case "smooth":
                length = self.stop - self.start
                p = since / length
                value = p * p * p * (10.0 + p * (6.0 * p - 15.0))
                return value, 30.0 * p * p * (1.0 - p) ** 2 / length

    @property
    def extremes(self) -> tuple[float, float]:
        """Return the largest amounts of the factor, dimensionless, and of its rate [1/s].

        Those of a table are of its knots, and of the straight lines between them.
        """
        match self.kind:
            case "constant":
                return 1.0, 0.0
            case "sine":
                return 1.0, 2.0 * np.pi * self.frequency
            case "table":
                rates = np.diff(self.values) / np.diff(self.times)
                return float(np.abs(self.values).max()), float(np.abs(rates).max(initial=0.0))
            case "ramp":
                return 1.0, 1.0 / (self.stop - self.start)
            case "smooth":
                return 1.0, 1.875 / (self.stop - self.start)

    def curve(self, start: float, until: float) -> tuple[float, Floats, float]:
        """Return the one curve that this is in a stretch of time without knots inside.

        Returns:
            Origin of its time u [s], coefficients of the powers of u, shape (6,), and the
            angular frequency of a sine of u [1/s], 0 without one.
        """
        power = np.zeros(POWERS)
        middle = start + 0.5 * (until - start)
        if self.kind == "constant" or not self.start < middle < self.stop:
            power[0] = self.at(middle)[0]
            return start, power, 0.0
        if self.kind == "sine":
            return self.start, power, 2.0 * np.pi * self.frequency
        if self.kind == "table":
            return self._piece(middle, power)
        length = self.stop - self.start
        if self.kind == "ramp":
            power[1] = 1.0 / length
        else:
            power[3:] = np.array([10.0, -15.0, 6.0]) / length ** np.arange(3.0, 6.0)
        return self.start, power, 0.0

    def _piece(self, middle: float, power: Floats) -> tuple[float, Floats, float]:
        """Return the cubic of a table around a time."""
        times = self.times
        if not self.start + times[0] < middle < self.start + times[-1]:
            power[0] = self.at(middle)[0]
            return middle, power, 0.0
        i = int(np.searchsorted(times, middle - self.start, side="right")) - 1
        h = times[i + 1] - times[i]
        a, b = self.values[i], self.values[i + 1]
        ma, mb = self.slopes[i], self.slopes[i + 1]
        power[0], power[1] = a, ma
        power[2] = (3.0 * (b - a) / h - 2.0 * ma - mb) / h
        power[3] = (2.0 * (a - b) / h + ma + mb) / (h * h)
        return self.start + times[i], power, 0.0

    def begin(self, at: float, *, until: float = np.inf) -> "TimeProfile":
        """Return this profile, written to begin at 0 s, as it is when it begins ``at`` a time.

        Args:
            at: Where it begins [s].
            until: Where it is broken off, should it last so long [s].
        """
        return replace(self, start=self.start + at, stop=min(self.stop + at, until))

    @property
    def knots(self) -> Floats:
        """Return the times at which a derivative jumps, where steps should end [s].

        The shape is (knot,).
        """
        ends = [t for t in (self.start, self.stop) if np.isfinite(t)]
        inner = self.start + self.times
        return distinct(np.concatenate([ends, inner[inner <= self.stop]]))


def tabulated(profiles: Sequence[TimeProfile], start: float, until: float) -> dict[str, Floats]:
    """Return the curves of profiles in an interval, with the names of ``BoundaryConditions``.

    Args:
        start: Start of the interval [s].
        until: End of the interval [s].

    Returns:
        ``origin`` [s], ``amplitude`` (dimensionless) and ``angular`` [1/s], each of shape
        (curve,), and the coefficients ``power`` [1/s^n], shape (curve, power).
    """
    curves = [profile.curve(start, until) for profile in profiles]
    angular = np.array([angular for _, _, angular in curves], dtype=float)
    return {
        "origin": np.array([origin for origin, _, _ in curves], dtype=float),
        "power": np.array([power for _, power, _ in curves]).reshape(-1, POWERS),
        "amplitude": np.where(angular != 0.0, 1.0, 0.0),
        "angular": angular,
    }


def _hermite(times: Floats, values: Floats, slopes: Floats, t: float) -> tuple[float, float]:
    """Return a piecewise cubic and its derivative at ``t``, constant outside the knots."""
    i = int(np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2))
    h = times[i + 1] - times[i]
    p = min(max((t - times[i]) / h, 0.0), 1.0)
    a, b, ma, mb = values[i], values[i + 1], slopes[i] * h, slopes[i + 1] * h
    c2, c3 = 3.0 * (b - a) - 2.0 * ma - mb, 2.0 * (a - b) + ma + mb
    return float(a + p * (ma + p * (c2 + p * c3))), float(
        (ma + p * (2.0 * c2 + 3.0 * p * c3)) / h
    )
