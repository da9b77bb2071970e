"""Laws of the springs of a body, from tissues and from tables."""

from collections.abc import Callable
from typing import NoReturn, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.materials.spring_parts import SpringParts
from tissuec.compiler.materials.tissue_parts import USES, Material, TissueParts
from tissuec.core.errors import Note
from tissuec.core.hints import leaving_out
from tissuec.core.structs import replace
from tissuec.laws import (
    LINEAR,
    SPRING_LAWS,
    VISCOSITY_LAWS,
    Law,
    SpringLaw,
    ViscosityLaw,
    stress_in,
    with_modulus,
)
from tissuec.laws.formula import variables
from tissuec.laws.solid import SolidLaw
from tissuec.laws.uniaxial import Stiffening
from tissuec.model.network import Floats
from tissuec.scene.model import WrittenLaws
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.laws import SOLID_LAW
from tissuec.scene.tissues.quantities import YOUNGS_MODULUS


class SpringLaws:
    """What tissues and tables say of the laws of springs.

    Attributes:
        is_typed: Which springs have a law from a table, shape (spring,).
    """

    def __init__(
        self, drawing: Drawing, parts: TissueParts, springs: SpringParts, findings: Findings
    ):
        self._body, self._parts = drawing.body, parts
        self._springs, self._findings = springs, findings
        self._are_bars = drawing.is_bars
        self._bends, count = drawing.bends, len(drawing.length)
        #: Numbers of laws in the table, NaN for springs without, shape (spring,).
        self._typed = drawing.columns.springs.get("law", np.full(count, np.nan))
        self.is_typed = ~np.isnan(self._typed)
        self._typed_laws = [self._typed_law(name) for name in drawing.columns.laws]

    def _typed_law(self, name: str) -> Law:
        assert self._body.tables is not None
        laws = self._body.tables.laws[name]
        spring = laws.get("spring law")
        if spring is not None and stress_in(spring.formula) is not None:
            self._findings.reject(
                "TIS306",
                f"law {name} gives a stress, but springs of a table have no section",
                spring.span,
                hint="write a spring force, or the stress in the tissue of a body",
                notes=(Note(f"used by {self._body.name}", self._body.span),),
            )
        return _as_law(laws, name)

    def numbered(
        self, joined: Callable[[Floats, Floats], Floats]
    ) -> tuple[NDArray[np.int32], tuple[Law, ...]]:
        """Return the law of each spring by number, shape (spring,), and all laws.

        Args:
            joined: Returns what springs between two parts have, from what both parts have.
        """
        laws = [LINEAR]
        numbers: list[int] = []
        for material in self._parts.materials:
            law = self._law_of(material)
            if law not in laws:
                laws.append(law)
            numbers.append(laws.index(law))
        ends = np.array(numbers, dtype=np.int32)[self._springs.ends]
        first, second = (np.where(self._bends | self.is_typed, 0, each) for each in ends.T)
        found = first
        if (first != second).any():
            found = np.where(first == second, first, joined(first, second)).astype(np.int32)
            self._average(found, first, second, laws)
        found = found.astype(np.int32)
        for number, law in enumerate(self._typed_laws):
            if law not in laws:
                laws.append(law)
            found[self._typed == number] = laws.index(law)
        return found, tuple(laws)

    def _law_of(self, material: Material) -> Law:
        """Return the law of a part; linear where its tissue says nothing."""
        if material.tissue is None:
            return LINEAR
        modulus = material.tissue.given.get(YOUNGS_MODULUS)
        laws = material.tissue.laws
        solid, other = laws.get(SOLID_LAW), laws.get("spring law")
        if solid is not None and self._are_bars and modulus is not None:
            if other is not None:
                self._findings.reject(
                    "TIS306",
                    "a solid law and a spring law exclude each other",
                    solid.span,
                    hint=leaving_out("remove one of them", solid.span, other.span),
                    notes=(Note("the spring law", other.span),),
                )
            from tissuec.laws.solid.volume import is_whole  # where bars need it
            from tissuec.laws.tension import BarOfSolid

            if is_whole(cast(SolidLaw, solid.law)):
                self._findings.reject(
                    "TIS306",
                    f"{solid.name} is no law of bars: these keep their volume",
                    solid.span,
                    hint="write a law without a change of volume, such as neo hookean",
                    notes=(Note(f"used by {self._body.name}", self._body.span),),
                )
            bar = BarOfSolid(cast(SolidLaw, solid.law))
            written = replace(solid, formula=bar.force(), law=bar)
            laws = {**laws, "spring law": written}
        return _as_law(laws, modulus=1.0 if modulus is None else modulus.value)

    def _average(
        self,
        found: NDArray[np.int32],
        first: NDArray[np.int32],
        second: NDArray[np.int32],
        laws: list[Law],
    ) -> None:
        """Give springs that are the mean of two laws the mean of both stiffenings.

        Args:
            found: Numbers of laws, which are changed at these springs, shape (spring,).
            first, second: Numbers of laws at both ends, shape (spring,).
            laws: All laws, to which means are added.
        """
        is_mixed = (first != second) & self._springs.is_mean
        both = zip(first[is_mixed], second[is_mixed], strict=True)
        for one, other in sorted({(int(a), int(b)) for a, b in both}):
            chosen = is_mixed & (first == one) & (second == other)
            mean = _mean(laws[one], laws[other])
            if mean is None:
                self._refuse_mean(int(np.argmax(chosen)), laws[one], laws[other])
            if mean not in laws:
                laws.append(mean)
            found[chosen] = laws.index(mean)

    def _refuse_mean(self, spring: int, one: Law, other: Law) -> NoReturn:
        """Reject a spring that is to be the mean of two laws that have none."""
        first, second = self._springs.names(spring)
        self._findings.reject(
            "TIS309",
            f"springs between {first} and {second} cannot be the mean of two laws: "
            f"{one.name} and {other.name}",
            self._body.span,
            hint=f"write interface is softer from {first} to {second}, or stiffer, which uses "
            "the law of one side; only stiffenings have a mean",
        )

    def uses(self, name: str) -> NDArray[np.bool_]:
        """Return which springs have a law from the table that uses a quantity, shape (spring,).

        Args:
            name: Of the quantity.
        """
        variable = USES.get(name, ("", ""))[1]
        used = np.array(
            [
                not variable or variable in variables(law.elastic) | variables(law.viscous)
                for law in self._typed_laws
            ],
            dtype=bool,
        )
        found = np.zeros(len(self._typed), dtype=bool)
        found[self.is_typed] = used[self._typed[self.is_typed].astype(int)]
        return found


