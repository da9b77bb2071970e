"""Evidence: known ranges of quantities of a tissue, with their sources.

known Young's modulus from 3 kPa to 7 kPa by "Roulot et al. 2008"
known density = 1.06 g/cm^3 by unverified "Duck 1990"
"""

from collections.abc import Iterable, Mapping
from typing import Annotated, NoReturn

from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import suggested_unit
from tissuec.lang import syntax as s
from tissuec.scene.model import AssignedQuantity, KnownQuantity
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.clauses import Written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import (
    KNOWABLE,
    OF_MATTER,
    POISSONS_RATIO,
    QUANTITIES,
    TissueQuantity,
)
from tissuec.script.forms import VerbForm, VerbSentence
from tissuec.script.parts import NameClause, Part, Placeholder, ValueClause

KNOWN, UNVERIFIED = "known", "unverified"
#: The factor within which words match a number: half a hedge of hardness, nearly.
BY_WORDS = 1.5
SOURCE = 'by "AUTHOR YEAR"'
CITE = f'cite it as {SOURCE}, or by {UNVERIFIED} "AUTHOR YEAR" if you have not checked it'


#: Where evidence is from.
Source = Annotated[
    s.Name,
    NameClause(
        "by", what="source", example=SOURCE,
        places=(
            Placeholder("SOURCE", words=(UNVERIFIED,), about="The source was not checked."),
        ),
    ),
]  # fmt: skip
_Quantity = Annotated[s.Name, NameClause("", what="quantity", places=(Placeholder("NAME"),))]


class KnownNumber(VerbSentence, frozen=True):
    """A known number."""

    quantity: _Quantity
    value: Annotated[s.Expression, ValueClause("=", place="NUMBER")]
    source: Source

    @property
    def stated(self) -> tuple[s.Expression, ...]:
        """The number, or the limits of the range."""
        return (self.value,)


class KnownRange(VerbSentence, frozen=True):
    """A known range."""

    quantity: _Quantity
    low: Annotated[s.Expression, ValueClause("from", place="NUMBER")]
    high: Annotated[s.Expression, ValueClause("to", place="NUMBER")]
    source: Source

    @property
    def stated(self) -> tuple[s.Expression, ...]:
        """The number, or the limits of the range."""
        return self.low, self.high


KNOWN_NUMBERS = SentenceKind(
    (KnownNumber, KnownRange), wrong="evidence needs a range or a number, and a source"
)


class EvidenceReader(SentenceReader):
    """Reads the evidence on something.

    Args:
        about: What it is on, for messages.
        kind, item, scope: See ``SentenceReader``.
    """

    def __init__(self, about: str, kind: SentenceKind, item: Written, scope: Scope):
        super().__init__(KNOWN, kind, item, scope)
        self.about = about

    def choose(self) -> VerbForm:
        """Return the form of which most is written."""
        forms = [form for form in self.forms if form.literal in ("", self.object.key)]
        words = self.clauses.keys()
        return max(forms, key=lambda form: len(words & {word for word, *_ in form.clauses}))

    def missing(self, part: Part, *, word: str | None = None) -> NoReturn:
        if getattr(part, "word", "") == "by":
            message = f"the source of the evidence on {self.about} is missing"
            self.reject("TIS304", message, hint=CITE)
        if part.what:
            super().missing(part, word=word)
        self.reject_form()


def is_evidence(name: s.Name) -> bool:
    """Return whether an entry of a tissue with this name is evidence."""
    return name.words.lower().split(" ")[0] == KNOWN


def read_known(item: s.Sentence | s.Assign, scope: Scope) -> KnownQuantity:
    """Return the evidence that an entry is, or reject the item."""
    quantity = _quantity(item.name, scope)
    kind = replace(KNOWN_NUMBERS, examples=(_example(quantity),))
    reader = EvidenceReader(quantity.name, kind, item, scope)
    said: KnownNumber | KnownRange = reader.get()
    source, is_verified = read_source(reader.clauses["by"], scope)
    limits, what = _limits(quantity), f"known {quantity.name}"
    stated = tuple(schema.read_value(limits, one, scope, what=what) for one in said.stated)
    if isinstance(said, KnownRange) and stated[0] >= stated[1]:
        low, high = (one.span.text for one in said.stated)
        backwards = f"from {high} to {low}"
        place = reader.clauses["from"].span.to(reader.clauses["to"].span)
        scope.findings.reject(
            "TIS308", "a range runs from a smaller number to a larger one", place,
            hint=Hint(f'write "{backwards}"', Edit(backwards)) if stated[0] > stated[1]
            else Hint(
                f'write "known {quantity.name} = …" for a single number', Edit(f"= {low}")
            ),
        )  # fmt: skip
    return KnownQuantity(quantity, stated, source, is_verified, item.span)


