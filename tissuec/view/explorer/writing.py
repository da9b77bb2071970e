"""Numbers as the page reads them."""

from pathlib import Path

from tissuec.core.source import Span


def short_place(span: Span) -> str:
    """Return file and line without folders, which tell nothing to whom a page is sent."""
    return f"{Path(span.source.name).name}:{span.line}"
