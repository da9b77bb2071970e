"""Sentences of the script, from calls such as ``move("tip", by=(0, 0, 0.01))``.

Numbers in calls are in SI units. Which unit they have is what the verb asks its clauses for.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from tissuec.compiler.sentences import SentenceOrder
from tissuec.core.units import NUMBER, Dimension, written_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.overrides import Given, without_unit
from tissuec.script.verbs import VERBS

STEADY = "constant speed"  # of motions for which no profile is given


def joined(verb: str, words: Sequence[str], clauses: Mapping[str, Given]) -> str:
    """Return a sentence whose numbers have no units yet.

    Args:
        verb: The verb.
        words: What follows the verb.
        clauses: Values by joining word; an underscore behind a word of Python is left out.

    Raises:
        ValueError: A value is no text, number or vector.
    """
    parts = [verb, *words]
    for word, value in clauses.items():
        parts += [word.rstrip("_"), without_unit(value, word)]
    if "using" not in clauses and _needs_profile(verb, parts):
        parts.append(f"using {STEADY}")
    return " ".join(parts)


def with_units(
    sentence: s.Sentence, bare: Sequence[str], dimensions: Mapping[str, Dimension]
) -> str:
    """Return the text of a sentence whose bare numbers have the units that were asked for.

    Args:
        sentence: The sentence.
        bare: Joining words of clauses with numbers in SI units.
        dimensions: Of the clauses that the verb asked for.
    """
    span = sentence.span
    text, begun = "", span.start
    for clause in sentence.clauses:
        if clause.word in bare:
            unit = written_unit(dimensions.get(clause.word, NUMBER))
            text += f"{span.source.text[begun : clause.span.end]} {unit}".rstrip()
            begun = clause.span.end
    return text + span.source.text[begun : span.end]


class UnitsOrder(SentenceOrder):
    """An order in which some clauses have numbers in SI units.

    Attributes:
        dimensions: What the verb asked these clauses for.
    """

    def __init__(self, bare: Sequence[str], sentence: s.Sentence, *more: Any):
        super().__init__(sentence, *more)
        self._bare, self.dimensions = bare, dict[str, Dimension]()

    def vector(self, word: str, dimension: Dimension) -> Floats:
        if word in self._bare:
            return self._amount(word, dimension)
        return super().vector(word, dimension)

    def number(self, word: str, dimension: Dimension) -> float:
        if word in self._bare:
            return float(self._amount(word, dimension))
        return super().number(word, dimension)

    def _amount(self, word: str, dimension: Dimension) -> Floats:
        self.dimensions[word] = dimension
        return self._value(word).amount


def _needs_profile(verb: str, parts: Sequence[str]) -> bool:
    """Return whether every form of a verb with the same clauses names a profile."""
    written = set(parts) - {verb}
    forms = [form.split() for form in VERBS[verb].forms if written & set(form.split())]
    return bool(forms) and all("PROFILE" in form for form in forms)
