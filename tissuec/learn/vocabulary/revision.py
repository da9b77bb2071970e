"""Revision of rules: the changes that may be tried, and one after another of them.

Nearly any change improves the fit to fitted rows; only held-out rows distinguish a better rule
from one that fits the noise.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from difflib import unified_diff
from itertools import chain
from types import MappingProxyType

from msgspec import Struct

from tissuec.core.errors import CompileError
from tissuec.core.source import Span
from tissuec.fuzzy.rules import And, Condition, Is, atoms, canonical
from tissuec.fuzzy.sets import Shape, Word
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.scale_texts import spelt
from tissuec.learn.vocabulary.texts import TextEdit, apply, indentation, line_of
from tissuec.learn.vocabulary.used import Use, reread, used_tissues, warnings_of
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
        words: Sets of the words.
        count: Number of words.
    """
    return sorted(words, key=lambda word: abs(words[word].middle - place))[:count]


GAIN = 0.01
"""Part by which the error of what was not fitted must fall for a change to be made."""

SLACK = 0.01
"""Part by which the error of what was learnt from may rise."""

MOST = 5
"""Changes of one revision; more of them are another vocabulary."""

_CONFLICT = "W204"

Score = Callable[[Mapping[str, str]], tuple[float, float]]
"""From new texts of files, by their names, to the errors of what was fitted and of what was
not; not finite where there is none."""


class RuleChange(Struct, frozen=True):
    """A change of rules that was made.

    Attributes:
        kind: "conclusion", "drop" or "add".
        file: Name of the file.
        text: Its whole new text, with this change and those before it.
        diff: From its text before this change, as a unified diff.
        errors: Of what was fitted and of what was not, after it.
        sentence: What it is, and what it brought.
    """

    kind: str
    file: str
    text: str
    diff: str
    errors: tuple[float, float]
    sentence: str


def revise(
    scene: Scene,
    rules: str,
    score: Score,
    *,
    start: Mapping[str, str] = MappingProxyType({}),
    gain: float = GAIN,
    slack: float = SLACK,
    most: int = MOST,
) -> list[RuleChange]:
    """Return the changes of rules that reduce the error of data that was not fitted.

    In each round every candidate is scored and the best one taken: a conclusion moved to the
    next word, a rule removed, or a rule added for a tissue of which little is said. Every text
    that is scored passes ``check`` and adds no contradiction.

    Args:
        rules: Name of the rules.
        score: Errors with new texts; called first with those of the start.
        start: Texts of files that were changed before.
        gain: Part by which the error of data that was not fitted must fall.
        slack: Part by which the error of fitted data may rise.
        most: Largest number of changes.

    Raises:
        KeyError: There are no rules of that name.
    """
    key = s.key_of(rules)
    before, texts = score(start), dict(start)
    changes: list[RuleChange] = []
    while len(changes) < most:
        now = reread(scene, texts) if texts else scene
        best = _best(scene, _candidates(now, key), texts, score, before[0] * (1.0 + slack))
        if best is None or not best[1][1] < before[1] * (1.0 - gain):
            break
        candidate, errors = best
        (file, text), *_ = apply([candidate.edit]).items()
        old = candidate.edit.span.source.text
        sentence = (
            f"{candidate.what}: the error of rows that it was not fitted to falls "
            f"from {before[1]:.3g} to {errors[1]:.3g}"
        )
        changes.append(
            RuleChange(candidate.kind, file, text, _diff(file, old, text), errors, sentence)
        )
        texts[file], before = text, errors
    return changes


def _candidates(scene: Scene, key: str) -> list[Candidate]:
    texts = RuleTexts.of(scene, key)
    return [*other_conclusions(texts), *dropped(texts), *added(texts, key)]


