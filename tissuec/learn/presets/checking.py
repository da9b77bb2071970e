"""Checks of a preset: no new warnings, and the learnt numbers."""

from collections.abc import Collection, Mapping, Sequence
from math import isclose
from pathlib import Path

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.names import key_of
from tissuec.core.source import Source
from tissuec.learn.presets.tissues import WHOLE, Draft, LearntNumber, changed_constants
from tissuec.pipeline import check_request, read_words
from tissuec.scene.model import AssignedQuantity, Tissue
from tissuec.scene.program.imports import Files, read_source
from tissuec.scene.request import Request

ROUNDING = 1e-12  # of a number that is written in full
WRITTEN = 0.6e-5  # of a learnt one: half a unit of its sixth digit


class Pending(Files):
    """Files of which some are not written yet, by their paths."""

    def __init__(self, texts: Mapping[Path, str]):
        self._texts = {path.resolve(): text for path, text in texts.items()}

    def has(self, path: Path) -> bool:
        return path.resolve() in self._texts or super().has(path)

    def read(self, path: Path, name: str) -> Source:
        text = self._texts.get(path.resolve())
        return read_source(path, name) if text is None else Source(name, text, path)


def mistakes(
    text: str,
    target: Path,
    beside: Mapping[str, str],
    drafts: Sequence[Draft],
    *,
    params: Mapping[str, LearntNumber],
    moved: bool,
    known: Collection[str] = (),
) -> tuple[Diagnostic, ...] | str:
    """Return the errors of a preset; empty if there are none.

    Args:
        text: Text of the preset.
        target: Its file, at which it must be valid by itself.
        beside: Texts of files that are written with it, by their names.
        drafts: Tissues of the preset.
        params: Numbers of forces by the names of their params.
        moved: Whether words moved, so that rules give other numbers than before.
        known: Codes of warnings that the scene itself has.
    """
    files = Pending({target.parent / name: one for name, one in beside.items()})
    source = Source(target.name, text, target)
    request = Request(source, files=files)
    try:
        compiled, warnings = check_request(request)
        if compiled is not None:
            return f'"{target.name}" would be a scene'
        new = tuple(one for one in warnings if one.code not in known)
        words, _ = read_words(request)
    except CompileError as error:
        return error.diagnostics
    for draft in drafts:
        if (problem := _differs(words.tissues[key_of(draft.name)], draft, moved)) is not None:
            return f"{draft.name} would have another {problem}"
    values = {one.name: float(one.value.amount) for one in words.constants.parameters()}
    for name, number in params.items():
        if not isclose(values[name], number.value, rel_tol=WRITTEN):
            return f"{name} would have another value"
    return new or ""


def _differs(tissue: Tissue, draft: Draft, moved: bool) -> str | None:
    """Return the difference of a tissue from its draft; None if all is as learnt."""
    for name, old in draft.original.given.items():
        if old.spread == WHOLE and tissue.given.get(name) is None:
            continue  # which no tissue can say as a number
        if moved and old.how != "written" and name not in draft.numbers:
            continue
        if not _is_same(tissue.given.get(name), old, draft.numbers.get(name)):
            return name
    for word, law in draft.original.written_laws.items():
        new = tissue.written_laws.get(word)
        if new is None or (law.law is None) != (new.law is None):
            return word
        if not changed_constants(law, draft.constants) and new.force != law.force:
            return word
    return None


def _is_same(
    new: AssignedQuantity | None, old: AssignedQuantity, number: LearntNumber | None
) -> bool:
    if new is None or new.spread != old.spread or (new.length is None) != (old.length is None):
        return False
    if new.length is not None and old.length is not None and new.length != old.length:
        return False
    if number is None:
        return new.value == old.value or isclose(new.value, old.value, rel_tol=ROUNDING)
    return isclose(new.value, number.value, rel_tol=WRITTEN)
