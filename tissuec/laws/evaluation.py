"""Force, stiffness and energy of springs with laws, spring by spring.

The energy is the integral of the force over the elongation, by Gauss's quadrature between the
kinks of a law (P. J. Davis, P. Rabinowitz, Methods of Numerical Integration, 1984).
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import distinct
from tissuec.laws import LINEAR, Law
from tissuec.laws.formula import Formula, Values, kinks

Floats = NDArray[np.float64]

POINTS = 48  # of Gauss's quadrature on each smooth piece
# A piece is halved where half the points differ by more than this part of ∫ |f| de: with all of
# them, errors of smooth functions are about the square of it.
DOUBT = 1e-8
MOST_HALVINGS = 14  # of a piece: then it has some 10 000 periods
HALVINGS = 60  # that locate a kink to rounding


class Behaviour:
    """The laws of some springs with their numbers.

    Args:
        laws: All laws of the net; the first is ``LINEAR``.
        law: Which one each spring has, shape (spring,).
        stiffness, damping, rest: c [N/m], d [N s/m] and L0 [m], shape (spring,); rest lengths
            may have leading axes.
    """

    def __init__(
        self,
        laws: Sequence[Law],
        law: NDArray[np.integer],
        stiffness: Floats,
        damping: Floats,
        rest: Floats,
    ):
        self.stiffness, self.damping, self.rest = stiffness, damping, rest
        # Called at every evaluation of a spring: most nets have no such laws.
        found: list[int] = distinct(law[law > 0]).tolist() if len(laws) > 1 else []
        self._curved = [(laws[k], np.flatnonzero(law == k)) for k in found]

    def with_rest(self, rest: Floats) -> "Behaviour":
        """Return the same with other rest lengths [m], shape (spring,)."""
        other = copy(self)
        other.rest = rest
        return other

    @property
    def is_linear(self) -> bool:
        """Return whether all springs and dashpots are linear."""
        return not self._curved

    @property
    def is_viscous(self) -> bool:
        """Return whether anything brakes."""
        return bool(self.damping.any()) or any(
            law.viscous != LINEAR.viscous for law, _ in self._curved
        )

    def pull(self, elongation: Floats) -> Floats:
        """Return the elastic forces at elongations [m], both of shape (…, spring) [N]."""
        return self._with(self.stiffness * elongation, {"e": elongation}, _elastic)

    def slope(self, elongation: Floats) -> Floats:
        """Return the stiffness df/de at elongations [m], shape (…, spring) [N/m]."""
        linear = np.broadcast_to(self.stiffness, elongation.shape).copy()
        return self._with(linear, {"e": elongation}, _elastic_slope)

    def brake(self, elongation: Floats, speed: Floats) -> Floats:
        """Return the viscous forces [N], shape (…, spring).

        Args:
            elongation, speed: e [m] and w [m/s], shape (…, spring).
        """
        return self._with(self.damping * speed, {"e": elongation, "w": speed}, _viscous)

    def brake_slope(self, elongation: Floats, speed: Floats) -> Floats:
        """Return the viscosity ∂g/∂w, shape (…, spring) [N s/m]; arguments as of ``brake``."""
        linear = np.broadcast_to(self.damping, speed.shape).copy()
        return self._with(linear, {"e": elongation, "w": speed}, _viscous_slope)

    def brake_by_e(self, elongation: Floats, speed: Floats) -> Floats:
        """Return ∂g/∂e, shape (…, spring) [N/m]; arguments as of ``brake``."""
        return self._with(np.zeros_like(speed), {"e": elongation, "w": speed}, _viscous_by_e)

    def steepness(self, elongation: Floats, speed: Floats | None = None) -> Floats:
        """Return the stiffness, or zero where it is negative or infinite [N/m].

        Estimates of rates use it.

        Args:
            elongation: L - L0 [m], shape (…, spring).
            speed: Rate of lengthening [m/s], shape (…, spring); None: at rest, without
                dashpots.
        """
        steep = self.slope(elongation)
        return _resisting(
            steep if speed is None else steep + self.brake_by_e(elongation, speed)
        )

    def sluggishness(self, elongation: Floats, speed: Floats) -> Floats:
        """Return the viscosity, or zero where it is negative or infinite [N s/m].

        Estimates of rates use it.

        Args:
            elongation: L - L0 [m], shape (…, spring).
            speed: Rate of lengthening [m/s], shape (…, spring).
        """
        return _resisting(self.brake_slope(elongation, speed))

    @property
    def has_corners(self) -> bool:
        """Return whether the force of any spring or dashpot is not smooth somewhere."""
        return any(
            kinks(law.elastic, "e") or kinks(law.viscous, "e", "w") for law, _ in self._curved
        )

    def energy(self, elongation: Floats) -> Floats:
        """Return the work ∫ f de from rest to elongations [m], shape (…, spring) [J]."""
        total = 0.5 * self.stiffness * elongation * elongation
        for law, chosen in self._curved:
            if law.elastic == LINEAR.elastic:
                continue
            values = self._values(chosen)
            total[..., chosen] = _integral(law.elastic, elongation[..., chosen], values)
        return total

    def _with(
        self, linear: Floats, at: Mapping[str, Floats], of: Callable[[Law], Formula]
    ) -> Floats:
        """Return values of linear springs with those of others put in their places.

        Too large values become infinite, which callers have to check.
        """
        with np.errstate(all="ignore"):
            for law, chosen in self._curved:
                values = self._values(chosen)
                values |= {name: each[..., chosen] for name, each in at.items()}
                linear[..., chosen] = of(law).at(values)
        return linear

    def _values(self, chosen: NDArray[np.intp]) -> dict[str, Floats]:
        return {
            "c": self.stiffness[chosen],
            "d": self.damping[chosen],
            "rest": self.rest[..., chosen],
        }


def _resisting(slope: Floats) -> Floats:
    return np.where(np.isfinite(slope), np.maximum(slope, 0.0), 0.0)


def _elastic(law: Law) -> Formula:
    return law.elastic


def _viscous(law: Law) -> Formula:
    return law.viscous


@cache
def _elastic_slope(law: Law) -> Formula:
    return law.elastic.slope("e")


@cache
def _viscous_slope(law: Law) -> Formula:
    return law.viscous.slope("w")


@cache
def _viscous_by_e(law: Law) -> Formula:
    return law.viscous.slope("e")


def _integral(force: Formula, upper: Floats, values: Values) -> Floats:
    """Return ∫ f de from 0 to ``upper``, to rounding where f is smooth between its kinks."""
    found = [_zero(test, upper, values) for test in kinks(force, "e")]
    ends = np.array([np.zeros_like(upper), *found, upper])
    ends = np.take_along_axis(ends, np.argsort(np.abs(ends), axis=0), axis=0)
    total = np.zeros_like(upper)
    with np.errstate(all="ignore"):
        for low, high in itertools.pairwise(ends):
            total += _piece(force, low, high, values, MOST_HALVINGS)
    return total


def _piece(force: Formula, low: Floats, high: Floats, values: Values, halvings: int) -> Floats:
    """Return ∫ f de from ``low`` to ``high``, halved where that is needed."""
    total, size = _gauss_sums(force, low, high, values, POINTS)
    coarse, _ = _gauss_sums(force, low, high, values, POINTS // 2)
    halved = np.abs(total - coarse) > DOUBT * size
    if halvings and halved.any():
        chosen = {k: np.broadcast_to(each, low.shape)[halved] for k, each in values.items()}
        first, last = low[halved], high[halved]
        middle = 0.5 * (first + last)
        total[halved] = _piece(force, first, middle, chosen, halvings - 1)
        total[halved] += _piece(force, middle, last, chosen, halvings - 1)
    return total


def _zero(test: Formula, upper: Floats, values: Values) -> Floats:
    """Return where a test changes its sign between 0 and ``upper``; 0 where it does not."""
    low, high = np.zeros_like(upper), upper.copy()

    def above(e: Floats) -> NDArray[np.bool_]:
        return np.broadcast_to(test.at({**values, "e": e}) >= 0.0, e.shape)

    first = above(low)
    changes = first != above(high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = above(middle) == first
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.where(changes, high, 0.0)


def _gauss_sums(
    force: Formula, low: Floats, high: Floats, values: Values, count: int
) -> tuple[Floats, Floats]:
    """Return ∫ f de and ∫ |f| de from ``low`` to ``high``, by a given number of points.

    The points crowd as a cube does at the beginning, for the sake of powers that are no whole
    numbers.
    """
    points, weights = (part.reshape(-1, *[1] * low.ndim) for part in _gauss(count))
    e = low + points**3 * (high - low)
    height = 3.0 * weights * points**2 * np.broadcast_to(force.at({**values, "e": e}), e.shape)
    span = high - low
    return span * height.sum(axis=0), np.abs(span) * np.abs(height).sum(axis=0)


@cache
def _gauss(count: int) -> tuple[Floats, Floats]:
    """Return points and weights of Gauss and Legendre on the unit interval."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (points + 1.0), 0.5 * weights
