"""Changes of rules that may be tried: another conclusion, one rule less, one rule more."""

import re
from collections.abc import Iterator

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.fuzzy.sets import Shape
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.edits import TextEdit, indentation, line_of
from tissuec.learn.vocabulary.scale_texts import spelt
from tissuec.scene.model import Scene
from tissuec.scene.words.phrases import NamedScale
from tissuec.scene.words.vocabulary import RulesBlock

_REMARK = re.compile(r'"[^"\n]*"|(#[^\n]*)')


class Candidate(Struct, frozen=True):
    """One change of one rule.

    Attributes:
        kind: "conclusion", "drop" or "add".
        what: What it does, as the beginning of a sentence.
    """

    kind: str
    edit: TextEdit
    what: str


class RuleTexts(Struct, frozen=True):
    """A ``rules`` block: what its rules mean and where they are written, in one order."""

    scene: Scene
    rules: RulesBlock
    nodes: tuple[s.Rule, ...]

    @classmethod
    def of(cls, scene: Scene, key: str) -> "RuleTexts":
        """Return the rules of that name; raises KeyError if there are none."""
        block = scene.declarations.of("rules")[key].item
        assert isinstance(block, s.Block)
        nodes = tuple(item for item in block.items if isinstance(item, s.Rule))
        return cls(scene, scene.vocabulary.rules[key], nodes)

    def spelling(self, named: NamedScale, kind: str, key: str) -> dict[str, str]:
        """Return how each word of a scale is spelt where it is declared.

        Args:
            named: The scale.
            kind: "property" or "quantity".
            key: Lower-case name of the scale.
        """
        block = self.scene.declarations.of(kind)[key].item
        assert isinstance(block, s.Block)
        names = [
            name
            for item in block.items
            for name in (
                item.value.items
                if isinstance(item, s.Assign) and isinstance(item.value, s.Listing)
                else [item.name]
                if isinstance(item, s.Assign | s.Sentence)
                else []
            )
            if isinstance(name, s.Name)
        ]
        return {name.key: spelt(name) for name in names if name.key in named.scale.words}


def other_conclusions(texts: RuleTexts) -> Iterator[Candidate]:
    """Yield rules that conclude the next word below or above on the scale."""
    for node, rule in zip(texts.nodes, texts.rules.base.rules, strict=True):
        for part, conclusion in zip(node.conclusions, rule.conclusions, strict=True):
            key = conclusion.quantity
            named = texts.scene.vocabulary.quantities[key].named
            spelling = texts.spelling(named, "quantity", key)
            shape = conclusion.word.shape
            old = part.phrase.words[0]
            for word in _neighbours(shape.middle, named):
                new = spelling[word].replace('"', "")
                what = (
                    f'the rule in line {node.span.line} concludes "{new}" instead of '
                    f'"{old.text}" for the {part.quantity.text}'
                )
                yield Candidate("conclusion", TextEdit(old.span, spelling[word]), what)


def _neighbours(middle: float, named: NamedScale) -> Iterator[str]:
    """Yield the next words below and above a place of a scale."""
    near = named.scale.axis.rounding
    words = sorted(named.scale.words.items(), key=lambda word: word[1].middle)
    below = [word for word, shape in words if shape.middle < middle - near]
    above = [word for word, shape in words if shape.middle > middle + near]
    yield from (*below[-1:], *above[:1])


def dropped(texts: RuleTexts) -> Iterator[Candidate]:
    """Yield the rules but one, for each of them."""
    for node in texts.nodes:
        edit = _without(node.span)
        if edit is not None:
            yield Candidate("drop", edit, f"the rule in line {node.span.line} is removed")


def _without(span: Span) -> TextEdit | None:
    """Return an edit that takes a rule out and leaves its remarks; None if they are in the way.

    Lines that contain nothing else are removed with it.
    """
    text = span.source.text
    start, end = line_of(span)
    before, after = text[start : span.start].strip(), text[span.end : end].strip()
    if not before and (not after or after.startswith("#")):
        remarks = [m[1] for m in _REMARK.finditer(text[span.start : end]) if m[1]]
        lines = "".join(f"{indentation(span)}{remark.rstrip()}\n" for remark in remarks)
        return TextEdit(Span(span.source, start, min(end + 1, len(text))), lines)
    if "#" in span.text:
        return None
    start, end = span.start, span.end
    if after.startswith(";"):
        end = text.index(";", end) + 1
        end += len(text[end:]) - len(text[end:].lstrip(" \t"))
    elif before.endswith(";"):
        start = text.rindex(";", 0, start)
    return TextEdit(Span(span.source, start, end), "")


def appended(texts: RuleTexts, rule: str) -> TextEdit:
    """Return an edit that writes a rule after the last one, in the same layout."""
    span = texts.nodes[-1].span
    end = line_of(span)[1]
    after = span.source.text[span.end : end].strip()
    if not after or after.startswith("#"):
        return TextEdit(Span(span.source, end, end), f"\n{indentation(span)}{rule}")
    return TextEdit(Span(span.source, span.end, span.end), f"; {rule}")


def nearest(place: float, words: dict[str, Shape], count: int) -> list[str]:
    """Return the words whose midpoints are nearest to a place of their scale.

    Args:
        place: The place.
        words: Sets of the words.
        count: Number of words.
    """
    return sorted(words, key=lambda word: abs(words[word].middle - place))[:count]
