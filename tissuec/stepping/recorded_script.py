"""Scenes with further sentences in their scripts, as text."""

from collections.abc import Sequence

from tissuec.core.errors import TissueError
from tissuec.scene.model import Scene
from tissuec.scene.request import Request


def with_sentences(scene: Scene, request: Request, sentences: Sequence[str]) -> str:
    """Return the text of a scene with sentences at the end of its script.

    Args:
        scene: The scene.
        request: What it was compiled from.
        sentences: With their times.

    Raises:
        TissueError: The script stands in another file.
    """
    source, block = request.source, scene.declarations.single.get("script")
    lines = "".join(f"  {sentence}\n" for sentence in sentences)
    if not lines:
        return source.text
    if block is None:
        return f"{source.text.rstrip()}\n\nscript {{\n{lines}}}\n"
    if block.span.source.text != source.text:
        raise TissueError(
            f"the script stands in {block.span.source.name}, which the scene uses; move it "
            f"into {source.name} to record what is ordered"
        )
    close = block.span.end - 1
    before = source.text[:close].rstrip()
    return f"{before}\n{lines}{source.text[close:]}"
