"""Scenes with further sentences in their scripts and other values, as text."""

from collections.abc import Sequence

from msgspec.structs import replace

from tissuec.core.errors import TissueError
from tissuec.core.source import Source, Span
from tissuec.lang import syntax as s
from tissuec.scene.overrides.entries import read_override, written_place
from tissuec.scene.program.declarations import Declarations, collect
from tissuec.scene.program.imports import load
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request


def recorded(request: Request, sentences: Sequence[str]) -> str:
    """Return the text of a scene with sentences at the end of its script.

    Values that were given from outside are written into params and entries of the text. A
    comment at the end names those that belong into files that it uses, as options of ``tissuec
    run``.

    Args:
        request: What the scene was compiled from.
        sentences: With their times.

    Raises:
        TissueError: The script is in another file.
    """
    left: list[str] = []
    for given in request.overrides:
        text = _with_value(request, given)
        if text is None:
            left.append(given)
        else:
            request = _with_text(request, text)
    if sentences:
        request = _with_text(request, _with_sentences(request, sentences))
    return "\n".join(
        [request.source.text, *(f'# Run with: --set "{given}"\n' for given in left)]
    )


def _with_text(request: Request, text: str) -> Request:
    return replace(request, source=replace(request.source, text=text))


def _declared(request: Request) -> Declarations:
    findings = Findings()
    return collect(load(request.source, request.libraries, findings, request.files), findings)


def _with_value(request: Request, given: str) -> str | None:
    """Return the text with a value in it; None if it belongs into another file."""
    declarations, findings = _declared(request), Findings()
    override = read_override(given, findings)
    item, key = override.item, override.item.name.key
    param = declarations.of("param").get(key)
    if param is not None and isinstance(param.item, s.Assign) and not override.owners:
        assert isinstance(item, s.Assign)
        return _replaced(request.source, param.item.value.span, item.value.span.text)
    place = written_place(override, declarations, findings)
    entry = override.entry if place.start < place.end else f"\n  {override.entry}\n"
    return _replaced(request.source, place, entry)


def _replaced(source: Source, place: Span, text: str) -> str | None:
    """Return the text of a source with other text at a place; None if that is elsewhere."""
    if place.source.text != source.text:
        return None
    before, after = source.text[: place.start], source.text[place.end :]
    return (before if place.start < place.end else before.rstrip()) + text + after


def _with_sentences(request: Request, sentences: Sequence[str]) -> str:
    """Return the text with sentences at the end of its script."""
    source, block = request.source, _declared(request).single.get("script")
    lines = "".join(f"  {sentence}\n" for sentence in sentences)
    if block is None:
        return f"{source.text.rstrip()}\n\nscript {{\n{lines}}}\n"
    close = block.span.end - 1
    text = _replaced(source, Span(block.span.source, close, close), f"\n{lines}")
    if text is None:
        raise TissueError(
            f"the script is in {block.span.source.name}, which the scene uses; move it "
            f"into {source.name} to record what is ordered"
        )
    return text
