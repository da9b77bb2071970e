"""What findings propose: sentences with the edits of the text that carry them out."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from msgspec import Struct

from tissuec.core.source import Span

#: What may separate a statement and the next one.
_REST_OF_LINE = re.compile(r"[ \t]*(?:(;)[ \t]*|((?:#[^\n]*)?(?:\n|$)))?")

#: How alike two words must be (of 1) for one to be a misspelling of the other.
_ALIKE = 0.7


class Edit(Struct, frozen=True):
    """A text that a hint proposes in place of another.

    Attributes:
        span: What it replaces; None for the place of the finding.
        old: With no span: what it replaces there; all of it if empty.
    """

    text: str
    span: Span | None = None
    old: str = ""

    def at(self, place: Span) -> "Edit":
        """Return the edit of a finding at this place, with a span."""
        if self.span is not None:
            return self
        start = place.text.lower().find(self.old.lower()) if self.old else -1
        if start < 0:
            return Edit(self.text, place)
        start += place.start
        return Edit(self.text, Span(place.source, start, start + len(self.old)))


class Hint(str):
    """The remedy for a finding, with the edits that it proposes.

    Attributes:
        edits: Alternatives: after any one of them the finding is gone.
    """

    edits: tuple[Edit, ...]

    def __new__(cls, text: str, *edits: Edit) -> "Hint":
        hint = super().__new__(cls, text)
        hint.edits = edits
        return hint


def proposal(text: str, span: Span | None = None) -> Hint:
    """Return a hint ``write "…"``: a text for a place, which is that of the finding if None."""
    return Hint(f'write "{text}"', Edit(text, span))


_LONGEST_WORD = 200  # characters; longer ones are no misspelt names


def insertion(text: str, span: Span) -> Edit:
    """Return the edit that puts a text after a place."""
    return Edit(text, Span(span.source, span.end, span.end))


def removal(place: Span) -> Edit:
    """Return the edit that removes a statement with its separator, or with its line."""
    text, start, end = place.source.text, place.start, place.end
    before = len(text[:start].rstrip(" \t"))
    behind = _REST_OF_LINE.match(text, end)
    assert behind is not None
    if behind[1]:  # a ";"
        end = behind.end()
    elif text[before - 1 : before] == ";":
        start = before - 1
    elif behind[2] is not None and text[before - 1 : before] in ("", "\n"):
        start, end = before, behind.end()
    return Edit("", Span(place.source, start, end))


def leaving_out(text: str, *places: Span) -> Hint:
    """Return a hint whose edits each take one of these statements away."""
    return Hint(text, *map(removal, places))


def one_left(*places: Span) -> Hint:
    """Return a hint whose edits each take one of these clauses out of its sentence."""
    return Hint("remove one of them", *(Edit("", place) for place in places))


def did_you_mean(word: str, known: Iterable[str]) -> Hint:
    """Return a hint ``did you mean "…"?`` for the nearest known word, or an empty one."""
    from difflib import get_close_matches  # late: most runs have no misspelt word

    names = list(known)
    if len(word) > _LONGEST_WORD:  # comparing takes the square of its length
        return Hint("")
    swapped = [name for name in names if sorted(name) == sorted(word)]
    near = swapped or get_close_matches(word, names, n=1, cutoff=_ALIKE)
    if not near:
        return Hint("")
    quoted = near[0] if near[0].startswith('"') else f'"{near[0]}"'
    return Hint(f"did you mean {quoted}?", Edit(near[0], old=word))


def alternatives(
    word: str, known: Iterable[str], *, what: str, meant: Sequence[str] = ()
) -> Hint:
    """Return a hint with the nearest word and then all words, such as for an unknown entry.

    Args:
        word: The unknown word.
        known: The known words.
        what: Introduction of the list, such as "there are".
        meant: Those of them that mean the same; if there are any, none is near by its letters.
    """
    names = list(known)
    near = did_you_mean(word, names)
    if meant:
        quoted = " or ".join(f'"{one}"' for one in meant)
        near = Hint(f"did you mean {quoted}?", *(Edit(one, old=word) for one in meant))
    every = f"{what}: {', '.join(names)}" if names else ""
    return Hint("  ".join(part for part in (near, every) if part), *near.edits)


def nearby_file(path: Path, suffix: str, beside: Path | None = None) -> Hint:
    """Return a hint ``did you mean "…"?`` for the nearest file of its folder, or an empty one.

    Args:
        path: What was written, perhaps without its suffix.
        suffix: Of the files that can be meant, such as ".tis".
        beside: Folder that is left out of the name that is proposed.
    """
    from difflib import get_close_matches  # late: most names are those of files

    try:
        names = [place.name for place in path.parent.glob(f"*{suffix}") if place.is_file()]
    except OSError:
        return Hint("")
    whole = f"{path.name.removesuffix(suffix)}{suffix}"
    near = get_close_matches(whole, names, n=1, cutoff=0.8)
    if not near or not path.name:
        return Hint("")
    old, new = str(path), str(path.with_name(near[0]))
    if beside is not None:
        old, new = (name.replace(f"{beside}/", "") for name in (old, new))
    return Hint(f'did you mean "{new}"?', Edit(new, old=old))
