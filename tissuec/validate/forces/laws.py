"""Laws of springs and dashpots, in closed form where the language has a name for them.

A free formula is what its author wrote, and so is its tree; its values, slopes and energies are
found here in another way: slopes by forward differentiation, energies by adaptive quadrature.
"""

from collections.abc import Callable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.integrate import quad_vec
from scipy.interpolate import PchipInterpolator

from tissuec.validate.forces.solid_laws import derived, either, shipped, slopes_of

if TYPE_CHECKING:
    from tissuec.laws import Law

Floats: TypeAlias = NDArray[np.float64]
QUADRATURE = 1e-13  # relative error of energies of free formulas
ROUNDING, TINY = 1e-15, 1e-200
STEP = 1e-30  # of strains, in the complex plane


class ForceRule(Struct, frozen=True):
    """The force of springs [N] as a function of their elongations [m].

    Each function takes them, c [N/m] and rest lengths [m], of shape (spring,).

    Attributes:
        force: [N].
        slope: Its derivative [N/m].
        energy: Its integral from 0 on [J].
    """

    force: Callable[[Floats, Floats, Floats], Floats]
    slope: Callable[[Floats, Floats, Floats], Floats]
    energy: Callable[[Floats, Floats, Floats], Floats]


class Dashpot(Struct, frozen=True):
    """The force of dashpots [N] as a function of elongations [m] and speeds [m/s].

    Each function takes both, d [N s/m] and rest lengths [m], of shape (spring,).

    Attributes:
        force: [N].
        by_speed: Its derivative by the speed [N s/m].
        by_stretch: Its derivative by the elongation [N/m].
    """

    force: Callable[[Floats, Floats, Floats, Floats], Floats]
    by_speed: Callable[[Floats, Floats, Floats, Floats], Floats]
    by_stretch: Callable[[Floats, Floats, Floats, Floats], Floats] = lambda e, w, d, rest: (
        0.0 * w
    )


LINEAR = ForceRule(
    lambda e, c, rest: c * e,
    lambda e, c, rest: c + 0.0 * e,
    lambda e, c, rest: c * e * e / 2.0,
)
LINEAR_DASHPOT = Dashpot(lambda e, w, d, rest: d * w, lambda e, w, d, rest: d + 0.0 * w)


def _tension_only(law: Any) -> ForceRule:
    return ForceRule(
        lambda e, c, rest: c * np.maximum(e, 0.0),
        lambda e, c, rest: np.where(e >= 0.0, c, 0.0),
        lambda e, c, rest: c * np.maximum(e, 0.0) ** 2 / 2.0,
    )


def _dead_band(law: Any) -> ForceRule:
    def beyond(e: Floats) -> Floats:
        return np.sign(e) * np.maximum(np.abs(e) - law.slack, 0.0)

    return ForceRule(
        lambda e, c, rest: c * beyond(e),
        lambda e, c, rest: np.where(np.abs(e) >= law.slack, c, 0.0),
        lambda e, c, rest: c * beyond(e) ** 2 / 2.0,
    )


def _toe(law: Any) -> ForceRule:
    """∫ is c e³/(6 e*) in the toe, and c (e²/2 - e e*/2 + e*²/6) after it."""

    def part(e: Floats, rest: Floats) -> Floats:
        return np.clip(e / (law.strain * rest), 0.0, 1.0)

    def force(e: Floats, c: Floats, rest: Floats) -> Floats:
        end, p = law.strain * rest, part(e, rest)
        return c * (end * p * p / 2.0 + np.maximum(e - end, 0.0))

    def energy(e: Floats, c: Floats, rest: Floats) -> Floats:
        end, p = law.strain * rest, part(e, rest)
        behind = np.maximum(e - end, 0.0)
        return c * (end * end * p**3 / 6.0 + end * behind / 2.0 + behind**2 / 2.0)

    return ForceRule(force, lambda e, c, rest: c * part(e, rest), energy)


def _exponential(law: Any) -> ForceRule:
    """∫ is c (L0/k)² (exp(k e/L0) - 1 - k e/L0)."""
    k = law.stiffening

    def energy(e: Floats, c: Floats, rest: Floats) -> Floats:
        s = k * e / rest
        series = s * s / 2.0 * (1.0 + s / 3.0 * (1.0 + s / 4.0 * (1.0 + s / 5.0)))
        small: Floats = np.abs(s)
        part = either(small < 1e-3, series, np.expm1(s) - s)
        return c * (rest / k) ** 2 * part

    return ForceRule(
        lambda e, c, rest: c * rest / k * np.expm1(k * e / rest),
        lambda e, c, rest: c * np.exp(k * e / rest),
        energy,
    )


def _polynomial(law: Any) -> ForceRule:
    a, b = law.square, law.cube
    return ForceRule(
        lambda e, c, rest: c * e + a * e**2 + b * e**3,
        lambda e, c, rest: c + 2.0 * a * e + 3.0 * b * e**2,
        lambda e, c, rest: c * e**2 / 2.0 + a * e**3 / 3.0 + b * e**4 / 4.0,
    )


