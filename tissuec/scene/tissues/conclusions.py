"""Conclusions of rules about a tissue, where nothing is written, with their reasons."""

from collections.abc import Collection

from tissuec.core.errors import Note
from tissuec.fuzzy.rulebase import Firing, Inference, NoRule
from tissuec.scene.model import AssignedQuantity, Fired
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.idle_words import Answers
from tissuec.scene.tissues.quantities import QUANTITIES, exclude, rivals
from tissuec.scene.words.vocabulary import RulesBlock, Vocabulary


def conclude(
    rules: RulesBlock,
    vocabulary: Vocabulary,
    answers: Answers,
    said: Collection[str],
    given: dict[str, AssignedQuantity],
    missing: dict[str, str],
    findings: Findings,
) -> None:
    """Add what rules conclude where nothing is written.

    Args:
        answers: Conclusions of the rules for the words of a tissue.
        said: Quantities that written entries replace.
        given: Numbers of the tissue, to which conclusions are added.
        missing: Takes quantities that no rule concludes, with the reason.
    """
    for key, answer in answers.items():
        if key in said:
            continue
        if isinstance(answer, NoRule):
            missing[key] = why(rules, answer)
            continue
        given[key] = _concluded(rules, vocabulary, key, answer)
        for rival in given.keys() & set(rivals(key)):
            if not exclude(key, rival):
                continue
            findings.reject(
                "TIS306",
                f'the rules conclude "{QUANTITIES[rival].name}" and '
                f'"{QUANTITIES[key].name}", which exclude each other',
                given[key].span,
                notes=(Note("the other entry", given[rival].span),),
            )


def _concluded(
    rules: RulesBlock, vocabulary: Vocabulary, key: str, answer: Inference
) -> AssignedQuantity:
    scale = vocabulary.quantities[key]
    fired = sorted(answer.fired, key=lambda firing: -firing.degree)
    shown = tuple(
        Fired(f.word, f.degree, _atoms(f) + _moved(f), rules.spans[f.rule]) for f in fired
    )
    if shown:
        span = shown[0].span
    else:
        assert scale.otherwise is not None
        span = scale.otherwise.span
    return AssignedQuantity(
        QUANTITIES[key],
        answer.value,
        scale.spread,
        scale.length,
        answer.source,
        span,
        shown,
    )


def why(rules: RulesBlock, answer: NoRule) -> str:
    """Return the reason why rules conclude nothing."""
    if not answer.silent:
        return f"no rule of {rules.name} concludes it"
    if any(firing.degree > 0.0 for firing in answer.silent):
        return f"no rule of {rules.name} holds to more than a negligible degree for these words"
    if answer.missing:
        unsaid = ", ".join(answer.missing)
        first = next(firing for firing in answer.silent if firing.missing)
        return (
            f"no rule of {rules.name} fires; the tissue does not say: {unsaid} (the first rule "
            f"that uses it is at {rules.spans[first.rule].place})"
        )
    return f"no rule of {rules.name} fires for these words"


def _moved(firing: Firing) -> str:
    """Return the shift of a word by a gradual rule: ``; moved 25 % outward``."""
    share = 100.0 * firing.progress
    return f"; moved {share:.0f} % outward" if share > 0.0 else ""


def _atoms(firing: Firing) -> str:
    """Return the tests of a fired rule with their degrees: ``weight not low 0.80, …``."""
    return ", ".join(
        f"{atom.property} not {atom.word} {1.0 - atom.degree:.2f}"
        if atom.negated
        else f"{atom.property} {atom.word} {atom.degree:.2f}"
        for atom in firing.atoms
        if atom.degree is not None
    )
