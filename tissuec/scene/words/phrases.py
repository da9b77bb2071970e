"""Hedges, and the reading of a phrase as a word of a scale."""

from collections.abc import Container, Mapping
from typing import Annotated, NoReturn

import numpy as np
from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import Edit, Hint, did_you_mean
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, Dimension
from tissuec.fuzzy.hedges import Hedge, PowerHedge, Shift, has_effect, hedged
from tissuec.fuzzy.scale import Scale
from tissuec.fuzzy.sets import Powered, Word
from tissuec.lang import syntax as s
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import declare
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Placeholder, ValueClause, new_name

DIRECTIONS = ("outward", "inward")


class HedgeWords(VerbSentence, frozen=True):
    """A hedge, and what it does to words."""

    name: Annotated[s.Name, new_name("hedge")]
    shape: Annotated[
        s.Expression, ValueClause("=", places=(Placeholder("HEDGE"),), place="SHAPE")
    ]


_HEDGE = SentenceKind((HedgeWords,))
declare(
    "hedge",
    "A modifier of words that shifts them along their scale or sharpens them.", 10, "sentence",
    sentences=_HEDGE.forms, example="hedge very = shift(50 %, outward)",
)  # fmt: skip


class NamedScale(Struct, frozen=True):
    """The words of a property or quantity, by lower-case name, and where they are declared."""

    name: str
    scale: Scale
    dimension: Dimension
    span: Span


def read_hedge(item: s.Item, scope: Scope) -> Hedge:
    """Return the hedge of ``hedge very = shift(50 %, outward)`` or ``= power(2)``."""
    assert isinstance(item, s.Assign)
    said: HedgeWords = SentenceReader("hedge", _HEDGE, item, scope).get()
    call = said.shape
    arguments = (
        [argument.value for argument in call.arguments] if isinstance(call, s.Call) else []
    )
    try:
        match call:
            case s.Call(function=s.Name(key="shift")) if len(arguments) == 2:
                direction = arguments[1].key if isinstance(arguments[1], s.Name) else ""
                if direction in DIRECTIONS:
                    return Shift(_plain(arguments[0], scope), direction)  # type: ignore[arg-type]
            case s.Call(function=s.Name(key="power")) if len(arguments) == 1:
                return PowerHedge(_plain(arguments[0], scope))
            case _:
                pass
    except ValueError as error:
        scope.findings.reject("TIS308", str(error), call.span)
    scope.findings.reject(
        "TIS312",
        "a hedge must be shift(50 %, outward), shift(50 %, inward) or power(2)",
        call.span,
    )


def _plain(node: s.Expression, scope: Scope) -> float:
    value = scope.number(node)
    scope.expect(value, NUMBER, node.span, what="the strength of a hedge")
    return float(np.asarray(value.amount))


def read_word(
    name: s.Name,
    scale: NamedScale,
    hedges: Mapping[str, Hedge],
    scope: Scope,
    *,
    in_conclusion: bool = False,
) -> Word:
    """Return the word of a scale that a phrase means, or reject it.

    Args:
        in_conclusion: Whether the phrase is part of a conclusion.
    """
    front, rest = reading(name.key, scale.scale.words, hedges) or _unknown(
        name, scale, hedges, scope
    )
    shape = scale.scale.words[rest]
    chosen = [hedges[part] for part in front]
    if in_conclusion and any(isinstance(hedge, PowerHedge) for hedge in chosen):
        scope.findings.reject(
            "TIS204",
            f'"{name.text}": a power hedge is not allowed in a conclusion',
            name.span,
            hint="it does not move the centre; use a hedge that shifts",
        )
    for part, hedge in zip(front, chosen, strict=True):
        if not has_effect(hedge, shape, scale.scale.axis):
            scope.findings.add(
                "W205",
                f'"{part}" has no effect on "{rest}": the word is already there',
                name.span,
                hint=Hint(f'write "{rest}" alone, or another word', Edit(rest)),
            )
    shape = hedged(chosen, shape, scale.scale.axis)
    read_as = name.key if not front else f"{name.key} ({' '.join(front)} + {rest})"
    assert not (in_conclusion and isinstance(shape, Powered))
    return Word(read_as, shape)


def reading(
    phrase: str, words: Container[str], hedges: Container[str]
) -> tuple[tuple[str, ...], str] | None:
    """Return the hedges and the word of a phrase; None if the phrase is not of a scale.

    The whole phrase counts if it is declared as a word; else hedges are removed from the left
    until the rest is a word.

    Args:
        words: Words of the scale.
        hedges: Known hedges.
    """
    parts = phrase.split(" ")
    for count in range(len(parts)):
        front, rest = tuple(parts[:count]), " ".join(parts[count:])
        if rest in words and all(part in hedges for part in front):
            return front, rest
    return None


def _unknown(
    name: s.Name, scale: NamedScale, hedges: Mapping[str, Hedge], scope: Scope
) -> NoReturn:
    for part in name.key.split(" "):  # one of which may be a hedge
        scope.findings.pass_over_doubtful(part)
    words = scale.scale.words
    near = did_you_mean(
        name.key, [*words, *(f"{hedge} {word}" for hedge in hedges for word in words)]
    )
    listed = f"words for {scale.name}: {', '.join(scale.scale.words)}"
    if hedges:
        listed += f"; hedges: {', '.join(hedges)}"
    scope.findings.reject(
        "TIS201",
        f'"{name.text}" is not a word for {scale.name}',
        name.span,
        hint=Hint("  ".join(part for part in (near, listed) if part), *near.edits),
        notes=(Note(f"{scale.name} is declared at {scale.span.place}"),),
    )
