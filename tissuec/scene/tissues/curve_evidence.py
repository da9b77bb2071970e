"""Evidence on curves: a known stress over strain, or relaxation over time.

known stress in tension at [10 %, 20 %] from [1 kPa, 3 kPa] to [2 kPa, 6 kPa] by "Umale 2013"
known relaxation at [1 s, 10 s] from [70 %, 55 %] to [85 %, 75 %] by unverified "Nicolle 2010"
"""

from collections.abc import Iterable, Sequence
from typing import NoReturn

from tissuec.core.errors import Note
from tissuec.core.fields import Real
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, PRESSURE, TIME
from tissuec.lang import syntax as s
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.evidence import CITE, KNOWN, SOURCE, is_evidence, read_source
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

_EXAMPLES = {
    STRESS: f"{KNOWN} {STRESS} in {TENSION} at [10 %, 20 %] from [1 kPa, 3 kPa] to "
    f"[2 kPa, 6 kPa] {SOURCE}",
    RELAXATION: f"{KNOWN} {RELAXATION} at [1 s, 10 s] from [70 %, 55 %] to [85 %, 75 %] "
    f"{SOURCE}",
}
KNOWN_ENTRY = written(
    KNOWN,
    "Evidence from a source on a quantity or a curve, as ranges or a number.",
    f"{KNOWN} NAME = NUMBER by SOURCE",
    f"{KNOWN} NAME from NUMBER to NUMBER",
    f"{KNOWN} {STRESS} in MODE at LIST from LIST to LIST by SOURCE",
    f"{KNOWN} {RELAXATION} at LIST from LIST to LIST by SOURCE",
    repeats=True,
    begins=" ",
)
_SHORTEST = 0.95  # compression, of which a tissue is left
_BAND = ("at", "from", "to", "by")


def is_curve(name: s.Name) -> bool:
    """Return whether an entry with this name is evidence on a curve."""
    return is_evidence(name) and _about(name) in _EXAMPLES


def _about(name: s.Name) -> str:
    return key_of(name.key.removeprefix(KNOWN))


def read_curve(item: s.Sentence | s.Assign | s.Block | s.Function, scope: Scope) -> KnownCurve:
    """Return the evidence of an entry on a curve, or reject the item."""
    about = _about(item.name)
    if not isinstance(item, s.Sentence) or item.phrase is not None:
        _refuse_form(item.span, about, scope)
    clauses = list(item.clauses)
    mode = _mode(item, clauses, scope) if about == STRESS else ""
    words = tuple(clause.word for clause in clauses)
    if words == _BAND[:-1]:
        message = f"the source of the evidence on {about} is missing"
        scope.findings.reject("TIS304", message, item.span, hint=CITE)
    if words != _BAND:
        _refuse_form(item.span, about, scope)
    source, is_verified = read_source(clauses[-1], scope)
    nodes = [_items(clause.value) for clause in clauses[:-1]]
    _refuse_unequal(clauses, nodes, scope)
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


def _refuse_form(span: Span, about: str, scope: Scope) -> NoReturn:
    scope.findings.reject(
        "TIS312",
        "evidence on a curve needs places, a range at each of them, and a source",
        span,
        hint=f"for example: {_EXAMPLES[about]}",
    )


def _mode(item: s.Item, clauses: list[s.Clause], scope: Scope) -> str:
    """Return the loading mode, and consume its clauses."""
    if not clauses or clauses[0].word != "in" or not isinstance(clauses[0].value, s.Name):
        scope.findings.reject(
            "TIS312",
            "the way in which the tissue is loaded is missing",
            item.span,
            hint=f"for example: {_EXAMPLES[STRESS]}",
        )
    span, mode = clauses[0].span, clauses[0].value.key
    del clauses[0]
    if clauses and clauses[0].word in ("along", "across"):
        span = span.to(clauses[0].span)
        mode = f"{mode} {key_of(clauses[0].span.text)}"
        del clauses[0]
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
    for clause, several in zip(clauses[1:-1], nodes[1:], strict=True):
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
