"""Laws of solids of the reference: slopes in closed form, and energies as integrals of them."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.validate.forces import principal
from tissuec.validate.forces.trees import derived, shipped

Floats = NDArray[np.float64]
Slopes = Callable[[Any, Any], tuple[Any, Any]]  # by i1 and i2, of both


def _neo_hookean(law: Any) -> Slopes:
    return lambda i1, i2: (0.5 + 0.0 * i1, 0.0 * i2)


def _mooney_rivlin(law: Any) -> Slopes:
    return lambda i1, i2: ((1.0 - law.share) / 2.0 + 0.0 * i1, law.share / 2.0 + 0.0 * i2)


def _yeoh(law: Any) -> Slopes:
    def slopes(i1: Any, i2: Any) -> tuple[Any, Any]:
        z = i1 - 3.0
        return (1.0 + 2.0 * law.second * z + 3.0 * law.third * z * z) / 2.0, 0.0 * i2

    return slopes


def _exponential(law: Any) -> Slopes:
    return lambda i1, i2: (np.exp(law.stiffening * (i1 - 3.0)) / 2.0, 0.0 * i2)


def _veronda_westmann(law: Any) -> Slopes:
    return lambda i1, i2: (np.exp(law.stiffening * (i1 - 3.0)), -0.5 + 0.0 * i2)


def _hencky(law: Any) -> Slopes:
    return lambda i1, i2: principal.slopes(lambda w: 0.5 * w, i1, i2)  # of w²/4


def _ogden(law: Any) -> Slopes:
    terms = (
        (1.0 - law.second_share - law.third_share, law.exponent),
        (law.second_share, law.second_exponent), (law.third_share, law.third_exponent),
    )  # fmt: skip

    def slope(w: Any) -> Any:  # of Σ 2 s/a² e^(a w/2)
        return sum(share / a * np.exp(0.5 * a * w) for share, a in terms)

    return lambda i1, i2: principal.slopes(slope, i1, i2)


#: By the names of the classes of shipped laws.
SLOPES: dict[str, Callable[[Any], Slopes]] = {
    "NeoHookean": _neo_hookean,
    "MooneyRivlin": _mooney_rivlin,
    "Yeoh": _yeoh,
    "SolidExponential": _exponential,
    "VerondaWestmann": _veronda_westmann,
    "Hencky": _hencky,
    "Ogden": _ogden,
}


def slopes_of(law: object) -> Slopes:
    """Return the derivatives of a law by i1 and i2: closed ones, or those of its formula."""
    return SLOPES.get(shipped(law), _of_formula)(law)


def _of_formula(law: Any) -> Slopes:
    """Return the slopes of a law of another package, from its formula."""
    tree = law.energy()

    def slopes(i1: Any, i2: Any) -> tuple[Any, Any]:
        values = {"i1": i1, "i2": i2}
        return derived(tree, values, "i1")[1] + 0.0 * i1, derived(tree, values, "i2")[
            1
        ] + 0.0 * i2

    return slopes


class SolidLaws:
    """The laws of some elements.

    Args:
        laws: The laws.
        law: Number of the law of each element, shape (element,).
        shear: Their shear moduli μ [Pa], which broadcast to the shape (element, …) of what
            follows.
    """

    def __init__(self, laws: Any, law: NDArray[np.int64], shear: Floats):
        self._rules = [(slopes_of(one), np.flatnonzero(law == k)) for k, one in enumerate(laws)]
        self._shear = shear

    def slopes(self, i1: Any, i2: Any) -> tuple[Any, Any]:
        """Return the derivatives of energies by invariants without change of volume [Pa].

        Args:
            i1, i2: Of each element, which may be complex, shape (element, …).
        """
        first, second = np.zeros_like(i1), np.zeros_like(i1)
        for rule, rows in self._rules:
            first[rows], second[rows] = rule(i1[rows], i2[rows])
        return self._shear * first, self._shear * second

    def energies(self, i1: Floats, i2: Floats) -> Floats:
        """Return energies per volume [Pa], integrals of slopes from I1 = I2 = 3 on.

        Args:
            i1, i2: Of each element, shape (element, …).
        """
        one, other, found = i1 - 3.0, i2 - 3.0, np.zeros_like(i1)
        places, weights = np.polynomial.legendre.leggauss(40)
        for rule, rows in self._rules:
            for place, weight in zip(0.5 + 0.5 * places, 0.5 * weights, strict=True):
                values = rule(3.0 + place * one[rows], 3.0 + place * other[rows])
                found[rows] += weight * (values[0] * one[rows] + values[1] * other[rows])
        return self._shear * found
