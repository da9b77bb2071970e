"""Energies of the change of volume of the reference, and their derivatives in closed form.

Below a least ratio of volumes they are Taylor's parabolas from there.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

LEAST = 0.2  # ratio of volumes
#: Value, first and second derivative, given J, which may be complex.
_Twice: TypeAlias = Callable[[Any], tuple[Any, Any, Any]]

#: Energies over the bulk modulus.
VOLUMES: dict[str, _Twice] = {
    "logarithmic": lambda j: (
        0.5 * np.log(j) ** 2, np.log(j) / j, (1.0 - np.log(j)) / j**2,
    ),
    "quadratic": lambda j: (0.5 * (j - 1.0) ** 2, j - 1.0, 1.0 + 0.0 * j),
    "balanced": lambda j: (
        0.25 * (j * j - 1.0) - 0.5 * np.log(j), 0.5 * (j - 1.0 / j), 0.5 * (1.0 + 1.0 / j**2),
    ),
}  # fmt: skip


def volume_of(law: object) -> Callable[[Any], tuple[Any, Any]]:
    """Return the energy of the volume over the bulk modulus with its slope, by J."""
    rule = VOLUMES[getattr(law, "volume", "logarithmic")]
    return lambda j: _continued(rule, j)


def of_coupled(law: object) -> Callable[[Any], tuple[Any, Any]]:
    """Return what coupled laws add, over the shear modulus, with its slope, by J.

    It is -ln J - 2 U/3, U being the energy of the volume.
    """
    rule = VOLUMES[getattr(law, "volume", "logarithmic")]

    def more(j: Any) -> tuple[Any, Any, Any]:
        value, slope, bend = (2.0 / 3.0 * each for each in rule(j))
        return -np.log(j) - value, -1.0 / j - slope, 1.0 / j**2 - bend

    return lambda j: _continued(more, j)


def _continued(rule: _Twice, j: Any) -> tuple[Any, Any]:
    """Return value and slope, below ``LEAST`` those of the parabola from there."""
    value, slope, _ = rule(np.where(j.real < LEAST, LEAST, j))
    first, steep, bend = map(float, rule(np.float64(LEAST)))
    below = j - LEAST
    low = first + below * (steep + 0.5 * bend * below), steep + bend * below
    found: Any = np.where(below.real < 0.0, low, (value, slope))
    return found[0], found[1]
