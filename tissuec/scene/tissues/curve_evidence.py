"""Evidence on curves: a known stress over strain, or relaxation over time.

known stress in tension at [10 %, 20 %] from [1 kPa, 3 kPa] to [2 kPa, 6 kPa] by "Umale 2013"
known relaxation at [1 s, 10 s] from [70 %, 55 %] to [85 %, 75 %] by unverified "Nicolle 2010"
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, NoReturn

from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, PRESSURE, TIME
from tissuec.lang import syntax as s
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.evidence import (
    KNOWN,
    KNOWN_NUMBERS,
    SOURCE,
    EvidenceReader,
    Source,
    is_evidence,
    read_source,
)
from tissuec.scene.tissues.known_curves import (
    ACROSS,
    ALONG,
    COMPRESSION,
    MODES,
    RELAXATION,
    STRESS,
    TENSION,
    KnownCurve,
)
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause, NameClause, Placeholder, ValueClause

_EXAMPLES = {
    STRESS: f"{KNOWN} {STRESS} in {TENSION} at [10 %, 20 %] from [1 kPa, 3 kPa] to "
    f"[2 kPa, 6 kPa] {SOURCE}",
    RELAXATION: f"{KNOWN} {RELAXATION} at [1 s, 10 s] from [70 %, 55 %] to [85 %, 75 %] "
    f"{SOURCE}",
}
_MODE = Placeholder("MODE", words=MODES, about="How the tissue is loaded.")
_Fibres = {"fibres": "The fibres of the tissue."}
_Places = Annotated[s.Expression, ValueClause("at", place="LIST")]
_Low = Annotated[s.Expression, ValueClause("from", place="LIST")]
_High = Annotated[s.Expression, ValueClause("to", place="LIST")]


class KnownStress(VerbSentence, frozen=True):
    """Stresses at strains."""

    literal = STRESS

    mode: Annotated[
        s.Name,
        NameClause(
            "in", what="way in which the tissue is loaded", places=(_MODE,),
            example=f"in {TENSION}",
        ),
    ]  # fmt: skip
    along: Annotated[
        str | None, ChoiceClause("along", _Fibres, what="direction", in_forms=False)
    ]
    across: Annotated[
        str | None, ChoiceClause("across", _Fibres, what="direction", in_forms=False)
    ]
    places: _Places
    low: _Low
    high: _High
    source: Source


class KnownRelaxation(VerbSentence, frozen=True):
    """Shares of the stress that are left after times."""

    literal = RELAXATION

    places: _Places
    low: _Low
    high: _High
    source: Source


CURVES = SentenceKind(
    (KnownStress, KnownRelaxation),
    examples=tuple(_EXAMPLES.values()),
    wrong="evidence on a curve needs places, a range at each of them, and a source",
)
KNOWN_ENTRY = written(
    KNOWN, "Evidence from a source on a quantity or a curve, as ranges or a number.",
    *KNOWN_NUMBERS.forms, *CURVES.forms, repeats=True, begins=" ",
)  # fmt: skip
_SHORTEST = 0.95  # compression, of which a tissue is left


def is_curve(name: s.Name) -> bool:
    """Return whether an entry with this name is evidence on a curve."""
    return is_evidence(name) and _about(name) in _EXAMPLES


def _about(name: s.Name) -> str:
    return key_of(name.key.removeprefix(KNOWN))


def read_curve(item: s.Sentence | s.Assign | s.Block | s.Function, scope: Scope) -> KnownCurve:
    """Return the evidence of an entry on a curve, or reject the item."""
    about = _about(item.name)
    reader = EvidenceReader(about, CURVES, item, scope)
    said: KnownStress | KnownRelaxation = reader.get()
    mode = _mode(said, reader.clauses, scope) if isinstance(said, KnownStress) else ""
    source, is_verified = read_source(reader.clauses["by"], scope)
    nodes = [_items(node) for node in (said.places, said.low, said.high)]
    _refuse_unequal([reader.clauses[word] for word in ("at", "from", "to")], nodes, scope)
    what = "a strain" if mode else "a time"
    most = _SHORTEST if mode == COMPRESSION else None
    place = Real(NUMBER if mode else TIME, above=0.0, at_most=most)
    limit = Real(PRESSURE, at_least=0.0) if mode else Real(NUMBER, at_least=0.0, at_most=1.0)
    kinds = ((place, what), (limit, about), (limit, about))
    places, low, high = (
        tuple(schema.read_value(kind, node, scope, what=what) for node in several)
        for several, (kind, what) in zip(nodes, kinds, strict=True)
    )
    _refuse_falling(places, nodes[0], what, scope)
    _refuse_empty(low, high, nodes[1:], scope)
    return KnownCurve(mode, places, low, high, source, is_verified, item.span)


def _mode(said: KnownStress, clauses: Mapping[str, s.Clause], scope: Scope) -> str:
    """Return the loading mode, or reject it."""
    span, mode = clauses["in"].span, said.mode.key
    for word, fibres in (("along", said.along), ("across", said.across)):
        if fibres is not None:
            span, mode = span.to(clauses[word].span), f"{mode} {word} {fibres}"
    if mode not in MODES:
        hint = alternatives(mode, MODES, what="ways")
        scope.findings.reject(
            "TIS303", f'"{mode}" is not a way to load a tissue', span, hint=hint
        )
    return mode


def _items(node: s.Expression) -> Sequence[s.Expression]:
    """Return the numbers of a list, or the single number written in its place."""
    return node.items if isinstance(node, s.Listing) else (node,)


def _refuse_unequal(
    clauses: Sequence[s.Clause], nodes: Sequence[Sequence[s.Expression]], scope: Scope
) -> None:
    """Reject lists that are empty or of unequal length, at the first that differs."""
    if not nodes[0]:
        scope.findings.reject(
            "TIS312", "the list is empty", clauses[0].span, hint="write one number at least"
        )
    for clause, several in zip(clauses[1:], nodes[1:], strict=True):
        if len(several) != len(nodes[0]):
            scope.findings.reject(
                "TIS312",
                f'there must be as many numbers after "{clause.word}" as after "at": '
                f"{len(nodes[0])}, not {len(several)}",
                clause.span,
                hint="write one number for each place",
                notes=(Note("the places", clauses[0].span),),
            )


def _refuse_falling(
    places: Sequence[float], nodes: Sequence[s.Expression], what: str, scope: Scope
) -> None:
    for n in range(1, len(places)):
        if places[n] <= places[n - 1]:
            scope.findings.reject(
                "TIS308",
                f"each place must be larger than the one before it, but {nodes[n].span.text} "
                f"follows {nodes[n - 1].span.text}",
                nodes[n].span,
                hint=f"sort the lists by {'strain' if what == 'a strain' else 'time'}",
            )


def _refuse_empty(
    low: Sequence[float],
    high: Sequence[float],
    nodes: Sequence[Sequence[s.Expression]],
    scope: Scope,
) -> None:
    """Reject an empty range, and a stress or share that is out of bounds."""
    for n, (least, most) in enumerate(zip(low, high, strict=True)):
        first, second = (several[n].span for several in nodes)
        if most <= 0.0:
            scope.findings.reject("TIS308", "the upper limit must be above 0", second)
        if least > most:
            scope.findings.reject(
                "TIS308",
                "a range runs from a smaller number to a larger one, not from "
                f"{first.text} to {second.text}",
                second,
                hint="swap the two numbers",
                notes=(Note("the lower limit", first),),
            )


def refuse_crossing(
    known: KnownCurve, others: Iterable[KnownCurve], findings: Findings
) -> None:
    """Reject evidence on a curve that has no number in common with other evidence somewhere.

    Args:
        known: The evidence.
        others: The other evidence on the same curve.
    """
    for other in others:
        for place in sorted({*known.places, *other.places}):
            one, two = known.limits_at(place), other.limits_at(place)
            if one and two and (one[1] < two[0] or two[1] < one[0]):
                _contradiction(known, other, place, findings)


def _contradiction(
    known: KnownCurve, other: KnownCurve, place: float, findings: Findings
) -> NoReturn:
    findings.reject(
        "TIS207",
        f"the evidence on {known.name} contradicts itself at {known.shown_place(place)}",
        known.span,
        hint="write one range that includes both, or remove one of them",
        notes=(Note("the other one", other.span),),
    )


def refuse_fibres(known: Iterable[KnownCurve], head: Span, findings: Findings) -> None:
    """Reject evidence along or across fibres of a tissue that has none.

    Args:
        known: The evidence.
        head: Head of the tissue.
    """
    for one in known:
        if one.mode in (ALONG, ACROSS):
            findings.reject(
                "TIS304",
                f'a stress in {one.mode} is known, but the tissue has no "fibre modulus"',
                one.span,
                hint=f"write a fibre modulus, or: {KNOWN} {STRESS} in {TENSION} at …",
                notes=(Note("the tissue", head),),
            )
