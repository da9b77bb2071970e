"""Scenes with further sentences in their scripts and other values of params, as text."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tissuec.core.errors import TissueError
from tissuec.core.names import key_of
from tissuec.scene.model import Scene
from tissuec.scene.request import Request


class _Edit(NamedTuple):
    """A piece of text for a part of the source.

    Attributes:
        start, stop: Offsets of the part.
    """

    start: int
    stop: int
    text: str


def recorded(scene: Scene, request: Request, sentences: Sequence[str]) -> str:
    """Return the text of a scene with sentences at the end of its script.

    Values that were given from outside are written into the params of the text. A comment at
    the end names those that have no param in it, as options of ``tissuec run``.

    Args:
        scene: The scene.
        request: What it was compiled from.
        sentences: With their times.

    Raises:
        TissueError: The script stands in another file.
    """
    text = request.source.text
    edits = [*_values(scene, request), *_script(scene, request, sentences)]
    for edit in sorted(edits, reverse=True):
        text = text[: edit.start] + edit.text + text[edit.stop :]
    return text


def _values(scene: Scene, request: Request) -> Iterator[_Edit]:
    """Yield the edits that write given values of params into the text."""
    text, params = request.source.text, scene.constants.parameters()
    spans = {
        parameter.item.name.key: parameter.item.value.span
        for parameter in params
        if parameter.item.value.span.source.text == text
    }
    for given in request.overrides:
        name, _, value = (part.strip() for part in given.partition("="))
        span = spans.get(key_of(name.strip('"')))
        if span is not None:
            yield _Edit(span.start, span.end, value)
        else:
            yield _Edit(len(text), len(text), f'\n# Run with: --set "{given}"\n')


def _script(scene: Scene, request: Request, sentences: Sequence[str]) -> Iterator[_Edit]:
    """Yield the edit that adds sentences to the script."""
    source, block = request.source, scene.declarations.single.get("script")
    lines = "".join(f"  {sentence}\n" for sentence in sentences)
    if not lines:
        return
    if block is None:
        end = len(source.text.rstrip())
        yield _Edit(end, len(source.text), f"\n\nscript {{\n{lines}}}\n")
        return
    if block.span.source.text != source.text:
        raise TissueError(
            f"the script stands in {block.span.source.name}, which the scene uses; move it "
            f"into {source.name} to record what is ordered"
        )
    close = block.span.end - 1
    yield _Edit(len(source.text[:close].rstrip()), close, f"\n{lines}")
