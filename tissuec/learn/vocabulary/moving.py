"""Scales of a vocabulary whose words move together.

Each number moves a corner of one scale (or the width of a bell); zero is the expert's text.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
from msgspec.structs import replace

from tissuec.fuzzy.scale import Scale
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.drift import Drift, drift
from tissuec.learn.vocabulary.edits import TextEdit, apply
from tissuec.learn.vocabulary.numerals import CLOSE
from tissuec.learn.vocabulary.scale_texts import read_form
from tissuec.learn.vocabulary.scales import MovingScale
from tissuec.learn.vocabulary.texts import scale_edits
from tissuec.model.network import Floats
from tissuec.scene.model import Scene
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.words.phrases import NamedScale
from tissuec.scene.words.vocabulary import Vocabulary


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