def _best(
    scene: Scene,
    candidates: Iterable[Candidate],
    texts: Mapping[str, str],
    score: Score,
    limit: float,
) -> tuple[Candidate, tuple[float, float]] | None:
    """Return the candidate with the least error of what was not fitted, and both its errors.

    Args:
        limit: The largest error of what was learnt from.
    """
    best: tuple[Candidate, tuple[float, float]] | None = None
    conflicts = _conflicts(scene, texts) or 0
    for candidate in candidates:
        tried = {**texts, **apply([candidate.edit])}
        found = _conflicts(scene, tried)
        if found is None or found > conflicts:
            continue
        errors = score(tried)
        if errors[0] <= limit and (best is None or errors[1] < best[1][1]):
            best = candidate, errors
    return best


def _conflicts(scene: Scene, texts: Mapping[str, str]) -> int | None:
    """Return how often rules contradict one another; None if ``check`` finds an error."""
    try:
        return sum(warning.code == _CONFLICT for warning in warnings_of(scene, texts))
    except CompileError:
        return None


def _diff(file: str, old: str, new: str) -> str:
    """Return a unified diff of two texts."""
    lines = unified_diff(old.splitlines(), new.splitlines(), file, file, lineterm="")
    return "".join(f"{line}\n" for line in lines)


WEAK = 0.5
"""A quantity for which no rule is truer than this may get a rule more."""

_WORDS = 3  # that a new rule may conclude: those nearest to what holds without it


def added(texts: RuleTexts, key: str) -> Iterator[Candidate]:
    """Yield new rules for what tissues in use are, where the present ones hardly fire.

    Args:
        key: Their name in small letters.
    """
    seen: set[str] = set()
    for use in used_tissues(texts.scene):
        if use.rules != key or not texts.nodes:
            continue
        for quantity in use.quantities:
            given = use.tissue.given[quantity]
            strongest = max((fired.degree for fired in given.fired), default=0.0)
            if strongest >= WEAK:
                continue
            for rule, tissue in _rules(texts, use, quantity):
                if rule not in seen:
                    seen.add(rule)
                    what = f'the rule "{rule}" is added: no rule applies strongly to {tissue}'
                    yield Candidate("add", appended(texts, rule), what)


def _rules(texts: RuleTexts, use: Use, quantity: str) -> Iterator[tuple[str, str]]:
    """Yield the texts of rules for one tissue, with its name."""
    words = texts.scene.vocabulary
    named = words.quantities[quantity].named
    spelling = texts.spelling(named, "quantity", quantity)
    name = spelt(texts.scene.declarations.of("quantity")[quantity].name)
    place = named.scale.axis.to_scale(use.tissue.given[quantity].value)
    for condition in _conditions(texts, use, quantity):
        tests = " and ".join(_test(texts, part) for part in atoms(condition))
        for word in nearest(place, dict(named.scale.words), _WORDS):
            yield f"if {tests} then {name} is {spelling[word]}", use.tissue.name


def _conditions(texts: RuleTexts, use: Use, quantity: str) -> Iterator[Condition]:
    """Yield conditions that are true of a tissue and that no rule on the quantity has.

    Each of its words alone, and together those of all properties that rules on the quantity
    ask about.
    """
    about = [
        rule
        for rule in texts.rules.base.rules
        if any(part.quantity == quantity for part in rule.conclusions)
    ]
    taken = {canonical(rule.condition) for rule in about}
    asked = {part.property for part in chain(*(atoms(rule.condition) for rule in about))}
    tests = [_is(texts, fact.property, fact.number) for fact in use.tissue.facts]
    together = tuple(test for test in tests if test.property in asked)
    conditions: list[Condition] = [*tests]
    if len(together) > 1:
        conditions.append(And(together))
    yield from (one for one in conditions if canonical(one) not in taken)


def _is(texts: RuleTexts, key: str, number: float) -> Is:
    """Return the test that is truest of a number."""
    scale = texts.scene.vocabulary.properties[key].scale
    place = scale.axis.to_scale(number)
    word = max(scale.words, key=lambda one: scale.words[one].degree(place))
    return Is(key, Word(word, scale.words[word]))


def _test(texts: RuleTexts, test: Is) -> str:
    named = texts.scene.vocabulary.properties[test.property]
    spelling = texts.spelling(named, "property", test.property)
    name = spelt(texts.scene.declarations.of("property")[test.property].name)
    return f"{name} is {spelling[test.word.text]}"
