"""How words moved and rules changed: from the texts before and after."""

from collections.abc import Iterable, Iterator, Mapping
from difflib import unified_diff

from tissuec.learn.vocabulary.drift import Drift, drifts_between
from tissuec.learn.vocabulary.reread import reread
from tissuec.scene.model import Scene


def drifts(scene: Scene, texts: Mapping[str, str]) -> list[Drift]:
    """Return how far each word moved whose file has a new text.

    Args:
        texts: New texts by the names that the scene has for their files.
    """
    if not texts:
        return []
    return drifts_between(scene.vocabulary, reread(scene, texts).vocabulary)


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
