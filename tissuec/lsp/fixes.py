"""Quick fixes: the edits that the hints of findings propose, where an editor can make them."""

from collections.abc import Iterable
from pathlib import Path

from msgspec import Struct

from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit
from tissuec.core.resources import library
from tissuec.core.source import Span
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import Checked


class QuickFix(Struct, frozen=True, eq=False):
    """One edit of one finding.

    Attributes:
        title: What the editor shows.
        path: The file that the edit changes.
        place: What it replaces.
        is_preferred: Whether the finding has no other edit.
    """

    title: str
    finding: Diagnostic
    path: Path
    place: Span
    text: str
    is_preferred: bool


def fixes_at(
    path: Path, first: int, last: int, checked: Iterable[Checked], documents: OpenDocuments
) -> list[QuickFix]:
    """Return the edits for findings in some lines of a file, in the order of the findings.

    Edits of shipped files, and of texts that have changed since they were checked, are left
    out.

    Args:
        path: The file.
        first, last: Lines, counted from 0; findings count that share one with them.
        checked: Findings in each open text; they may be about a file that it uses.
        documents: The open texts.
    """
    found: dict[tuple[str, str, str, int, int, str], QuickFix] = {}
    for finding in (one for each in checked for one in each.diagnostics):
        if finding.span is None or not _is_in(finding.span, path, first, last):
            continue
        for fix in (_fix(finding, edit, documents) for edit in finding.edits):
            if fix is not None:
                place = str(fix.path), fix.place.start, fix.place.end
                found.setdefault((finding.code, finding.message, *place, fix.text), fix)
    return list(found.values())


def _is_in(span: Span, path: Path, first: int, last: int) -> bool:
    where = span.source.path
    if where is None or where.resolve() != path.resolve():
        return False
    begin = span.line - 1
    return begin <= last and first <= begin + span.text.count("\n")


def _fix(finding: Diagnostic, edit: Edit, documents: OpenDocuments) -> QuickFix | None:
    place = edit.span
    if place is None or place.source.path is None:
        return None
    path = place.source.path
    is_shipped = library().resolve() in path.resolve().parents
    if is_shipped or documents.read(path, str(path)).text != place.source.text:
        return None
    text = " ".join(edit.text.split())
    title = f'Write "{text}"' if text else f'Remove "{place.one_line}"'
    return QuickFix(title, finding, path, place, edit.text, len(finding.edits) == 1)