def _mean(one: Law, other: Law) -> Law | None:
    """Return the law with the mean of two stiffenings; None if both are not of that kind.

    A linear spring has the stiffening 0: at small strains, the stiffening is the relative
    increase of the stiffness per strain, of which springs side by side have the mean.
    """
    numbers = [_stiffening(law) for law in (one, other)]
    if one.viscous != other.viscous or None in numbers:
        return None
    mean = Stiffening(0.5 * sum(number for number in numbers if number is not None))
    elastic = with_modulus(mean.force(), 1.0)
    return Law(f"stiffening {mean.stiffening:.4g}", elastic, one.viscous, mean, one.dashpot)


def _stiffening(law: Law) -> float | None:
    """Return the stiffening of a law, 0 if it is linear; None if it is of another kind."""
    if isinstance(law.spring, Stiffening):
        return law.spring.stiffening
    return 0.0 if law.elastic == LINEAR.elastic else None


def _as_law(written: WrittenLaws, name: str = "", modulus: float = 1.0) -> Law:
    """Return the written law, linear if there is none."""
    spring, dashpot = written.get("spring law"), written.get("viscosity law")
    elastic = LINEAR.elastic if spring is None else with_modulus(spring.formula, modulus)
    viscous = LINEAR.viscous if dashpot is None else dashpot.formula
    if (elastic, viscous) == (LINEAR.elastic, LINEAR.viscous):
        return LINEAR
    names = ", ".join(law.name for law in (spring, dashpot) if law is not None)
    return Law(
        name or names,
        elastic,
        viscous,
        SPRING_LAWS["linear"]() if spring is None else cast(SpringLaw | None, spring.law),
        VISCOSITY_LAWS["linear"]()
        if dashpot is None
        else cast(ViscosityLaw | None, dashpot.law),
        modulus,
    )