def _curve(law: Any) -> ForceRule:
    return _points(law.elongations, law.forces)


def _stress_curve(law: Any, modulus: float) -> ForceRule:
    """A bar of the section c rest / E under a stress of e / rest."""
    stress = _points(law.strains, law.stresses)

    def force(e: Floats, c: Floats, rest: Floats) -> Floats:
        return c * rest / modulus * stress.force(e / rest, c, rest)

    def slope(e: Floats, c: Floats, rest: Floats) -> Floats:
        return c / modulus * stress.slope(e / rest, c, rest)

    def energy(e: Floats, c: Floats, rest: Floats) -> Floats:
        return c * rest * rest / modulus * stress.energy(e / rest, c, rest)

    return ForceRule(force, slope, energy)


def _points(places: Any, values: Any) -> ForceRule:
    """SciPy's PCHIP, which is the same interpolant; straight beyond the points."""
    x, y = np.array(places, float), np.array(values, float)
    spline = PchipInterpolator(x, y)
    slope, whole = spline.derivative(), spline.antiderivative()

    def force(e: Floats, c: Floats, rest: Floats) -> Floats:
        inside = np.clip(e, x[0], x[-1])
        return spline(inside) + slope(inside) * (e - inside)

    def integral(e: Floats) -> Floats:
        inside = np.clip(e, x[0], x[-1])
        out = e - inside
        return whole(inside) + spline(inside) * out + slope(inside) * out * out / 2.0

    return ForceRule(
        force,
        lambda e, c, rest: slope(np.clip(e, x[0], x[-1])),
        lambda e, c, rest: integral(e) - integral(np.zeros_like(e)),
    )


def _power(law: Any) -> Dashpot:
    n, v = law.exponent, law.speed

    def slope(e: Floats, w: Floats, d: Floats, rest: Floats) -> Floats:
        with np.errstate(divide="ignore"):
            return n * d * (np.abs(w) / v) ** (n - 1.0)

    return Dashpot(lambda e, w, d, rest: np.sign(w) * d * v * (np.abs(w) / v) ** n, slope)


def _bar_of_solid(law: Any) -> ForceRule:
    """A bar that keeps its volume, whose energy per volume is E/3 ψ(I1, I2) and c = E A/L0."""
    slopes = slopes_of(law.solid)

    def force(e: Any, c: Floats, rest: Floats) -> Any:
        stretch = 1.0 + e / rest
        i1, i2 = stretch**2 + 2.0 / stretch, 2.0 * stretch + 1.0 / stretch**2
        first, second = slopes(i1, i2)
        steep = stretch - 1.0 / stretch**2
        return 2.0 / 3.0 * c * rest * steep * (first + second / stretch)

    def slope(e: Floats, c: Floats, rest: Floats) -> Floats:
        return np.asarray(force(e + 1j * STEP * rest, c, rest).imag / (STEP * rest))

    def energy(e: Floats, c: Floats, rest: Floats) -> Floats:
        places, weights = np.polynomial.legendre.leggauss(40)
        pairs = zip(0.5 + 0.5 * places, 0.5 * weights, strict=True)
        return np.asarray(sum(weight * e * force(part * e, c, rest) for part, weight in pairs))

    return ForceRule(force, slope, energy)


#: By the names of the classes that the language has for them.
RULES: dict[str, Callable[[Any], ForceRule]] = {
    "Linear": lambda law: LINEAR,
    "TensionOnly": _tension_only,
    "DeadBand": _dead_band,
    "Toe": _toe,
    "Exponential": _exponential,
    "Polynomial": _polynomial,
    "Curve": _curve,
    "BarOfSolid": _bar_of_solid,
}
DASHPOTS: dict[str, Callable[[Any], Dashpot]] = {
    "LinearDashpot": lambda law: LINEAR_DASHPOT,
    "PowerLaw": _power,
}


def _free_spring(tree: Any) -> ForceRule:
    """Return the force of a free formula of e, c and rest."""

    def both(e: Floats, c: Floats, rest: Floats) -> tuple[Floats, Floats]:
        return _like(e, *derived(tree, {"e": e, "c": c, "rest": rest}, "e"))

    def force(e: Floats, c: Floats, rest: Floats) -> Floats:
        return both(e, c, rest)[0]

    def slope(e: Floats, c: Floats, rest: Floats) -> Floats:
        return both(e, c, rest)[1]

    def energy(e: Floats, c: Floats, rest: Floats) -> Floats:
        # Forces are rounded to parts of c rest; finer looks would see nothing else.
        noise = ROUNDING * float(np.abs(c * rest * e).max(initial=0.0))
        found, _ = quad_vec(
            lambda part: e * force(part * e, c, rest),
            0.0,
            1.0,
            epsrel=QUADRATURE,
            epsabs=max(noise, TINY),
        )
        return np.asarray(found)

    return ForceRule(force, slope, energy)


