"""Rules that may be added: for tissues of which the rules say little."""

from collections.abc import Iterator
from itertools import chain

from tissuec.fuzzy.conditions import And, Condition, Is, atoms, canonical
from tissuec.fuzzy.sets import Word
from tissuec.learn.vocabulary.candidates import Candidate, RuleTexts, appended, nearest
from tissuec.learn.vocabulary.scale_texts import spelt
from tissuec.learn.vocabulary.used import Use, used_tissues

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
