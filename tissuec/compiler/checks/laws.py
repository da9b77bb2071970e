"""Checks of the laws of solids."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.units import PRESSURE, show
from tissuec.laws import stress_in
from tissuec.laws.formula import Choice, every
from tissuec.scene.model import WrittenLaw
from tissuec.scene.tissues.laws import SOLID_LAW
from tissuec.scene.tissues.quantities import POISSONS_RATIO


@check
def unstable_laws(compiled: Compiled) -> Iterator[Diagnostic]:
    """W211: laws of solids that lose their stability at strains that tissues reach."""
    seen = set[str]()
    for body in compiled.scene.bodies.values():
        are_bars = any(SOLID_LAW in tissue.laws for tissue in body.tissues)
        if body.elements is None and not are_bars:
            continue
        from tissuec.compiler.elements.bodies import POISSON, law_of
        from tissuec.laws.stability import stable_strains

        for tissue in body.tissues:
            if tissue.name in seen:
                continue
            seen.add(tissue.name)
            law, place = law_of(tissue)
            given = tissue.given.get(POISSONS_RATIO)
            ratio = POISSON if given is None else given.value
            lame = 2.0 * ratio / (1.0 - 2.0 * ratio)
            if (found := stable_strains(law, lame=lame)) is None:
                continue
            limits = {
                "tension": found.tension,
                "compression": found.compression,
                "shear": found.shear,
            }
            at = ", ".join(f"{100.0 * at:.2g} % in {way}" for way, at in limits.items() if at)
            yield Diagnostic(
                "W211",
                f"the law of {tissue.name} is stable only up to {at}: beyond that, further "
                "strain needs less stress, and results depend on the mesh",
                place,
                "choose numbers with which stress keeps rising, such as a larger third number "
                "of yeoh, or keep strains below",
            )


APART = 0.2  # of the stress: a contradiction, far above the errors of curves


#: Compressions at which a formula that distinguishes tension is compared with the solid.
PRESSED = np.array([-0.05, -0.1, -0.2, -0.3])
#: How many of them count for other formulas: those of a line differ by more at the others.
SLIGHT = 2


def _pressed_strains(curve: WrittenLaw, *, is_solid: bool) -> NDArray[np.float64]:
    """Return the compressions for which a curve states a stress, shape (strain,).

    Args:
        curve: Of a tissue.
        is_solid: Whether solids are made of it; walls are hardly ever compressed, so that
            formulas that distinguish nothing say nothing of it.
    """
    if curve.law is not None:
        strains = np.array(getattr(curve.law, "strains", ()), dtype=np.float64)
        return strains[(strains > -1.0) & (strains < 0.0)]
    stress = stress_in(curve.formula)
    if stress is None:
        return np.zeros(0)
    tests = (part.test for part in every(stress) if isinstance(part, Choice))
    signs = (
        [np.asarray(test.at({"e": at, "rest": 1.0})) >= 0.0 for at in (PRESSED, -PRESSED)]
        for test in tests
    )
    if any((one != other).any() for one, other in signs):
        return PRESSED
    return PRESSED[: SLIGHT if is_solid else 0]


@check
def pressed_curves(compiled: Compiled) -> Iterator[Diagnostic]:
    """W215: points of curves in compression, where elements follow from tension.

    The solid has an energy of I1 alone: at the stretch λ, its nominal stress is
    2 (λ - λ⁻²) dW/dI1 at I1 = λ² + 2/λ (``laws.uniaxial``).
    """
    made = [body for body in compiled.scene.bodies.values() if body.elements is not None]
    tissues = {tissue.name: tissue for body in made for tissue in body.tissues}
    solid = {tissue.name for body in made if not body.is_wall for tissue in body.tissues}
    for tissue in tissues.values():
        curve = tissue.laws.get("spring law")
        if curve is None:
            continue
        strains = _pressed_strains(curve, is_solid=tissue.name in solid)
        if not len(strains):
            continue
        from tissuec.compiler.elements.bodies import law_of
        from tissuec.laws.derivatives import by_first
        from tissuec.laws.uniaxial import OfTension

        law, place = law_of(tissue)
        assert isinstance(law, OfTension)
        whole = law.stress.at({"strain": strains})
        stresses = np.broadcast_to(np.asarray(whole, dtype=float), strains.shape)
        for strain, written in zip(strains.tolist(), stresses.tolist(), strict=True):
            stretch = 1.0 + strain
            slope = by_first(law).at({"i1": stretch**2 + 2.0 / stretch, "i2": 3.0})
            solid = law.modulus * 2.0 / 3.0 * (stretch - stretch**-2) * float(slope)
            if abs(written - solid) <= APART * max(abs(written), abs(solid)):
                continue
            drawn, has = (show(one, PRESSURE) for one in (written, solid))
            yield Diagnostic(
                "W215",
                f"elements follow the curve of {tissue.name} in tension only: at a strain of "
                f"{100.0 * strain:.3g} %, the curve has {drawn} and the solid {has}",
                place,
                "for a solid that was compressed, fit a solid law to both parts, such as ogden",
            )
            break
