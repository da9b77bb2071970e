"""How words moved and rules changed: from the texts before and after."""

from collections.abc import Iterable, Iterator, Mapping
from difflib import unified_diff

from tissuec.learn.vocabulary.drift import Drift, drift
from tissuec.learn.vocabulary.reread import reread
from tissuec.scene.model import Scene
from tissuec.scene.vocabulary import Vocabulary


def drifts(scene: Scene, texts: Mapping[str, str]) -> list[Drift]:
    """Return how far each word moved whose file has a new text.

    Args:
        texts: New texts by the names that the scene has for their files.
    """
    if not texts:
        return []
    return drifts_between(scene.vocabulary, reread(scene, texts).vocabulary)


def drifts_between(before: Vocabulary, after: Vocabulary) -> list[Drift]:
    """Return how far each word of the scales moved that differ in two vocabularies."""
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


def sentences(moved: Iterable[Drift]) -> Iterator[str]:
    """Yield sentences about words that moved."""
    return (f"word: {one.sentence}" for one in moved if one.most != 0.0)


def differences(scene: Scene, texts: Mapping[str, str]) -> Iterator[str]:
    """Yield the change of each text as a unified diff."""
    before = {source.name: source.text for source in (*scene.imports, scene.source)}
    yield from unified(before, texts)


def unified(before: Mapping[str, str], texts: Mapping[str, str]) -> Iterator[str]:
    """Yield the change of each text as a unified diff.

    Args:
        before: Old texts by name.
        texts: New ones.
    """
    for name, text in texts.items():
        old, new = before[name].splitlines(True), text.splitlines(True)
        yield "".join(unified_diff(old, new, name, f"{name} (learned)"))
