"""Laws of solids of the reference: slopes in closed form, and energies as integrals of them."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.validate.forces import principal_sums
from tissuec.validate.forces.solid_volumes import of_coupled, volume_of
from tissuec.validate.forces.whole_laws import is_whole, whole_law

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
    return lambda i1, i2: principal_sums.slopes(lambda w: 0.5 * w, i1, i2)  # of w²/4


def _ogden(law: Any) -> Slopes:
    terms = (
        (1.0 - law.second_share - law.third_share, law.exponent),
        (law.second_share, law.second_exponent), (law.third_share, law.third_exponent),
    )  # fmt: skip

    def slope(w: Any) -> Any:  # of Σ 2 s/a² e^(a w/2)
        return sum(share / a * np.exp(0.5 * a * w) for share, a in terms)

    return lambda i1, i2: principal_sums.slopes(slope, i1, i2)


def _arruda_boyce(law: Any) -> Slopes:
    """Return c_1 + 2 c_2 (I1/N) + …, which is 1/2 at rest."""
    parts = np.array([1.0 / 2.0, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673750.0])
    series = np.polynomial.Polynomial([0.0, *parts]).deriv()
    rest = 2.0 * series(3.0 / law.segments)
    return lambda i1, i2: (series(i1 / law.segments) / rest, 0.0 * i2)


def _of_tension(law: Any) -> Slopes:
    """Return the slopes of a law from its curve of stress σ: 2 (λ - λ⁻²) ∂W/∂I1 = σ."""

    def slopes(one: Any, two: Any) -> tuple[Any, Any]:
        # With ε = λ - 1, ε³ + 3 ε² - z ε - z = 0, which is convex from the root of z down to ε.
        z = np.where(np.real(one) < _LARGEST, one, _LARGEST) - 3.0
        z = np.where(np.real(z) > _REST, z, _REST)
        strain = np.sqrt(z)
        for _ in range(8):
            value = ((strain + 3.0) * strain - z) * strain - z
            strain = strain - value / ((3.0 * strain + 6.0) * strain - z)
        stress, _ = derived(law.stress, {"strain": strain}, "")
        stretch = 1.0 + strain
        slope = strain * (3.0 + strain * (3.0 + strain)) / stretch**2  # λ - λ⁻²
        return 1.5 / law.modulus * stress / slope, 0.0 * two

    return slopes


_LARGEST = 16.5  # I1 of four times the length
_REST = 3e-14  # I1 - 3 up to which slopes are those at rest

#: By the names of the classes of shipped laws.
SLOPES: dict[str, Callable[[Any], Slopes]] = {
    "NeoHookean": _neo_hookean,
    "CoupledNeoHookean": _neo_hookean,  # at a constant volume
    "MooneyRivlin": _mooney_rivlin,
    "Yeoh": _yeoh,
    "SolidExponential": _exponential,
    "VerondaWestmann": _veronda_westmann,
    "Hencky": _hencky,
    "Ogden": _ogden,
    "OfTension": _of_tension,
    "ArrudaBoyce": _arruda_boyce,
}


def is_coupled(law: object) -> bool:
    """Return whether the energy of a law depends on tr C instead of I1."""
    return shipped(law) == "CoupledNeoHookean"


def slopes_of(law: object) -> Slopes:
    """Return the derivatives of a law by i1 and i2: closed ones, or those of its formula."""
    return SLOPES.get(shipped(law), _of_formula)(law)


def _of_formula(law: Any) -> Slopes:
    """Return the slopes of a law of another package, from its formula."""
    tree = law.energy()

    def slopes(i1: Any, i2: Any) -> tuple[Any, Any]:
        values = {"i1": i1, "i2": i2}
        first, second = (derived(tree, values, name)[1] for name in ("i1", "i2"))
        return first + 0.0 * i1, second + 0.0 * i2

    return slopes


class SolidLaws:
    """The laws of some elements.

    Args:
        laws: The laws.
        law: Number of the law of each element, shape (element,).
        shear, bulk: Their moduli μ and K [Pa], which broadcast to the shape (element, …) of
            what follows.
    """

    def __init__(self, laws: Any, law: NDArray[np.int64], shear: Floats, bulk: Floats):
        every = [(one, np.flatnonzero(law == k)) for k, one in enumerate(laws)]
        self._rules = [(slopes_of(one), own) for one, own in every if not is_whole(one)]
        self._whole = [(whole_law(one), own) for one, own in every if is_whole(one)]
        self._shear, self._lame = shear, bulk / shear - 2.0 / 3.0
        self._coupled = [
            (of_coupled(one), np.flatnonzero(law == k))
            for k, one in enumerate(laws) if is_coupled(one)
        ]  # fmt: skip
        self._volumes = [(volume_of(one), own) for one, own in every if not is_whole(one)]

    def slopes(self, i1: Any, i2: Any, g: Any, wide: Any) -> tuple[Any, Any, Any, Any]:
        """Return the derivatives of energies by invariants without change of volume, and by g.

        Args:
            i1, i2: Of each element, which may be complex, shape (element, …).
            g: J^(-2/3), of the same shape.
            wide: What whole laws have in the place of g.

        Returns:
            By the arguments.
        """
        first, second = np.zeros_like(i1), np.zeros_like(i1)
        for rule, rows in self._rules:
            first[rows], second[rows] = rule(i1[rows], i2[rows])
        by_g, by_wide = np.zeros_like(i1), np.zeros_like(i1)
        for _, own in self._coupled:
            first[own] = 0.5 / g[own]  # of (I1/g - 3)/2
            by_g[own] = -0.5 * i1[own] / g[own] ** 2
        for rule, own in self._whole:
            one, two, by_j = rule.slopes(*self._whole_strain(i1, i2, wide, own))
            size = wide[own]
            first[own], second[own] = one / size, two / size**2
            by_wide[own] = -one * i1[own] / size**2 - 2.0 * two * i2[own] / size**3
            by_wide[own] -= 1.5 * by_j * size**-2.5
        found = (self._shear * each for each in (first, second, by_g, by_wide))
        return tuple(found)

    def of_volume(self, j: Any, bulk: Any) -> tuple[Any, Any]:
        """Return the energy of the volume at points [Pa], and its derivative by J.

        Args:
            j: Of each element, which may be complex, shape (element, …).
            bulk: The bulk moduli there [Pa].
        """
        value, slope = self.of_mean(j, bulk)
        shear = np.broadcast_to(self._shear, j.shape)
        for rule, own in self._coupled:
            one, by = rule(j[own])
            value[own] += shear[own] * one
            slope[own] += shear[own] * by
        return value, slope

    def of_mean(self, j: Any, bulk: Any) -> tuple[Any, Any]:
        """Return the energy of the volume that belongs to the bulk modulus; see above."""
        value, slope = np.zeros_like(j), np.zeros_like(j)
        bulk = np.broadcast_to(bulk, j.shape)
        for rule, rows in self._volumes:
            one, by = rule(j[rows])
            value[rows], slope[rows] = bulk[rows] * one, bulk[rows] * by
        return value, slope

    def energies(self, i1: Floats, i2: Floats, g: Floats, wide: Floats) -> Floats:
        """Return energies per volume [Pa], integrals of slopes from I1 = I2 = 3 on.

        Args:
            i1, i2: Of each element, shape (element, …).
            g, wide: As of ``slopes``.
        """
        one, other, found = i1 - 3.0, i2 - 3.0, np.zeros_like(i1)
        places, weights = np.polynomial.legendre.leggauss(40)
        for rule, rows in self._rules:
            for place, weight in zip(0.5 + 0.5 * places, 0.5 * weights, strict=True):
                values = rule(3.0 + place * one[rows], 3.0 + place * other[rows])
                found[rows] += weight * (values[0] * one[rows] + values[1] * other[rows])
        for _, own in self._coupled:
            found[own] = 0.5 * (i1[own] / g[own] - 3.0)
        for rule, own in self._whole:
            found[own] = rule.energy(*self._whole_strain(i1, i2, wide, own))
        return self._shear * found

    def _whole_strain(
        self, i1: Any, i2: Any, wide: Any, own: NDArray[np.int64]
    ) -> tuple[Any, ...]:
        """Return the invariants of C, J and λ/μ of elements of whole laws."""
        size, lame = wide[own], np.broadcast_to(self._lame, i1.shape)
        return i1[own] / size, i2[own] / size**2, size**-1.5, lame[own]


def derived(tree: Any, values: dict[str, Floats], name: str) -> tuple[Any, Any]:
    """Return value and derivative by one variable of a tree of ``laws.formula``.

    Args:
        tree: The formula.
        values: Values of its variables in SI units, all of one shape.
        name: The variable.

    Raises:
        TypeError: The tree has a node of an unknown type.
    """

    def of(part: Any) -> tuple[Any, Any]:
        return derived(part, values, name)

    match type(tree).__name__:
        case "Constant" | "Given":
            return tree.value, 0.0
        case "Variable":
            return values[tree.name], 1.0 if tree.name == name else 0.0
        case "Sum":
            (a, da), (b, db), sign = of(tree.left), of(tree.right), -1.0 if tree.minus else 1.0
            return a + sign * b, da + sign * db
        case "Product":
            (a, da), (b, db) = of(tree.left), of(tree.right)
            return a * b, da * b + a * db
        case "Quotient":
            (a, da), (b, db) = of(tree.above), of(tree.below)
            return a / b, (da * b - a * db) / (b * b)
        case "Power":
            (a, da), n = of(tree.base), tree.exponent
            return np.power(a, n), n * np.power(a, n - 1.0) * da
        case "Applied":
            a, da = of(tree.argument)
            return _FUNCTIONS[tree.function](a), _SLOPES[tree.function](a) * da
        case "Choice":
            test, above, below = of(tree.test)[0], of(tree.above), of(tree.below)
            chosen = test >= 0.0
            return either(chosen, above[0], below[0]), either(chosen, above[1], below[1])
        case "Spline":
            a, da = of(tree.argument)
            value, slope = _on_spline(tree, a)
            return value, slope * da
        case "PrincipalSum":
            return _of_stretches(tree.exponent, values["i1"], values["i2"], name)
        case other:
            raise TypeError(f"a formula has no {other}")


def _on_spline(tree: Any, x: Any) -> tuple[Any, Any]:
    """Return value and slope of a spline, also beside the real line, of the shape of x."""
    x, starts = np.asarray(x), np.array(tree.places)
    real = np.asarray(x.real, dtype=np.float64)
    last = np.searchsorted(starts, real, side="right") - 1
    z = x - starts[np.maximum(last, 0)]
    a, b, c, d = np.moveaxis(np.array(tree.pieces)[np.maximum(last, 0)], -1, 0)
    value, slope = a + b * z + c * z**2 + d * z**3, b + 2.0 * c * z + 3.0 * d * z**2
    before = last < 0
    return either(before, a + tree.before * z, value), either(before, tree.before, slope)


def _of_stretches(a: float, i1: Any, i2: Any, name: str) -> tuple[Any, Any]:
    """Return Σ (λ^a - 1), or Σ log² λ if a is 0, and its derivative by an invariant."""
    if a == 0.0:
        value, (first, second) = (
            principal_sums.total(lambda w: 0.25 * w * w, np.real(i1), np.real(i2)),
            principal_sums.slopes(lambda w: 0.5 * w, i1, i2),
        )
    else:
        value, (first, second) = (
            principal_sums.total(lambda w: np.exp(0.5 * a * w) - 1.0, np.real(i1), np.real(i2)),
            principal_sums.slopes(lambda w: 0.5 * a * np.exp(0.5 * a * w), i1, i2),
        )
    return value, {"i1": first, "i2": second}.get(name, 0.0)


_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos,
}  # fmt: skip
_SLOPES: dict[str, Callable[[Any], Any]] = {
    "exp": np.exp,
    "log": lambda x: 1.0 / x,
    "sqrt": lambda x: 0.5 / np.sqrt(x),
    "sin": np.cos,
    "cos": lambda x: -np.sin(x),
}


def either(test: NDArray[np.bool_], one: ArrayLike, other: ArrayLike) -> Floats:
    """Return one value where a test holds, and another elsewhere, in their unit.

    Args:
        test: Shape (n,).
        one, other: In any unit, of shapes that broadcast to (n,).
    """
    return np.where(test, one, other)


def shipped(law: object) -> str:
    """Return the name of the class of a shipped law; empty for one of another package."""
    kind = type(law)
    return kind.__name__ if kind.__module__.startswith("tissuec.laws.") else ""