def _free_dashpot(tree: Any) -> Dashpot:
    """Return the dashpot of a free formula of e, w, d and rest."""

    def by(name: str, e: Floats, w: Floats, d: Floats, rest: Floats) -> tuple[Floats, Floats]:
        return _like(w, *derived(tree, {"e": e, "w": w, "d": d, "rest": rest}, name))

    return Dashpot(
        lambda e, w, d, rest: by("w", e, w, d, rest)[0],
        lambda e, w, d, rest: by("w", e, w, d, rest)[1],
        lambda e, w, d, rest: by("e", e, w, d, rest)[1],
    )


def _like(one: Floats, *values: Any) -> tuple[Floats, Floats]:
    """Return two values in the shape of an array."""
    value, slope, _ = np.broadcast_arrays(*values, one)
    return value, slope


class ReferenceLaws:
    """The laws of some springs with their numbers.

    Args:
        laws: All laws of the net; the first is the linear one.
        law: Which one each spring has, shape (spring,).
        stiffness, damping, rest: c [N/m], d [N s/m] and L0 [m], shape (spring,).
    """

    def __init__(
        self,
        laws: "Sequence[Law]",
        law: NDArray[np.integer],
        stiffness: Floats,
        damping: Floats,
        rest: Floats,
    ):
        self._c, self._d, self.rest = stiffness, damping, rest
        used = map(int, np.unique(law[law > 0]))
        groups = [(laws[k], np.flatnonzero(law == k)) for k in used]
        self._springs = [(spring_rule(one), chosen) for one, chosen in groups]
        self._dashpots = [(dashpot_rule(one), chosen) for one, chosen in groups]

    def with_rest(self, rest: Floats) -> "ReferenceLaws":
        """Return the same with other rest lengths [m], shape (spring,)."""
        other = copy(self)
        other.rest = rest
        return other

    def pull(self, e: Floats) -> Floats:
        """Return elastic forces at elongations [m] [N], shape (spring,)."""
        return self._each(self._springs, LINEAR, "force", e, self._c)

    def slope(self, e: Floats) -> Floats:
        """Return the stiffness at elongations [m] [N/m], shape (spring,)."""
        return self._each(self._springs, LINEAR, "slope", e, self._c)

    def resisting(self, e: Floats) -> Floats:
        """Return the stiffness where it is finite, otherwise zero [N/m], shape (spring,)."""
        return _resisting(self.slope(e))

    def energy(self, e: Floats) -> Floats:
        """Return the stored energy at elongations [m] [J], shape (spring,)."""
        return self._each(self._springs, LINEAR, "energy", e, self._c)

    def brake(self, e: Floats, w: Floats) -> Floats:
        """Return viscous forces at elongations [m] and speeds [m/s] [N], shape (spring,)."""
        return self._each(self._dashpots, LINEAR_DASHPOT, "force", e, w, self._d)

    def brake_slope(self, e: Floats, w: Floats) -> Floats:
        """Return the viscosity [N s/m], shape (spring,), as ``brake``; zero where endless."""
        return _resisting(self._each(self._dashpots, LINEAR_DASHPOT, "by_speed", e, w, self._d))

    def brake_by_stretch(self, e: Floats, w: Floats) -> Floats:
        """Return how viscous forces change with elongations [N/m], shape (spring,)."""
        return self._each(self._dashpots, LINEAR_DASHPOT, "by_stretch", e, w, self._d)

    def _each(
        self,
        groups: list[tuple[Any, NDArray[np.int64]]],
        linear: ForceRule | Dashpot,
        name: str,
        *at: Floats,
    ) -> Floats:
        found = np.asarray(getattr(linear, name)(*at, self.rest))
        for rule, chosen in groups:
            found[chosen] = getattr(rule, name)(*(each[chosen] for each in (*at, self.rest)))
        return found


def _resisting(slope: Floats) -> Floats:
    return np.where(np.isfinite(slope), np.maximum(slope, 0.0), 0.0)


def spring_rule(law: "Law") -> ForceRule:
    """Return the force of a spring by its law; without a rule of its own, by its formula."""
    if law.spring is None:
        return _free_spring(law.elastic)
    kind = shipped(law.spring)
    if kind == "StressCurve":
        return _stress_curve(law.spring, law.modulus)
    return RULES[kind](law.spring) if kind in RULES else _free_spring(law.elastic)


def dashpot_rule(law: "Law") -> Dashpot:
    """Return the force of a dashpot by its law; without a rule of its own, by its formula."""
    if law.dashpot is None:
        return _free_dashpot(law.viscous)
    kind = shipped(law.dashpot)
    return DASHPOTS[kind](law.dashpot) if kind in DASHPOTS else _free_dashpot(law.viscous)
