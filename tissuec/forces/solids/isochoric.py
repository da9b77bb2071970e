"""The part of a strain without its change of volume J, also where elements are inside out.

Below J = 1/5, functions of J are their parabolas there, and the invariants are enlarged, so
that energies are never negative and grow.
"""

from tissuec import autodiff
from tissuec.autodiff import Number

#: Ratio of volumes below which the isochoric energy is continued by a parabola, so that it has
#: a value where an element is inverted, and grows.
LEAST = 0.2
_LARGEST = 1e4  # ratio of volumes above which it no longer falls


def isochoric(j: Number) -> Number:
    """Return J^(-2/3), continued by a parabola below ``LEAST``."""
    return falling(j, 2, LEAST)


def falling(x: Number, thirds: int, least: float) -> Number:
    """Return x^(-thirds/3), continued by a parabola below a least value.

    Args:
        thirds: 1 or 2.
    """
    near = autodiff.maximum(x, least)
    root, power = _inverse_cube_root(near), -thirds / 3.0
    value = least**power
    slope = power * value / least
    bend = (power - 1.0) * slope / least
    below = x - near
    return (root if thirds == 1 else root * root) + below * (slope + 0.5 * bend * below)


def folded(j: Number) -> Number:
    """Return the term that keeps g I1 at least 3 below ``LEAST`` as well.

    As I1 ≥ 3 |J|^(2/3), at least 3 (1 - g |J|^(2/3)) is needed. That is at most 3 s³ with
    s = 1 - J/LEAST; for g² I2 ≥ 3 g² |J|^(4/3), twice as much is enough. The polynomial exceeds
    3 s³, has two continuous derivatives, and reaches 3 at J = 0.
    """
    s = autodiff.minimum(autodiff.maximum(1.0 - j / LEAST, 0.0), 1.0)
    return 3.0 * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def paired(first: Number, second: Number, fold: Number) -> Number:
    """Return I2 below ``LEAST``, such that some stretches have both invariants.

    Both approach a curve along which they grow from 3 on, between those of tension and of
    compression along an axis.

    Args:
        first, second: Enlarged invariants.
        fold: What ``folded`` returns.
    """
    beyond = first - 3.0
    return second + fold / 3.0 * (first + beyond * beyond / 8.0 - second)


def _inverse_cube_root(j: Number) -> Number:
    """Return J^(-1/3) by two rounds of fifth order, which leave rounding."""
    small, scale = autodiff.minimum(j, _LARGEST), j.graph.number(1.0)
    # So that it is at most 4, where the start is within 8 %.
    for cube, factor in ((512.0, 0.125), (8.0, 0.5)):
        is_large = small > 0.5 * cube
        small = autodiff.where(is_large, small / cube, small)
        scale = autodiff.where(is_large, factor * scale, scale)
    root = (2.0 + small) / (1.0 + 2.0 * small)
    for _ in range(2):
        r = 1.0 - small * root * root * root
        series = 2.0 / 9.0 + r * (14.0 / 81.0 + r * (35.0 / 243.0))
        root = root * (1.0 + r * (1.0 / 3.0 + r * series))
    return autodiff.ruled(root * scale, [j], _of_root)


def _of_root(root: Number, _: Number) -> list[Number]:
    return [(-1.0 / 3.0) * (root * root) ** 2]
