"""Stress of a tissue under uniform strain, from its law alone.

No net or element is used: a principal stretch λ has the nominal stress

    P = W1 ∂I1/∂λ + W2 ∂I2/∂λ + Wg ∂g/∂λ + h'(J) J/λ + ∂W/∂λ of fibres,

with I1 = g Σ λ², I2 = g² Σ λ²λ'², g = J^(-2/3), J the product of the stretches and h the energy
of the volume; stretches across a load follow from zero stress. The derivatives of W and h are
those of the reference. A bar that is sheared by γ keeps its volume, and has I1 = I2 = 3 + γ².
(G. A. Holzapfel, Nonlinear Solid Mechanics, 2000, chapter 6; T. C. Gasser, R. W. Ogden, G. A.
Holzapfel, J. R. Soc. Interface 3:15, 2006, on fibres.)
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from tissuec.compiler.elements.bodies import INCOMPRESSIBLE, POISSON, law_of
from tissuec.laws.uniaxial import OfTension
from tissuec.model.network import Floats
from tissuec.scene.model import Tissue
from tissuec.scene.tissues.known_curves import (
    ACROSS,
    ALONG,
    COMPRESSION,
    EQUIBIAXIAL,
    SHEAR,
    TENSION,
)
from tissuec.scene.tissues.quantities import (
    FIBRE_DISPERSION,
    FIBRE_MODULUS,
    FIBRE_STIFFENING,
    POISSONS_RATIO,
    YOUNGS_MODULUS,
)
from tissuec.validate.forces.solid_laws import SolidLaws

_TRIES = 60  # of Newton's method
_STRIDE = 0.2  # of logarithms of stretches, at most in one of them
_SMALL = 1e-6  # over which stresses are differentiated
_AT_REST = 1e-4  # strain of Poisson's ratio


class LawCurve(Struct, frozen=True):
    """The law of a solid.

    Attributes:
        bulk: Modulus K at rest [Pa].
        laws: With the law as that of the only element.
        fibres: k1 [Pa], k2 and the dispersion κ of fibres along x; all 0 without any.
    """

    bulk: float
    laws: SolidLaws
    fibres: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, tissue: Tissue) -> "LawCurve":
        """Return the law of a tissue of matter."""
        given = {key: one.value for key, one in tissue.given.items()}
        law = law_of(tissue)[0]
        young = given[YOUNGS_MODULUS]
        usual = INCOMPRESSIBLE if isinstance(law, OfTension) else POISSON
        ratio = given.get(POISSONS_RATIO, usual)
        spread = given.get(FIBRE_DISPERSION, 0.0)
        added = given.get(FIBRE_MODULUS, young) - young
        fibres = 0.25 * added / (1.0 - 3.0 * spread) ** 2, given.get(FIBRE_STIFFENING, 0.0)
        shear, bulk = young / (2.0 * (1.0 + ratio)), young / (3.0 * (1.0 - 2.0 * ratio))
        moduli = np.array([shear]), np.array([bulk])
        laws = SolidLaws([law], np.zeros(1, dtype=np.int64), *moduli)
        return cls(bulk, laws, (*fibres, spread))

    def stress(self, mode: str, strains: Sequence[float]) -> Floats:
        """Return nominal stresses in a mode [Pa], shape (strain,).

        Args:
            mode: Loading mode, one of ``known_curves.MODES``.
            strains: Ascending; positive in compression, too.

        Raises:
            ArithmeticError: The law has no equilibrium at one of them.
        """
        if mode == SHEAR:
            return np.array([self._sheared(strain) for strain in strains])
        found: list[float] = []
        across = np.zeros(2)  # logarithms of stretches
        for strain in strains:
            stretch = 1.0 - strain if mode == COMPRESSION else 1.0 + strain
            across = self._free(mode, stretch, across)
            axis = 1 if mode == ACROSS else 0
            stress = self._principal(_stretches(mode, stretch, across))[axis]
            found.append(-stress if mode == COMPRESSION else stress)
        return np.array(found)

    def ratio(self, mode: str) -> float:
        """Return Poisson's ratio at rest, towards y, in tension along x."""
        across = self._free(mode, 1.0 + _AT_REST, np.zeros(2))
        return float(-np.expm1(across[0]) / _AT_REST)

    # --- stresses -----------------------------------------------------------------------------

    def _sheared(self, amount: float) -> float:
        """Return the shear stress along x on faces across y."""
        first, second, _ = self._by_invariants(3.0 + amount**2, 3.0 + amount**2, 1.0)
        k1, k2, spread = self.fibres
        e = spread * amount**2
        return 2.0 * amount * (first + second + k1 * e * np.exp(k2 * e**2) * spread)

    def _principal(self, stretches: Floats, drawn: bool | None = None) -> Floats:
        """Return the principal nominal stresses, shape (3,).

        Args:
            stretches: Along x, y and z, shape (3,).
            drawn: Whether fibres act; by default if they are stretched.
        """
        square, volume = stretches**2, float(np.prod(stretches))
        g = volume ** (-2.0 / 3.0)
        one = g * square.sum()
        two = g**2 * 0.5 * (square.sum() ** 2 - (square**2).sum())
        by_one = 2.0 * g * stretches - 2.0 / 3.0 * one / stretches
        by_two = 2.0 * g**2 * stretches * (square.sum() - square) - 4.0 / 3.0 * two / stretches
        first, second, by_g = self._by_invariants(one, two, g)
        of_volume = float(self.laws.of_volume(np.array([volume]), self.bulk)[1][0])
        even = (volume * of_volume - 2.0 / 3.0 * g * by_g) / stretches
        found = first * by_one + second * by_two + even
        k1, k2, spread = self.fibres
        e = self._fibre_strain(one, square)
        if k1 and (e > 0.0 if drawn is None else drawn):
            slope = spread * by_one
            slope[0] += 2.0 * (1.0 - 3.0 * spread) * stretches[0]
            found = found + k1 * e * np.exp(k2 * e**2) * slope
        return found

    def _are_drawn(self, stretches: Floats) -> bool:
        """Return whether fibres are stretched."""
        square = stretches**2
        first = float(np.prod(stretches)) ** (-2.0 / 3.0) * square.sum()
        return self._fibre_strain(first, square) > 0.0

    def _fibre_strain(self, first: float, square: Floats) -> float:
        """Return the strain e of fibres from I1 and the squares of stretches, shape (3,)."""
        spread = self.fibres[2]
        return float(spread * (first - 3.0) + (1.0 - 3.0 * spread) * (square[0] - 1.0))

    def _by_invariants(self, one: float, two: float, g: float) -> tuple[float, float, float]:
        at = (np.array([each]) for each in (one, two, g, g))
        first, second, *by_g = (float(each[0]) for each in self.laws.slopes(*at))
        return first, second, sum(by_g)

    # --- equilibrium across -------------------------------------------------------------------

    def _free(self, mode: str, stretch: float, start: Floats) -> Floats:
        """Return the logarithms of the unloaded stretches, by Newton's method."""
        free = _free_axes(mode)
        way: Floats = start.copy()
        steps = list(_SMALL * np.eye(len(way)))
        for _ in range(_TRIES):
            # The onset of fibres is a kink, across which no difference may be taken.
            drawn = self._are_drawn(_stretches(mode, stretch, way))
            places = [way, *(way + step for step in steps), *(way - step for step in steps)]
            here, *beside = (
                np.asarray(self._principal(_stretches(mode, stretch, at), drawn)[free])
                for at in places
            )
            columns = [
                (after - before) / (2.0 * _SMALL)
                for after, before in zip(beside[: len(way)], beside[len(way) :], strict=True)
            ]
            if mode == EQUIBIAXIAL:  # one stretch is free, not two
                move = np.array([-here[0] / columns[0][0], 0.0])
            else:
                move = -np.asarray(np.linalg.solve(np.stack(columns, axis=1), here), float)
            way = way + move * min(1.0, _STRIDE / max(np.abs(move).max(), 1e-300))
            if np.abs(move).max() < 1e-11:
                return way
        raise ArithmeticError(f"the law has no equilibrium in {mode} at {stretch - 1.0:.4g}")


def _free_axes(mode: str) -> list[int]:
    return {EQUIBIAXIAL: [2], ACROSS: [0, 2]}.get(mode, [1, 2])


def _stretches(mode: str, stretch: float, across: Floats) -> Floats:
    """Return the principal stretches along x, y and z, shape (3,)."""
    one, two = np.exp(across)
    if mode == EQUIBIAXIAL:
        return np.array([stretch, stretch, one])
    if mode == ACROSS:
        return np.array([one, stretch, two])
    assert mode in (TENSION, ALONG, COMPRESSION)
    return np.array([stretch, one, two])
