"""Revision of rules, one change after another, as long as the error of held-out rows falls.

Nearly any change improves the fit to fitted rows; only held-out rows distinguish a better rule
from one that fits the noise.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from difflib import unified_diff
from itertools import chain
from types import MappingProxyType

from msgspec import Struct

from tissuec.core.errors import CompileError
from tissuec.fuzzy.conditions import And, Condition, Is, atoms, canonical
from tissuec.fuzzy.sets import Word
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.candidates import (
    Candidate,
    RuleTexts,
    appended,
    dropped,
    nearest,
    other_conclusions,
)
from tissuec.learn.vocabulary.edits import apply
from tissuec.learn.vocabulary.reread import reread, warnings_of
from tissuec.learn.vocabulary.scale_texts import spelt
from tissuec.learn.vocabulary.used import Use, used_tissues
from tissuec.scene.model import Scene

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
        scene: The scene.
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
        texts: The rules.
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
