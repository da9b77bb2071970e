"""Strains beyond which laws of solids are no longer stable.

A material is stable in Drucker's sense while stress grows with every further strain: dτ : dε >
0, with Kirchhoff's stress τ and the logarithmic strain ε. In an isotropic solid that keeps its
volume, the second derivatives of the energy by two of its logarithmic principal strains are
then a positive definite matrix; in one of a whole law, which is pressed and widens by its
Poisson's ratio, those by all three. (D. C. Drucker, J. Appl. Mech. 26:101, 1959; R. Hill, J.
Mech. Phys. Solids 16:229, 1968.) Beyond that, strain localises in single elements, and results
depend on the mesh.
"""

from collections.abc import Sequence
from functools import cache
from math import log

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.laws.derivatives import (
    by_both,
    by_first,
    by_first_twice,
    by_second,
    by_second_twice,
    energy,
)
from tissuec.laws.formula import Formula, Variable, exp, values_at
from tissuec.laws.principal import PrincipalSum, squared_stretches
from tissuec.laws.solid import COFACTORS, I1, I2, TRACE, J, SolidLaw
from tissuec.laws.solid.volume import is_whole

_Numbers = NDArray[np.float64]

LARGEST = 2.0  # stretch, or its inverse, up to which laws of tissue are expected to be stable
_STEPS = 400  # of the logarithmic strain up to the largest
# Part of the initial value that is rounding: measured curves consist of smooth pieces.
_NOTHING = 1e-9
_STRAINS = ("strain 1", "strain 2", "strain 3")  # variables of formulas
_ROUNDS, _CLOSE = 8, 1e-6  # of Newton's method from the strain before, and its last step


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


def stable_strains(
    law: SolidLaw, largest: float = LARGEST, lame: float = 0.0
) -> StableStrains | None:
    """Return the strains up to which a law is stable; None if it is stable at all strains.

    Args:
        law: Of a solid that keeps its volume, or a whole law.
        largest: Stretch up to which strains are tried, and down to whose inverse.
        lame: λ/μ, which whole laws need.
    """
    large = log(largest) / _STEPS * np.arange(_STEPS + 1.0)

    def first(*ways: float) -> float | None:
        x, y, z = (np.exp(2.0 * way * large) for way in ways)
        if is_whole(law):
            stable = _are_whole_stable(law, lame, large, ways)
        else:
            stable = is_stable(law, x + y + z, 1.0 / x + 1.0 / y + 1.0 / z)
        lost = np.flatnonzero(~stable)
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


def is_stable(
    law: SolidLaw, first: _Numbers, second: _Numbers, j: _Numbers | None = None,
    lame: _Numbers | float = 0.0,
) -> NDArray[np.bool_]:  # fmt: skip
    """Return whether a law is stable at some strains, dimensionless, shape (…).

    Args:
        first, second: Isochoric invariants, shape (…).
        j, lame: J, and λ/μ, which whole laws need, of the same shape.
    """
    with np.errstate(all="ignore"):  # of what is turned inside out, which no law describes
        if is_whole(law):
            assert j is not None
            strains = 0.5 * np.log(squared_stretches(first, second)) + np.log(j) / 3.0
            _, bends = _by_strains(law, strains, lame)
            found = np.linalg.eigvalsh(np.where(np.isfinite(bends), bends, -1.0))
            return np.asarray(found[..., 0] > _NOTHING)
        return _is_positive(law, first, second)


def _are_whole_stable(
    law: SolidLaw, lame: float, large: _Numbers, ways: Sequence[float]
) -> NDArray[np.bool_]:
    """Return whether a whole law is stable at strains of a way, shape (strain,).

    Args:
        lame: λ/μ.
        large: Logarithmic strains, ascending, shape (strain,).
        ways: Principal strains of a solid that keeps its volume over these: the first is given,
            and of the others those that are not zero follow from free sides.
    """
    free = [k for k in (1, 2) if ways[k]]
    stable, strains, bends = np.zeros(len(large), dtype=bool), np.zeros(3), np.eye(3)
    for k, each in enumerate(large.tolist()):
        strains[0] = ways[0] * each
        for _ in range(_ROUNDS):
            slopes, bends = _by_strains(law, strains, lame)
            step = np.linalg.solve(bends[np.ix_(free, free)], slopes[free])
            strains[free] -= step
            if np.abs(step).max() < _CLOSE:
                break
        stable[k] = np.linalg.eigvalsh(bends)[0] > _NOTHING
        if not stable[k]:
            break
    return stable


def _by_strains(
    law: SolidLaw, strains: _Numbers, lame: _Numbers | float
) -> tuple[_Numbers, _Numbers]:
    """Return the derivatives of the energy of a whole law by logarithmic principal strains.

    Args:
        strains: Shape (3, …).
        lame: λ/μ.

    Returns:
        First and second derivatives, shape (…, 3) and (…, 3, 3).
    """
    found = values_at(_whole_slopes(law), _named(strains) | {"lame": lame})
    flat = np.stack(np.broadcast_arrays(*found, strains[0])[:-1], axis=-1)
    return flat[..., :3], flat[..., 3:].reshape(*flat.shape[:-1], 3, 3)


def _named(strains: _Numbers) -> dict[str, _Numbers]:
    return dict(zip(_STRAINS, strains, strict=True))


@cache
def _whole_slopes(law: SolidLaw) -> list[Formula]:
    """Return the first and second derivatives by logarithmic strains, row by row."""
    formula = _of_strains(energy(law))
    first = [formula.slope(name) for name in _STRAINS]
    return [*first, *(each.slope(name) for each in first for name in _STRAINS)]


def _of_strains(formula: Formula) -> Formula:
    """Return a formula of a whole law as one of logarithmic principal strains."""
    one, two, three = strains = [Variable(name) for name in _STRAINS]
    total = one + two + three

    def summed(factor: Formula | float, less: float = 0.0) -> Formula:
        first, *rest = (exp(factor * (each - less * total)) for each in strains)
        return first + rest[0] + rest[1]

    known: dict[str, Formula] = {
        TRACE.name: summed(2.0), COFACTORS.name: exp(2.0 * total) * summed(-2.0),
        I1.name: summed(2.0, 1.0 / 3.0), I2.name: summed(-2.0, 1.0 / 3.0), J.name: exp(total),
    }  # fmt: skip

    def of(part: Formula) -> Formula:
        if isinstance(part, PrincipalSum):
            return summed(part.exponent, 0.0 if part.is_whole else 1.0 / 3.0) - 3.0
        if isinstance(part, Variable):
            return known.get(part.name, part)
        inner = {
            name: of(each)
            for name in part.__struct_fields__
            if isinstance(each := getattr(part, name), Formula)
        }
        return replace(part, **inner) if inner else part

    return of(formula)


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