def _quantity(name: s.Name, scope: Scope) -> TissueQuantity:
    key = key_of(name.key.removeprefix(KNOWN))
    if key in KNOWABLE:
        return KNOWABLE[key]
    names = [quantity.name for quantity in KNOWABLE.values()]
    if key not in QUANTITIES:
        message = (
            f'"{key}" is not a quantity of matter'
            if key
            else "the quantity of the evidence is missing"
        )
        hint = alternatives(key, names, what="quantities")
    else:
        message = (
            f'evidence is for quantities of matter; "{key}" belongs to single springs or nodes'
        )
        instead = [KNOWABLE[one].name for one in OF_MATTER[key]]
        hint = f"quantities: {', '.join(instead or names)}"
    scope.findings.reject("TIS303", message, name.span, hint=hint)


def _limits(quantity: TissueQuantity) -> Real:
    """Return the limits of known values; unlike in meshes, Poisson's ratio may be 1/2."""
    if key_of(quantity.name) == POISSONS_RATIO:
        return Real(quantity.dimension, above=-1.0, at_most=0.5)
    return quantity.limits


def read_source(clause: s.Clause, scope: Scope) -> tuple[str, bool]:
    """Return the source that a clause names, and whether it could be looked up."""
    name = clause.value
    if isinstance(name, s.Name) and name.quoted and name.words.lower() in ("", UNVERIFIED):
        return name.quoted, not name.words
    quoted: list[Edit] = []
    if isinstance(name, s.Name) and not name.quoted:
        words = name.text.split()
        is_unverified = words[0].lower() == UNVERIFIED and len(words) > 1
        source = " ".join(words[1:] if is_unverified else words)
        rest = f'{UNVERIFIED} "{source}"' if is_unverified else f'"{source}"'
        quoted.append(Edit(rest, name.span))
    hint = Hint(CITE, *quoted)
    scope.findings.reject("TIS312", "a source must be in quotes", clause.span, hint=hint)


def _example(quantity: TissueQuantity) -> str:
    unit = suggested_unit(quantity.dimension)
    low, high = (f"{number} {unit}".rstrip() for number in ("0.3", "0.4"))
    return f"{KNOWN} {quantity.name} from {low} to {high} {SOURCE}"


def refuse_contradiction(
    known: KnownQuantity, others: Iterable[KnownQuantity], findings: Findings
) -> None:
    """Reject evidence whose range is disjoint from that of other evidence on the quantity.

    Args:
        known: The evidence.
        others: The other evidence.
    """
    for other in others:
        if known.high < other.low or other.high < known.low:
            _contradiction(known, other, findings)


def _contradiction(known: KnownQuantity, other: KnownQuantity, findings: Findings) -> NoReturn:
    findings.reject(
        "TIS207",
        f"the evidence on {known.quantity.name} contradicts itself: {known.shown} and "
        f"{other.shown}",
        known.span,
        hint="write one range that includes both, or remove one of them",
        notes=(Note("the other one", other.span),),
    )


def warn_of_words(
    known: Iterable[KnownQuantity],
    given: Mapping[str, AssignedQuantity],
    concluded: Mapping[str, float],
    head: Span,
    findings: Findings,
) -> None:
    """W208: the words of a tissue contradict evidence, where its number is written.

    Args:
        known: The evidence.
        given: Numbers of the tissue.
        concluded: Conclusions of rules from its words, by quantity.
        head: Head of the tissue.
    """
    for one in known:
        key = key_of(one.quantity.name)
        number, value = given.get(key), concluded.get(key)
        if number is None or number.how != "written" or value is None:
            continue
        if one.low / BY_WORDS <= value <= one.high * BY_WORDS:
            continue
        findings.add(
            "W208",
            f"the words alone would give {one.quantity.name} = "
            f"{one.quantity.show(value, digits=4)}, outside of the evidence: "
            f"{one.shown}",
            head,
            hint="change the words, or give this tissue evidence of its own",
            notes=(Note(f'known by "{one.source}"', one.span), Note("the number", number.span)),
        )


def warn_of_contradictions(
    known: Iterable[KnownQuantity],
    given: Mapping[str, AssignedQuantity],
    head: Span,
    findings: Findings,
) -> None:
    """W208: a number of a tissue, written or concluded, lies outside the range of evidence.

    Args:
        known: The evidence.
        given: Numbers of the tissue.
        head: Head of the tissue, whose words may conclude the number.
    """
    for one in known:
        number = given.get(key_of(one.quantity.name))
        if number is None or one.low <= number.value <= one.high:
            continue
        places = [Note(f'known by "{one.source}"', one.span)]
        if number.how != "written":
            places.append(Note("concluded here", number.span))
        is_none = number.value == one.quantity.none
        value = one.quantity.show(number.value, digits=4)
        findings.add(
            "W208",
            f"{one.quantity.name} {'is none' if is_none else f'= {value}'} contradicts the "
            f"evidence: {one.shown}",
            number.span if number.how == "written" else head,
            hint="change the number or the words, or give this tissue evidence of its own",
            notes=tuple(places),
        )
