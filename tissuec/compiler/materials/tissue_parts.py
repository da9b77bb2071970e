"""The quantities that tissues give the parts of a body, and those they leave out."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import NoReturn

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.bodies.graded import element_centres, numbers_at, spring_middles
from tissuec.core.errors import Note
from tissuec.core.hints import Hint, insertion
from tissuec.core.resources import is_preset
from tissuec.core.source import Span
from tissuec.core.units import suggested_unit
from tissuec.laws.formula import variables
from tissuec.model.network import Floats
from tissuec.scene.model import AssignedQuantity, SpringPart, Tissue
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.graded import graded_tissue
from tissuec.scene.tissues.laws import LAW_KINDS, SOLID_LAW
from tissuec.scene.tissues.quantities import (
    BREAKING_FORCE,
    FIBRE_DISPERSION,
    FIBRE_MODULUS,
    FIBRE_STIFFENING,
    LARGEST_SHARE,
    OF_MATTER,
    POISSONS_RATIO,
    QUANTITIES,
    SHARES,
    TOGETHER,
    TOUGHNESS,
    YOUNGS_MODULUS,
    TissueQuantity,
)

#: Which law replaces the use of a quantity, and as what its formula would use it.
USES = {
    name: (kind.word, variable)
    for kind in LAW_KINDS
    for form in kind.forms
    for name, (variable, _) in form.names.items()
    if name in QUANTITIES and name != YOUNGS_MODULUS
}


#: Where strengths of those come from that cannot break.
NOT_ALLOWED = "rupture is not allowed"
#: What only fibres in elements have.
OF_FIBRES = FIBRE_STIFFENING, FIBRE_DISPERSION


class Material(Struct, frozen=True):
    """Material of one part of a body."""

    name: str
    tissue: Tissue | None
    prestress: AssignedQuantity | None  # overrides the tissue's
    span: Span


class TissueParts:
    """The parts of a body by number, with the quantities that their tissues give them.

    0 is the body itself, then come its regions, then springs that have a tissue of their own.
    """

    def __init__(self, drawing: Drawing, findings: Findings):
        body = drawing.body
        self.drawing, self.body, self.findings = drawing, body, findings
        own = graded_tissue(body.tissue, body.graded)
        self.materials = [Material(body.name, own, None, body.span)]
        for region in body.regions:
            tissue = graded_tissue(region.tissue or own, region.graded)
            self.materials.append(Material(region.name, tissue, region.prestress, region.span))

    def add(self, part: SpringPart) -> int:
        """Return the number of a part of springs, which is taken up."""
        tissue = part.tissue or self.materials[0].tissue
        self.materials.append(Material(part.name, tissue, part.prestress, part.span))
        return len(self.materials) - 1

    # --- numbers of quantities ----------------------------------------------------------------

    @cached_property
    def centres(self) -> Floats:
        """The centre of each element [m], shape (element, 3)."""
        return element_centres(self.drawing.mesh)

    @cached_property
    def middles(self) -> Floats:
        """The middle of each spring [m], shape (spring, 3)."""
        return spring_middles(self.drawing.mesh)

    def at_elements(
        self, given: Sequence[AssignedQuantity | None], default: float = np.nan
    ) -> Floats:
        """Return a quantity of each element in its SI unit, shape (element,).

        Args:
            given: The quantity of each part.
            default: Where a part has none.
        """
        assert self.drawing.element_part is not None
        part = self.drawing.element_part
        return self._at(given, part, default, lambda: self.centres)

    def at_springs(
        self,
        given: Sequence[AssignedQuantity | None],
        part: NDArray[np.integer],
        default: float | None,
    ) -> Floats:
        """Return a quantity of each spring in its SI unit, shape (spring,).

        Args:
            given: The quantity of each part.
            part: Number of the part of each spring, shape (spring,).
            default: Where a part has none.
        """
        default = np.nan if default is None else default
        return self._at(given, part, default, lambda: self.middles)

    def at_nodes(
        self, given: Sequence[AssignedQuantity | None], default: float = np.nan
    ) -> Floats:
        """Return a quantity at each node in its SI unit, shape (node,).

        Args:
            given: The quantity of each part.
            default: Where a part has none.
        """
        mesh = self.drawing.mesh
        return self._at(given, self.drawing.part, default, lambda: mesh.position)

    def _at(
        self,
        given: Sequence[AssignedQuantity | None],
        part: NDArray[np.integer],
        default: float,
        places: Callable[[], Floats],
    ) -> Floats:
        found = np.array([default if one is None else one.value for one in given])[part]
        for number, one in enumerate(given):
            own = part == number
            if one is not None and one.formula is not None and own.any():
                assert self.drawing.scope is not None
                scope, owner = self.drawing.scope, self._owner(one)
                found[own] = numbers_at(
                    one, self.drawing.described(places()[own]), scope, owner
                )
        return found

    def _owner(self, given: AssignedQuantity) -> str:
        """Return the body or region whose tissue has a quantity."""
        of_tissues = ((m.name, m.tissue) for m in self.materials if m.tissue is not None)
        return next(n for n, t in of_tissues if any(given is g for g in t.given.values()))

    # --- quantities of parts ------------------------------------------------------------------

    def found(self, name: str) -> list[AssignedQuantity | None]:
        """Return the quantity of each part, or that of matter from which it follows."""
        if name == "prestress":
            return [
                m.prestress or (m.tissue and m.tissue.given.get(name)) for m in self.materials
            ]
        return [m.tissue and _said(m.tissue, name) for m in self.materials]

    def needed_limit(self, usual: str) -> str:
        """Return the limit that the body needs, for messages about a missing limit.

        Args:
            usual: The limit to name if any limit counts.
        """
        return TOUGHNESS if self.body.rupture == "by toughness" else usual

    def limits(self) -> list[list[AssignedQuantity]]:
        """Return the limits of each part: at most two quantities.

        A strain and a strength limit it together. A toughness counts where there is neither,
        or where the body has ``rupture by toughness`` or ``by faces``.
        """
        return [[] if m.tissue is None else self._limits(m.tissue) for m in self.materials]

    def _limits(self, tissue: Tissue) -> list[AssignedQuantity]:
        given = tissue.given
        if (force := given.get(BREAKING_FORCE)) is not None:
            return [force]
        tough = [given[TOUGHNESS]] if TOUGHNESS in given else []
        if self.body.rupture == "by toughness":
            return tough
        if self.body.tears_by_faces and tough and tough[0].value != tough[0].quantity.none:
            return tough
        found = [given[key] for key in TOGETHER if key in given]
        finite = [one for one in [*found, *tough] if one.value != one.quantity.none]
        return [one for one in finite if one in found] or finite or (found + tough)[:1]

    def given(
        self,
        name: str,
        used: NDArray[np.integer],
        found: Sequence[AssignedQuantity | None] | None = None,
    ) -> list[AssignedQuantity | None]:
        """Return the quantity of each part; rejects a part that has none and is in ``used``.

        Args:
            used: Numbers of parts, shape (…).
            found: The quantity of each part, if it is known already.
        """
        given = self.found(name) if found is None else list(found)
        for number in part_numbers(used):
            if given[number] is None and QUANTITIES[name].default is None:
                given[number] = self._unused(name, self.materials[number])
        return given

    def expect(self, name: str, used: NDArray[np.integer]) -> None:
        """Reject a part that has none of a quantity which laws in the table use.

        Args:
            used: Numbers of the parts with such laws, shape (…).
        """
        found = self.found(name)
        for number in part_numbers(used):
            if found[number] is None and QUANTITIES[name].default is None:
                self.missing(name, self.materials[number])

    def _unused(self, name: str, material: Material) -> AssignedQuantity:
        """Return the quantity 1 where a law of its own makes no use of it, or reject the part.

        The paper sets c = d = 1 for laws with constants of their own.
        """
        word, variable = USES.get(name, ("", ""))
        law = material.tissue and material.tissue.laws.get(word)
        if law is None or variable in variables(law.formula):
            self.missing(self.needed_limit(name) if name == BREAKING_FORCE else name, material)
        return AssignedQuantity(
            QUANTITIES[name], 1.0, "each spring", None, f"no part of the {word}", law.span
        )

    def refuse_solids(self, used: NDArray[np.integer], *, are_bars: bool) -> None:
        """Report laws and fibres of solids in parts that consist of springs.

        Args:
            used: Numbers of parts, shape (…).
            are_bars: Whether the springs are bars, which follow laws of solids in tension.
        """
        for number in part_numbers(used):
            material = self.materials[number]
            if material.tissue is None:
                continue
            given = material.tissue.given
            found = [(f"a {name}", given.get(name)) for name in OF_FIBRES]
            ratio = given.get(POISSONS_RATIO)
            if not are_bars and ratio is not None and _is_own(ratio):
                found += [("a Poisson's ratio", ratio)]
            law, hint = material.tissue.laws.get(SOLID_LAW), "remove it from the tissue"
            if YOUNGS_MODULUS not in given:
                found += [(f"a {SOLID_LAW}", law)]
            for what, written in found:
                if written is None:
                    continue
                way_out = hint
                if are_bars and written is law:
                    way_out = f"write a Young's modulus and a density in the tissue, or {hint}"
                self.findings.add(
                    "TIS306",
                    f"{what} has no effect on springs, of which {material.name} consists",
                    written.span,
                    hint=way_out,
                    notes=(Note("used here", material.span),),
                )

    def missing(self, name: str, material: Material, *notes: Note) -> NoReturn:
        """Reject a part that lacks a quantity.

        Args:
            name: Of the quantity.
            material: The part.
            notes: What needs it.
        """
        if material.tissue is None:
            self.findings.reject(
                "TIS304",
                f"{material.name} needs a tissue, because its {name} is missing",
                material.span,
                hint="write tissue is …",
            )
        self.findings.pass_over_doubtful(name)
        reasons = (material.tissue.missing.get(key) for key in (name, *OF_MATTER[name]))
        reason = next(filter(None, reasons), "neither a rule nor a number gives it")
        self.findings.reject(
            "TIS206",
            f"the {QUANTITIES[name].name} of tissue {material.tissue.name} is missing: "
            f"{reason}",
            material.tissue.span,
            hint=f"write {' or '.join(_names(name))} = … in the tissue, a rule for it, "
            "or otherwise is … in the vocabulary",
            notes=(Note(f"used by {material.name}", material.span), *notes),
        )

    def refuse_half(
        self, given: AssignedQuantity | None, name: str, lacking: TissueQuantity, where: Span
    ) -> NoReturn:
        """Reject a quantity that says nothing without another one.

        Args:
            given: The quantity; None in a table.
            name: Of the quantity in a table.
            lacking: The other one.
            where: Place of the table.
        """
        amount = "20 %" if lacking.name in SHARES else f"1 {suggested_unit(lacking.dimension)}"
        example = f"{lacking.name} = {amount}"
        self.findings.reject(
            "TIS304",
            f"a {given.quantity.name if given else name} needs a {lacking.name}",
            given.span if given else where,
            hint=Hint(
                f"for example: {example}",
                *([insertion(f"; {example}", given.span)] if given else []),
            ),
            notes=(Note(f"used by {self.body.name}", self.body.span),),
        )

    def beside(self, given: AssignedQuantity) -> Mapping[str, AssignedQuantity]:
        """Return all quantities of the tissue that one belongs to."""
        tissues = (m.tissue for m in self.materials if m.tissue is not None)
        # Equal quantities of a tissue and of a graded one are different objects.
        return next(t.given for t in tissues if any(given is one for one in t.given.values()))

    def relaxing_beside(self, share: AssignedQuantity) -> float:
        """Return the sum of all shares of the tissue that one belongs to."""
        given = self.beside(share)
        total = sum(given[key].value for key in SHARES if key in given)
        if total > LARGEST_SHARE:
            self.findings.reject(
                "TIS309",
                f"the shares that relax make up {100.0 * total:.0f} % of the modulus",
                share.span,
                hint="the shares must be less than 100 %: write smaller ones",
                notes=(Note(f"used by {self.body.name}", self.body.span),),
            )
        return total

    def modulus_beside(self, stress: AssignedQuantity) -> AssignedQuantity:
        """Return the modulus of the tissue that a stress belongs to, along any fibres."""
        beside = self.beside(stress)
        modulus = beside.get(YOUNGS_MODULUS)
        if modulus is not None:
            return beside.get(FIBRE_MODULUS, modulus)
        what = stress.quantity
        self.findings.reject(
            "TIS304",
            f"a {what.name} needs a Young's modulus",
            stress.span,
            hint=f"for single springs, write {_instead_of(what)} instead",
            notes=(Note(f"used by {self.body.name}", self.body.span),),
        )

    def refuse_idle_fibres(self) -> None:
        """Reject a direction without fibres, and fibres without a body that they stiffen."""
        given = [m.tissue.given for m in self.materials if m.tissue is not None]
        along = [one[FIBRE_MODULUS] for one in given if FIBRE_MODULUS in one]
        has_fibres = self.body.fibres is not None or self.body.second_fibres is not None
        if has_fibres and not along:
            self.findings.reject(
                "TIS306",
                f"fibres of {self.body.name} have no effect: its tissue has no fibre modulus",
                self.body.places.get(
                    "fibres", self.body.places.get("second fibres", self.body.span)
                ),
                hint="write a fibre modulus in the tissue, or remove fibres",
            )
        for one in given:
            if FIBRE_MODULUS in one and YOUNGS_MODULUS not in one:
                self.findings.reject(
                    "TIS304",
                    "a fibre modulus needs a Young's modulus",
                    one[FIBRE_MODULUS].span,
                    hint="write a Young's modulus, which applies across the fibres",
                    notes=(Note(f"used by {self.body.name}", self.body.span),),
                )

    def added_by_fibres(self, given: AssignedQuantity) -> float:
        """Return the contribution of fibres to the Young's modulus of springs, as a part of it.

        Args:
            given: Any quantity of the tissue.
        """
        beside = self.beside(given)
        if FIBRE_MODULUS not in beside:
            return 0.0
        fibres, modulus = beside[FIBRE_MODULUS], beside[YOUNGS_MODULUS]
        for one in (fibres, modulus):
            if one.formula is not None:
                self.findings.reject(
                    "TIS306",
                    f"springs of a tissue with fibres have the same {one.quantity.name} "
                    "everywhere",
                    one.span,
                    hint="give its regions different tissues",
                )
        if fibres.value < modulus.value:
            self.refuse_soft_fibres(fibres)
        return fibres.value / modulus.value - 1.0

    def refuse_soft_fibres(self, fibres: AssignedQuantity) -> NoReturn:
        """Reject a fibre modulus below Young's modulus."""
        self.findings.reject(
            "TIS309",
            "the fibre modulus is less than Young's modulus: tissue is not softer along "
            "its fibres than across them",
            fibres.span,
            hint="write a larger fibre modulus, or remove it",
            notes=(Note(f"used by {self.body.name}", self.body.span),),
        )


def _is_own(given: AssignedQuantity) -> bool:
    """Return whether a quantity is written, and not by a preset of the library."""
    return given.how == "written" and not is_preset(given.span.source.path)


def _instead_of(quantity: TissueQuantity) -> str:
    """Return the quantities of springs or strain that can replace a stress."""
    if quantity.instead == "breaking force":
        return "a breaking strain or the breaking force"
    return f"the {quantity.instead}"


def _names(key: str) -> list[str]:
    """Return the written names of the quantities that determine a quantity."""
    return [QUANTITIES[one].name for one in (key, *OF_MATTER[key])]


def _said(tissue: Tissue, name: str) -> AssignedQuantity | None:
    """Return a quantity of a tissue, or that of matter from which it follows."""
    known = (tissue.given.get(key) for key in (name, *OF_MATTER[name]))
    return next((given for given in known if given is not None), None)


def part_numbers(parts: NDArray[np.integer]) -> list[int]:
    """Return the numbers that there are, ascending; small ones, which are quickly counted.

    Args:
        parts: Numbers of parts, shape (…).
    """
    return np.flatnonzero(np.bincount(parts.ravel())).tolist()
