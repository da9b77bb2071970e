"""Vocabularies whose words move together: how far, and the numbers that rules then give.

Each number moves a corner of one scale (or the width of a bell); zero is the expert's text.
Rules and tissues are read anew with the moved words, by the functions that compile a scene, so
that hedges, operators and facts given as words mean what they mean there. Derivatives are
carried along by the same functions; minimum and maximum choose a branch.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.core.units import show
from tissuec.fuzzy.duals import slopes_of
from tissuec.fuzzy.rulebase import Inference
from tissuec.fuzzy.scale import Scale
from tissuec.fuzzy.sets import Gaussian, Shape
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.scale_texts import CLOSE, read_form
from tissuec.learn.vocabulary.scales import MovingScale
from tissuec.learn.vocabulary.texts import TextEdit, apply, scale_edits
from tissuec.learn.vocabulary.used import Use, used_tissues
from tissuec.model.network import Floats
from tissuec.scene.model import Scene
from tissuec.scene.program.parameters import Constants
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.words.phrases import NamedScale
from tissuec.scene.words.vocabulary import RulesBlock, RulesReader, Vocabulary
from tissuec.script.fit_problem import WORDS, Adjust

_NOTHING = 0.0005  # of the range; less is shown as 0.0 %


class Drift(Struct, frozen=True):
    """Displacement of one word.

    Attributes:
        scale: Name of the property or quantity.
        before, after: Value of the word, in SI units.
        centre: How far the middle of its core moved up, as a part of the range.
        most: How far that corner moved which moved most, likewise; of a bell, of the places
            one sigma beside the mean.
        sentence: The same in words.
    """

    scale: str
    word: str
    before: float
    after: float
    centre: float
    most: float
    sentence: str


def drift(named: NamedScale, moved: Scale) -> Iterator[Drift]:
    """Yield how far each word of a scale moved."""
    axis = named.scale.axis
    width = axis.bounds[1] - axis.bounds[0]
    for word, old in named.scale.words.items():
        new = moved.words[word]
        before, after = axis.value_of(old), axis.value_of(new)
        centre = (new.middle - old.middle) / width
        moves = [(b - a) / width for a, b in zip(_marks(old), _marks(new), strict=False)]
        most = max(moves, key=abs)
        seen = f"{show(before, named.dimension)} to {show(after, named.dimension)}"
        if abs(most) < _NOTHING:
            sentence = f'"{word}" of {named.name} stays'
        else:
            sentence = (
                f'"{word}" of {named.name} moves {_way(centre)}, from {seen}; '
                f"its corners by up to {abs(most):.1%} of the range"
            )
        yield Drift(named.name, word, before, after, centre, most, sentence)


def drifts_between(before: Vocabulary, after: Vocabulary) -> list[Drift]:
    """Return the displacement of each word of the scales that differ in two vocabularies."""
    scales = [
        *((scale, after.properties[key]) for key, scale in before.properties.items()),
        *((one.named, after.quantities[key].named) for key, one in before.quantities.items()),
    ]
    return [
        moved
        for old, new in scales
        if old.scale.words != new.scale.words
        for moved in drift(old, new.scale)
    ]


def _way(part: float) -> str:
    return f"{'up' if part > 0.0 else 'down'} by {abs(part):.1%} of the range"


def _marks(shape: Shape) -> tuple[float, ...]:
    """Return the places whose movement counts."""
    if isinstance(shape, Gaussian):
        return shape.mean - shape.sigma, shape.mean, shape.mean + shape.sigma
    return shape.xs


class MovingVocabulary:
    """A vocabulary as a function of the numbers that move its words.

    Args:
        words: The program that declares the vocabulary.
        keys: Properties and quantities whose words move, by lower-case name.
        frozen: Words that stay where they are, by the name of their scale.

    Attributes:
        names: Names of the numbers, such as "hardness: peak of medium".

    Raises:
        ValueError: The vocabulary has no such scale, or the scale no such word.
    """

    def __init__(
        self,
        words: Scene | ResolvedProgram,
        keys: Iterable[str],
        frozen: Mapping[str, Collection[str]] | None = None,
    ):
        self._words = words
        self.scales: list[MovingScale] = []
        stay = {s.key_of(k): [s.key_of(w) for w in v] for k, v in (frozen or {}).items()}
        for key in dict.fromkeys(keys):
            self.scales.append(self._scale(key, stay.get(key, ())))
        self.names = tuple(name for scale in self.scales for name in scale.names)

    @property
    def size(self) -> int:
        """Return the number of these numbers."""
        return len(self.names)

    def vocabulary(self, theta: Floats, *, total: int | None = None) -> Vocabulary:
        """Return the vocabulary with words moved; its rules are those of the program.

        Args:
            theta: Parameters of words, dimensionless, shape (number,).
            total: Where derivatives are wanted: the number of all parameters, of which those
                of words are the first. Corners are dual numbers then.
        """
        words = self._words.vocabulary
        properties, quantities = dict(words.properties), dict(words.quantities)
        for scale, now in zip(self.scales, self.moved(theta, total), strict=True):
            key, named = scale.form.key, replace(scale.form.named, scale=now)
            if key in properties:
                properties[key] = named
            else:
                quantities[key] = replace(quantities[key], named=named)
        return replace(words, properties=properties, quantities=quantities)

    def drift(self, theta: Floats) -> list[Drift]:
        """Return the displacement of each word, in the order of scales and words."""
        return [
            change
            for scale, moved in zip(self.scales, self.moved(theta, None), strict=True)
            for change in drift(scale.form.named, moved)
        ]

    def texts(self, theta: Floats) -> dict[str, str]:
        """Return the new text of each file in which words moved, by its name.

        Only numbers of words that moved are replaced; of evenly spaced scales, the list.
        """
        return apply(self.edits(theta))

    def edits(self, theta: Floats, close: float = CLOSE) -> list[TextEdit]:
        """Return the edits of ``texts``.

        Args:
            theta: Parameters of words, dimensionless, shape (number,).
            close: Allowed deviation of a written place, as a part of the smallest gap.
        """
        parts = zip(self.scales, self._parts(theta), strict=True)
        return [
            edit
            for scale, part in parts
            if np.any(part)
            for edit in scale_edits(scale, part, close)
        ]

    def moved(self, theta: Floats, total: int | None) -> list[Scale]:
        """Return the scales with their words moved; see ``vocabulary``."""
        parts = zip(self.scales, self._parts(theta), strict=True)
        return [scale.scale(part, total=total) for scale, part in parts]

    def _scale(self, key: str, frozen: Collection[str]) -> MovingScale:
        words = self._words
        kind = "property" if key in words.vocabulary.properties else "quantity"
        declared = words.declarations.of(kind).get(key)
        if declared is None:
            raise ValueError(f'"{key}" is neither a property nor a quantity of the vocabulary')
        named = _named(words.vocabulary, key)
        for word in frozen:
            if word not in named.scale.words:
                raise ValueError(f'"{word}" is not a word for {named.name}')
        form = read_form(declared, named, words.constants)
        return MovingScale(form, sum(scale.size for scale in self.scales), frozen)

    def _parts(self, theta: Floats) -> Sequence[Floats]:
        """Return the numbers of each scale."""
        theta = np.asarray(theta, dtype=float)
        if theta.shape != (self.size,):
            raise ValueError(f"the words move by {self.size} numbers, not {theta.shape}")
        return [theta[scale.start : scale.start + scale.size] for scale in self.scales]


def _named(vocabulary: Vocabulary, key: str) -> NamedScale:
    if key in vocabulary.properties:
        return vocabulary.properties[key]
    return vocabulary.quantities[key].named


SIGMA = 0.5
"""How far numbers are expected to be from the expert's words, where nothing else is said."""

