"""Strains beyond which laws of solids are no longer stable.

A material is stable in Drucker's sense while stress grows with every further strain: dτ : dε >
0, with Kirchhoff's stress τ and the logarithmic strain ε. In an isotropic solid that keeps its
volume, the second derivatives of the energy by two of its logarithmic principal strains are
then a positive definite matrix. (D. C. Drucker, J. Appl. Mech. 26:101, 1959; R. Hill, J. Mech.
Phys. Solids 16:229, 1968.) Beyond that, strain localises in single elements, and results depend
on the mesh.
"""

from math import log

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.laws.derivatives import (
    by_both,
    by_first,
    by_first_twice,
    by_second,
    by_second_twice,
)
from tissuec.laws.principal import squared_stretches
from tissuec.laws.solid import SolidLaw

_Numbers = NDArray[np.float64]

LARGEST = 2.0  # stretch, or its inverse, up to which laws of tissue are expected to be stable
_STEPS = 400  # of the logarithmic strain up to the largest
# Part of the initial value that is rounding: measured curves consist of smooth pieces.
_NOTHING = 1e-9


class StableStrains(Struct, frozen=True):
    """Strains up to which a law is stable, dimensionless; None where there is no limit.

    Attributes:
        tension: Elongation in uniaxial tension.
        compression: Shortening in uniaxial compression, which is equibiaxial tension.
        shear: Elongation in pure shear: of a wide strip.
    """

    tension: float | None
    compression: float | None
    shear: float | None


def stable_strains(law: SolidLaw, largest: float = LARGEST) -> StableStrains | None:
    """Return the strains up to which a law is stable; None if it is stable at all strains.

    Args:
        law: Of a solid that keeps its volume.
        largest: Stretch up to which strains are tried, and down to whose inverse.
    """
    large = log(largest) / _STEPS * np.arange(_STEPS + 1.0)

    def first(*ways: float) -> float | None:
        x, y, z = (np.exp(2.0 * way * large) for way in ways)
        lost = np.flatnonzero(~is_stable(law, x + y + z, 1.0 / x + 1.0 / y + 1.0 / z))
        return float(large[lost[0]]) if len(lost) else None

    tension, compression, shear = (
        first(1.0, -0.5, -0.5), first(-1.0, 0.5, 0.5), first(1.0, 0.0, -1.0),
    )  # fmt: skip
    if tension is None and compression is None and shear is None:
        return None
    return StableStrains(
        None if tension is None else float(np.expm1(tension)),
        None if compression is None else float(-np.expm1(-compression)),
        None if shear is None else float(np.expm1(shear)),
    )


def is_stable(law: SolidLaw, first: _Numbers, second: _Numbers) -> NDArray[np.bool_]:
    """Return whether a law is stable at some strains, dimensionless, shape (…).

    Args:
        first, second: Isochoric invariants, shape (…).
    """
    with np.errstate(all="ignore"):  # of what is turned inside out, which no law describes
        return _is_positive(law, first, second)


def _is_positive(law: SolidLaw, first: _Numbers, second: _Numbers) -> NDArray[np.bool_]:
    """Return whether the matrix of second derivatives of the energy is positive definite."""
    x, y, z = squared_stretches(first, second)
    values = {"i1": first, "i2": second}
    slope_1, slope_2 = by_first(law).at(values), by_second(law).at(values)
    both = by_both(law).at(values)
    bend_1, bend_2 = by_first_twice(law).at(values), by_second_twice(law).at(values)
    # Derivatives of I1 = x + y + z and I2 = 1/x + 1/y + 1/z by the logarithmic strains of x and
    # y, where x = exp 2 ε and z = 1/xy.
    one = 2.0 * (x - z), 2.0 * (y - z)
    two = 2.0 * (1.0 / z - 1.0 / x), 2.0 * (1.0 / z - 1.0 / y)

    def bent(k: int, m: int, by_first: _Numbers, by_second: _Numbers) -> _Numbers:
        found = slope_1 * by_first + slope_2 * by_second + bend_1 * one[k] * one[m]
        return found + both * (one[k] * two[m] + two[k] * one[m]) + bend_2 * two[k] * two[m]

    xx = bent(0, 0, 4.0 * (x + z), 4.0 * (1.0 / x + 1.0 / z))
    yy = bent(1, 1, 4.0 * (y + z), 4.0 * (1.0 / y + 1.0 / z))
    xy = bent(0, 1, 4.0 * z, 4.0 / z)
    return (xx > _NOTHING) & (xx * yy - xy * xy > _NOTHING)
