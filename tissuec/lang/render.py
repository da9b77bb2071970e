"""Diagnostics for people, with an excerpt of the text, and for programs."""

from typing import Any

from tissuec.core.errors import Diagnostic
from tissuec.core.rendering import render
from tissuec.core.source import Span

__all__ = ["as_dict", "render"]


def as_dict(diagnostic: Diagnostic) -> dict[str, Any]:
    """Return a diagnostic as plain values for JSON; lines and columns count from 1."""
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        **_place(diagnostic.span),
        "hint": str(diagnostic.hint),
        "edits": [{"text": edit.text, **_place(edit.span)} for edit in diagnostic.edits],
        "notes": [{"message": note.message, **_place(note.span)} for note in diagnostic.notes],
    }


def _place(span: Span | None) -> dict[str, Any]:
    if span is None:
        return dict.fromkeys(("file", "line", "column", "end_line", "end_column"))
    end = Span(span.source, span.end, span.end)
    return {
        "file": span.source.name,
        "line": span.line,
        "column": span.column,
        "end_line": end.line,
        "end_column": end.column,
    }
