"""Provenance of the physical numbers of a scene: written word, rule, line and degree."""

from collections.abc import Iterator
from typing import Any, Literal

from msgspec import Struct

from tissuec.core.data import as_data
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, show, si_unit
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.scene.force_numbers import ForceNumbers, numbers_of
from tissuec.scene.model import AssignedQuantity, KnownQuantity, Tissue
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.tissues.evidence import KNOWN, UNVERIFIED
from tissuec.scene.tissues.known_curves import KnownCurve
from tissuec.scene.tissues.laws import SOLID_LAW
from tissuec.scene.tissues.quantities import QUANTITIES, STIFFENING, Spread, rivals

SET = "set on the command line"


class Reason(Struct, frozen=True):
    """One line of an explanation.

    Attributes:
        word: Of the conclusion; beside a written number, what the words of the tissue give.
        degree: Of the rule; None where a number was written.
        place: ``file:line``.
        facts: The facts that the rule received, such as "hardness soft 1.00".
    """

    word: str
    degree: float | None
    place: str
    facts: str

    @property
    def said(self) -> str:
        """Return the word with its degree: "slightly low (slightly + low) 0.62"."""
        if self.degree is None:
            return self.word
        # Two decimals, but never 0.00 for what counts.
        return f"{self.word} {self.degree:{'.2f' if self.degree >= 0.005 else '.0e'}}"


class Explained(Struct, frozen=True):
    """A quantity of a tissue, its value and its reasons, strongest first.

    Attributes:
        from_words: The number that the words of the tissue would give instead; None where it is
            concluded from them, and where rules conclude nothing.
        ratio: Ratio of the number to ``from_words``; None without it.
    """

    quantity: str
    value: float  # SI
    shown: str  # "8.79 N/m", "1 mg/node"
    how: str  # "written", "rules", "otherwise"
    reasons: tuple[Reason, ...]
    from_words: float | None = None
    ratio: float | None = None


class ProvenanceRow(Struct, frozen=True):
    """One entry of the table of a tissue.

    Attributes:
        kind: A property that is written, a quantity that comes of it, a law of springs, or
            evidence.
        value: As it is written, or with its unit.
        how: Where it is from; of a property the number that its word means.
        reasons: One at least.
    """

    kind: Literal["property", "quantity", "law", "known"]
    name: str
    value: str
    how: str
    reasons: tuple[Reason, ...]


def tissue_rows(tissue: Tissue) -> list[ProvenanceRow]:
    """Return all that there is to say of a tissue, entry by entry."""
    return [
        *(
            ProvenanceRow(
                "property", f.property, f.written, f"{f.number:.4g}", (_at(f.span.place),)
            )
            for f in tissue.facts
        ),
        *(
            ProvenanceRow("quantity", e.quantity, e.shown, e.how, e.reasons)
            for e in explain_tissue(tissue)
        ),
        *_replaced(tissue),
        *(
            ProvenanceRow("law", word, law.name, "", (_at(law.span.place),))
            for word, law in tissue.written_laws.items()
        ),
        *(
            ProvenanceRow(
                "known",
                f"{KNOWN} {one.quantity.name}",
                one.shown,
                cited(one),
                (_at(one.span.place),),
            )
            for one in tissue.known
        ),
        *(
            ProvenanceRow(
                "known", f"{KNOWN} {one.name}", one.shown, cited(one), (_at(one.span.place),)
            )
            for one in tissue.curves
        ),
    ]


def cited(known: KnownQuantity | KnownCurve) -> str:
    """Return the source of evidence, and whether it could not be looked up."""
    return known.source if known.is_verified else f"{known.source} ({UNVERIFIED})"


def _at(place: str) -> Reason:
    return Reason("", None, place, "")


def as_dict(words: ResolvedProgram, tissues: list[Tissue]) -> dict[str, Any]:
    """Return params, tissues and forces as plain data."""
    return {
        "params": {
            p.name: {"value": p.value.amount, "overridden": p.overridden}
            for p in words.constants.parameters()
        },
        "tissues": {tissue.name: _tissue(tissue) for tissue in tissues},
        "forces": {name: _force(force) for name, force in numbers_of(words.forces).items()},
    }


def _force(force: ForceNumbers) -> dict[str, Any]:
    entries = {
        name: {
            "value": entry.value,
            "unit": None if entry.dimension is None else si_unit(entry.dimension),
            "shown": entry.shown,
            "how": entry.how,
            "text": entry.text,
            "place": entry.place,
        }
        for name, entry in force.entries.items()
    }
    return as_data(force) | {"entries": entries}


