"""Laws of solids of the reference that depend on shape and volume together, in closed form."""

from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.validate.forces import principal_sums


class WholeLaw(Struct, frozen=True):
    """The energy of a solid over its shear modulus.

    Each function takes the first two invariants of C, J, and λ/μ, all of one shape.

    Attributes:
        energy: Of real numbers.
        slopes: The derivatives of the energy by the first three, which may be complex.
    """

    energy: Callable[[Any, Any, Any, Any], Any]
    slopes: Callable[[Any, Any, Any, Any], tuple[Any, Any, Any]]


def _saint_venant_kirchhoff(law: Any) -> WholeLaw:
    """tr E = (I1 - 3)/2 and tr E² = (tr C² - 2 I1 + 3)/4, tr C² being I1² - 2 I2."""
    return WholeLaw(
        lambda one, two, j, lame: (
            lame / 8.0 * (one - 3.0) ** 2 + (one**2 - 2.0 * two - 2.0 * one + 3.0) / 4.0
        ),
        lambda one, two, j, lame: (
            lame / 4.0 * (one - 3.0) + (one - 1.0) / 2.0, -0.5 + 0.0 * two, 0.0 * j
        ),
    )  # fmt: skip


def _holmes_mow(law: Any) -> WholeLaw:
    def grown(one: Any, two: Any, j: Any, lame: Any) -> Any:
        part = ((2.0 - lame) * (one - 3.0) + lame * (two - 3.0)) / (lame + 2.0)
        return np.exp(law.exponent * part) * j ** (-2.0 * law.exponent)

    def energy(one: Any, two: Any, j: Any, lame: Any) -> Any:
        return (lame + 2.0) / (4.0 * law.exponent) * (grown(one, two, j, lame) - 1.0)

    def slopes(one: Any, two: Any, j: Any, lame: Any) -> tuple[Any, Any, Any]:
        size = grown(one, two, j, lame)
        return (2.0 - lame) / 4.0 * size, lame / 4.0 * size, -(lame + 2.0) / 2.0 / j * size

    return WholeLaw(energy, slopes)


def _unconstrained_ogden(law: Any) -> WholeLaw:
    terms = (
        (1.0 - law.second_share - law.third_share, law.exponent),
        (law.second_share, law.second_exponent), (law.third_share, law.third_exponent),
    )  # fmt: skip

    def energy(one: Any, two: Any, j: Any, lame: Any) -> Any:
        i1, i2 = one * j ** (-2.0 / 3.0), two * j ** (-4.0 / 3.0)
        found = lame / 2.0 * (j - 1.0) ** 2
        for share, a in terms:

            def power(w: Any, a: float = a) -> Any:
                return np.exp(0.5 * a * w)

            whole = j ** (a / 3.0) * principal_sums.total(power, i1, i2)
            found = found + 2.0 * share / a**2 * (whole - 3.0 - a * np.log(j))
        return found

    def slopes(one: Any, two: Any, j: Any, lame: Any) -> tuple[Any, Any, Any]:
        # The sum over λ^a = j^(a/3) λ'^a, of the λ' without change of volume, whose derivative
        # by J at constant invariants of C has that of both.
        g = j ** (-2.0 / 3.0)
        i1, i2 = one * g, two * g * g
        by_one, by_two, by_j = 0.0 * one, 0.0 * two, lame * (j - 1.0)
        for share, a in terms:

            def slope(w: Any, a: float = a) -> Any:
                return 0.5 * a * np.exp(0.5 * a * w)

            size = 2.0 * share / a**2 * j ** (a / 3.0)
            first, second = principal_sums.slopes(slope, i1, i2)
            whole = _power_sum(a, i1, i2, first, second)
            by_one, by_two = by_one + size * g * first, by_two + size * g * g * second
            more = a * whole - 2.0 * first * i1 - 4.0 * second * i2
            by_j = by_j + size * more / (3.0 * j) - 2.0 * share / (a * j)
        return by_one, by_two, by_j

    return WholeLaw(energy, slopes)


def _power_sum(a: float, i1: Any, i2: Any, first: Any, second: Any) -> Any:
    """Return Σ λ^a of stretches without change of volume, to first order beside the real line.

    Args:
        first, second: Its derivatives by the invariants.
    """
    whole = principal_sums.total(lambda w: np.exp(0.5 * a * w), np.real(i1), np.real(i2))
    if not np.iscomplexobj(i1) and not np.iscomplexobj(i2):
        return whole
    beside = np.real(first) * np.imag(i1) + np.real(second) * np.imag(i2)
    return whole + 1j * beside


#: By the names of the classes of shipped laws.
WHOLE_LAWS: dict[str, Callable[[Any], WholeLaw]] = {
    "SaintVenantKirchhoff": _saint_venant_kirchhoff,
    "HolmesMow": _holmes_mow,
    "UnconstrainedOgden": _unconstrained_ogden,
}


def is_whole(law: object) -> bool:
    """Return whether the energy of a law includes that of the volume."""
    return type(law).__module__.startswith("tissuec.laws.") and type(law).__name__ in WHOLE_LAWS


def whole_law(law: object) -> WholeLaw:
    """Return the energy of a law that includes that of the volume."""
    return WHOLE_LAWS[type(law).__name__](law)
