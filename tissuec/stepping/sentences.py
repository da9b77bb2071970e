"""Sentences of the script, from calls such as ``move("tip", by=(0, 0, 0.01))``.

Numbers in calls are in SI units. Which unit they have is what the verb asks its clauses for.
"""

from collections.abc import Mapping, Sequence
from math import isfinite
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from tissuec.compiler.sentences import SentenceOrder
from tissuec.core.units import NUMBER, Dimension, written_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.script.verbs import VERBS

#: A text as in a script, such as "5 mm"; or one number or three, in SI units.
Clause: TypeAlias = "str | float | Sequence[float]"

STEADY = "constant speed"  # of motions for which no profile is given


def joined(verb: str, words: Sequence[str], clauses: Mapping[str, Clause]) -> str:
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
        parts += [word.rstrip("_"), _written(word, value)]
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


def _written(word: str, value: Clause) -> str:
    """Return a value as a script has it, without a unit."""
    if isinstance(value, str):
        return value
    single = isinstance(value, Real) and not isinstance(value, bool)
    try:
        numbers = np.asarray([value] if single else value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != ((1,) if single else (3,)) or isinstance(value, bool):
        raise ValueError(
            f'{word} = {value!r} is not a text such as "5 mm", a number or a vector'
        )
    if not all(map(isfinite, numbers)):
        raise ValueError(f"{word} = {value!r} is not a usable number")
    texts = [repr(number).removesuffix(".0") for number in numbers.tolist()]
    return texts[0] if single else f"({', '.join(texts)})"


def is_bare(value: Clause) -> bool:
    """Return whether a value has no unit of its own."""
    return not isinstance(value, str)


def _needs_profile(verb: str, parts: Sequence[str]) -> bool:
    """Return whether every form of a verb with the same clauses names a profile."""
    written = set(parts) - {verb}
    forms = [form.split() for form in VERBS[verb].forms if written & set(form.split())]
    return bool(forms) and all("PROFILE" in form for form in forms)