Pair = tuple[str, str]
"""A tissue and a quantity, both by their names in small letters."""


class NoAnswer(TissueError):
    """With these words no rule speaks for a quantity that the rules gave before."""


class RuleOutputs(NamedTuple):
    """Numbers that rules give, with their derivatives.

    Attributes:
        pairs: Tissues and quantities.
        values: In SI units, shape (pair,).
        slopes: Derivatives by the numbers, shape (pair, number).
    """

    pairs: list[Pair]
    values: Floats
    slopes: Floats


class WordsModel(MovingVocabulary):
    """Numbers that the rules of a scene give, as a function of the parameters of words.

    Args:
        scene: The scene.
        adjusts: Entries of a ``learn`` block; those of ``WORDS`` count, each for one scale.
        frozen: Words that stay where they are, by the name of their scale.

    Attributes:
        names: Of each number, such as "hardness: peak of medium".
        pairs: Tissues that the scene uses, with their quantities that rules give.

    Raises:
        ValueError: The vocabulary has no such scale, or the scale no such word.
    """

    def __init__(
        self,
        scene: Scene,
        adjusts: Sequence[Adjust],
        *,
        frozen: Mapping[str, Collection[str]] | None = None,
    ):
        self._scene = scene
        chosen = (s.key_of(one.of) for one in adjusts if one.what == WORDS)
        super().__init__(scene, chosen, frozen)
        self._uses = used_tissues(scene)
        self.pairs: list[Pair] = [
            (use.key, quantity) for use in self._uses for quantity in use.quantities
        ]

    def given(self, theta: Floats) -> dict[Pair, float]:
        """Return the numbers that rules give with words moved by ``theta``, in SI units.

        Raises:
            NoAnswer: No rule fires any more where one did.
        """
        return self._answers(theta, None)

    def linearised(self, theta: Floats) -> RuleOutputs:
        """Return the numbers that rules give and their derivatives; raises like ``given``."""
        answers = self._answers(theta, self.size)
        values = np.array([float(value) for value in answers.values()])
        slopes = [slopes_of(value, self.size) for value in answers.values()]
        return RuleOutputs(self.pairs, values, np.reshape(slopes, (len(values), self.size)))

    def jacobian(self, theta: Floats) -> tuple[list[Pair], Floats]:
        """Return the derivatives of the logarithms of what rules give; raises like ``given``.

        Returns:
            Tissues and quantities, and shape (pair, number). Of negative values, the logarithms
            of their amounts are meant; a value of zero has none, and its row is not finite.
        """
        pairs, values, slopes = self.linearised(theta)
        with np.errstate(divide="ignore", invalid="ignore"):
            return pairs, slopes / values[:, None]

    def prior(self, theta: Floats, sigma: float = SIGMA) -> tuple[Floats, Floats]:
        """Return residuals that pull words to their original places, and their derivatives.

        Args:
            theta: Parameters of words, dimensionless, shape (number,).
            sigma: Standard deviation of the parameters.

        Returns:
            Dimensionless, shapes (number,) and (number, number).
        """
        return np.asarray(theta, dtype=float) / sigma, np.eye(self.size) / sigma

    # --- inference ----------------------------------------------------------------------------

    def _answers(self, theta: Floats, total: int | None) -> dict[Pair, float]:
        scene = self._scene
        vocabulary = self.vocabulary(theta, total=total)
        # Warnings were given when the scene was read.
        scope = Constants(scene.declarations, scene.constants.overrides, Findings())
        rules: dict[str, RulesBlock] = {}
        answers: dict[Pair, float] = {}
        for use in self._uses:
            if use.rules not in rules:
                declared = scene.declarations.of("rules")[use.rules]
                reader = RulesReader(declared.name, declared.item, vocabulary, scope)
                rules[use.rules] = reader.read()
            said = rules[use.rules].base.infer(use.facts(vocabulary, scope))
            for quantity in use.quantities:
                answer = said[quantity]
                if not isinstance(answer, Inference):
                    raise NoAnswer(_silence(use, quantity))
                answers[use.key, quantity] = answer.value
        return answers


def _silence(use: Use, quantity: str) -> str:
    return f"with these words, no rule gives the {quantity} of {use.key}"
