"""Old spellings of measures, and the edits that make them those of conditions.

A measure is written ``force(A along (1, 0, 0))`` everywhere. Outputs and studies also
read ``force of A``, and learning a direction after the parentheses; ``tissuec fmt`` writes
these as in conditions.
"""

from collections.abc import Iterator, Sequence

from tissuec.core.hints import Edit
from tissuec.core.names import key_of
from tissuec.core.source import Source, Span
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.scene.learning.model import FIT
from tissuec.scene.study.entries import AGGREGATES
from tissuec.script.measures import MEASURES

#: Measures that are counted: ``count(nodes of A)``.
COUNTED = ("nodes", "springs", "elements", "pieces")
_MEASURE = "measure"


def respelled(source: Source, *, has_heading: bool = True) -> Source:
    """Return a text with measures as conditions have them.

    Args:
        source: The text.
        has_heading: Whether it begins with ``language 1``.

    Raises:
        CompileError: The text has mistakes.
    """
    text = source.text
    edits = list(_edits(parse(source, has_heading=has_heading).items))
    for edit in sorted(edits, key=lambda one: -_place(one).start):
        place = _place(edit)
        text = text[: place.start] + edit.text + text[place.end :]
    return Source(source.name, text, source.path) if edits else source


def _place(edit: Edit) -> Span:
    assert edit.span is not None
    return edit.span


def _edits(items: Sequence[s.Item]) -> Iterator[Edit]:
    for item in items:
        if not isinstance(item, s.Block):
            continue
        kind = item.name.key.split(" ")[0]
        for inner in item.items:
            if kind == "output" and isinstance(inner, s.Sentence) and inner.phrase is None:
                yield from _sentence(inner.name, inner.clauses)
            elif kind == "study" and isinstance(inner, s.Assign):
                yield from _of_study(inner)
            elif kind == "learn" and isinstance(inner, s.Assign) and inner.name.key == FIT:
                yield from _of_fit(inner)


def _of_study(item: s.Assign) -> Iterator[Edit]:
    if not item.name.key.startswith(f"{_MEASURE} "):
        return
    value = item.value
    if isinstance(value, s.Name):
        yield from _sentence(value, item.clauses)
    elif isinstance(value, s.Call) and value.function.key in AGGREGATES:
        for argument in value.arguments:
            if isinstance(argument.value, s.Name):
                yield from _sentence(argument.value, argument.clauses)


def _sentence(name: s.Name, clauses: Sequence[s.Clause]) -> Iterator[Edit]:
    """Yield the edit of ``force of A along (1, 0, 0)``, if that is what is written."""
    if name.key not in MEASURES or not clauses or clauses[0].word != "of":
        return
    said = [one for one in clauses if one.word in ("of", "to", "along")]
    own = clauses[: len(said)]
    if [*own] != said or len({one.word for one in own}) < len(own):
        return
    texts: list[str] = []
    for clause in own:
        if clause.word == "along":
            texts[-1] += f" {clause.span.text}"
            continue
        parts = clause.value.items if isinstance(clause.value, s.Listing) else (clause.value,)
        if not all(isinstance(part, s.Name) for part in parts):
            return
        is_union = MEASURES[name.key].subjects == 1 or any(one.word == "to" for one in own)
        parts = (clause.value,) if is_union else parts
        texts += [part.span.text for part in parts]
    if len(texts) != MEASURES[name.key].subjects:
        return
    written = f"{name.span.text}({', '.join(texts)})"
    if name.key in COUNTED:
        written = f"count({name.span.text} of {texts[0]})"
    yield Edit(written, name.span.to(own[-1].span))


def _of_fit(item: s.Assign) -> Iterator[Edit]:
    """Yield the edit of ``position(A) along (1, 0, 0)``."""
    value, along = item.value, item.clauses[0] if item.clauses else None
    if not isinstance(value, s.Call) or along is None or along.word != "along":
        return
    is_plain = len(value.arguments) == 1 and not value.arguments[0].clauses
    if is_plain and key_of(value.function.text) in MEASURES:
        written = f"{value.span.text[:-1].rstrip()} {along.span.text})"
        yield Edit(written, value.span.to(along.span))
