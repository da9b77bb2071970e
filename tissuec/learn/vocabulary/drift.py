"""Changes of words from their original places."""

from collections.abc import Iterator

from msgspec import Struct

from tissuec.core.units import show
from tissuec.fuzzy.scale import Scale
from tissuec.fuzzy.sets import Gaussian, Shape
from tissuec.scene.words.phrases import NamedScale
from tissuec.scene.words.vocabulary import Vocabulary

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