def _tissue(tissue: Tissue) -> dict[str, Any]:
    return {
        "place": tissue.span.place,
        "about": tissue.about,
        "facts": {
            f.property: {"written": f.written, "number": f.number, "place": f.span.place}
            for f in tissue.facts
        },
        "quantities": {e.quantity: as_data(e) for e in explain_tissue(tissue)},
        "from_words": {QUANTITIES[key].name: one for key, one in tissue.concluded.items()},
        "laws": {
            word: {
                "law": law.name,
                "energy" if word == SOLID_LAW else "force": law.formula.code(),
                "place": law.span.place,
            }
            for word, law in tissue.written_laws.items()
        },
        "known": [_known(one) for one in tissue.known],
        "curves": [curve_as_dict(one) for one in tissue.curves],
        "missing": dict(tissue.missing),
    }


def _known(known: KnownQuantity) -> dict[str, Any]:
    return {
        "quantity": known.quantity.name,
        "stated": list(known.stated),
        "low": known.low,
        "high": known.high,
        "source": known.source,
        "verified": known.is_verified,
        "place": known.span.place,
    }


def curve_as_dict(known: KnownCurve) -> dict[str, Any]:
    """Return evidence on a curve as plain data, in SI units."""
    return {
        "of": known.name,
        "places": list(known.places),
        "low": list(known.low),
        "high": list(known.high),
        "source": known.source,
        "verified": known.is_verified,
        "place": known.span.place,
    }


def used_tissues(words: ResolvedProgram) -> list[Tissue]:
    """Return the tissues that bodies and joints are made of; all, where none is used."""
    used = {
        part.phrase.words[0].key
        for kind in ("body", "joint")
        for declared in words.declarations.of(kind).values()
        for part in walk(declared.item)
        if isinstance(part, s.Sentence) and part.name.key == "tissue" and part.phrase
    }
    return [tissue for key, tissue in words.tissues.items() if key in used or not used]


def explain_tissue(tissue: Tissue) -> tuple[Explained, ...]:
    """Return every quantity of a tissue with the lines that gave it."""
    return tuple(
        _explained(given, tissue.concluded.get(key)) for key, given in tissue.given.items()
    )


def _explained(given: AssignedQuantity, concluded: float | None) -> Explained:
    quantity, reasons = given.quantity, tuple(_reasons(given))
    ratio = None
    if given.fired or given.how == "otherwise":
        concluded = None  # which is the number itself
    if concluded:
        said = f"words: {quantity.show(concluded)}"
        if given.value != quantity.none:
            ratio = given.value / concluded
            said += f", ratio {ratio:.2f}"
        reasons = tuple(replace(one, word=said) for one in reasons)
    return Explained(
        quantity.name, given.value, shown_value(given), given.how, reasons, concluded, ratio
    )


def _replaced(tissue: Tissue) -> Iterator[ProvenanceRow]:
    """Yield numbers from words alone of quantities that other entries replace."""
    for key, value in tissue.concluded.items():
        if key in tissue.given or key in tissue.missing:
            continue
        written = (tissue.given[one] for one in rivals(key) if one in tissue.given)
        by = [(one.quantity.name, one.span) for one in written if one.how == "written"]
        if key == STIFFENING:
            by += [(f'the law "{one.name}"', one.span) for one in tissue.written_laws.values()]
        if by:
            (name, span), quantity = by[0], QUANTITIES[key]
            reason = Reason(f"replaced by {name}", None, span.place, "")
            shown = quantity.show(value)
            yield ProvenanceRow("quantity", quantity.name, shown, "words alone", (reason,))


def shown_value(given: AssignedQuantity) -> str:
    """Return a value with its unit and its reference, such as "per 1 mm"."""
    quantity = given.quantity
    if quantity.name == "prestress":
        return f"{100.0 * given.value:.3g} %"
    if given.value == quantity.none:
        return "none"
    return quantity.show(given.value) + belonging(given.spread, given.length)


def belonging(spread: Spread, length: float | None) -> str:
    """Return the reference of a value: "/node", " per 1 mm"."""
    if spread == "matter":
        return ""
    if spread == "each spring":
        return "" if length is None else f" per {show(length, LENGTH)}"
    return "/node" if spread == "each node" else "/body"


def _reasons(given: AssignedQuantity) -> Iterator[Reason]:
    if not given.fired:
        yield Reason("", None, given.span.place, "")
    for fired in given.fired:
        yield Reason(fired.word, fired.degree, fired.span.place, fired.facts)
