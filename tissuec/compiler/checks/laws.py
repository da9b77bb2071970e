"""Checks of the laws of solids."""

from collections.abc import Iterator

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.scene.tissues.laws import SOLID_LAW


@check
def unstable_laws(compiled: Compiled) -> Iterator[Diagnostic]:
    """W211: laws of solids that lose their stability at strains that tissues reach."""
    seen = set[str]()
    for body in compiled.scene.bodies.values():
        are_bars = any(SOLID_LAW in tissue.laws for tissue in body.tissues)
        if body.elements is None and not are_bars:
            continue
        from tissuec.compiler.elements.bodies import law_of
        from tissuec.laws.stability import stable_strains

        for tissue in body.tissues:
            if tissue.name in seen:
                continue
            seen.add(tissue.name)
            law, place = law_of(tissue)
            if (found := stable_strains(law)) is None:
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
