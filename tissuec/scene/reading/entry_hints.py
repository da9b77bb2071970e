"""Hints about entries that are missing, or that are written in other words than those of the
language: a diameter for a radius.
"""

import re
from collections.abc import Collection, Iterable, Mapping

from tissuec.core.hints import Edit, Hint, alternatives, insertion, proposal
from tissuec.core.source import Span
from tissuec.lang import syntax as s

#: What opens a block, after its head.
_BRACE = re.compile(r"\s*\{")

#: What chooses the value of an entry.
_SIGN = re.compile(r"\s*(?:=|\bis\b)\s*\Z")

#: Entries of meshes and tools by words that other programs have for them.
_MEANT = {
    "centre": "center position location origin middle point",
    "point": "centre center position location origin",
    "normal": "direction facing axis",
    "direction": "normal facing axis",
    "axis": "line shaft",
    "shaft": "axis line",
    "rings": "segments slices divisions",
    "pieces": "segments divisions",
    "sides": "segments around",
    "cell": "spacing resolution size",
}

#: How another size of something round becomes one entry.
_SIZES: dict[str, dict[str, str]] = {
    "radius": dict.fromkeys(("diameter", "thickness", "width", "size", "calibre"), " / 2"),
    "diameter": {"radius": " * 2", **dict.fromkeys(("bore", "calibre", "width", "size"), "")},
    "thickness": {"radius": " * 2", **dict.fromkeys(("diameter", "height", "depth"), "")},
}
_SHARES = {" / 2": "half", " * 2": "twice"}


def left_side(item: s.Assign | s.Sentence | s.Block) -> str:
    """Return the text before the sign of an entry; in --set, with the name of its block."""
    value = item.value if isinstance(item, s.Assign) else item.phrase
    if value is None:
        return item.name.span.text
    written = item.span.source.text[item.span.start : value.span.start]
    return _SIGN.sub("", written)


def unknown_entry(
    item: s.Assign | s.Sentence | s.Block,
    entries: Iterable[str],
    written: Collection[str] = (),
) -> Hint:
    """Return a hint with the entry that is meant by another word, if any, and with all.

    Args:
        item: What was written.
        entries: Names of the entries that there are.
        written: Names that the block has already.
    """
    known = tuple(entries)
    if meant := _entry_meant(item, [one for one in known if one not in written]):
        return Hint(f"{meant}  entries: {', '.join(known)}", *meant.edits)
    return alternatives(item.name.key, known, what="entries")


def _entry_meant(item: s.Assign | s.Sentence | s.Block, entries: Iterable[str]) -> Hint:
    known, word = tuple(entries), item.name.key
    for entry, others in _SIZES.items():
        if entry in known and word in others and isinstance(item, s.Assign):
            return _sized(item, entry, others[word])
    if word == "label" and "part" in known and isinstance(item, s.Assign):
        sentence = f'part "label {item.value.span.text}"'
        return Hint(f"write {sentence}", Edit(sentence, item.span))
    near = [one for one, words in _MEANT.items() if one in known and word in words.split()]
    if len(near) != 1:
        return Hint("")
    return Hint(f'did you mean "{near[0]}"?', Edit(near[0]))


def _sized(item: s.Assign, entry: str, change: str) -> Hint:
    """Return a hint to write a size of something round as another one.

    Args:
        entry: The name of the other size.
        change: What makes it of the written one; empty if they are the same.
    """
    written = item.value.span.text
    if change and isinstance(item.value, s.Sum):
        written = f"({written})"
    owner = left_side(item).removeprefix(item.name.span.text)
    sentence = f"{entry}{owner} = {written}{change}"
    what = f", {_SHARES[change]} the {item.name.text}" if change else ""
    return Hint(f'write "{sentence}"{what}', Edit(sentence, item.span))


def missing(example: str, where: Span) -> Hint:
    """Return a hint with the entries of a block, whose head is ``where``."""
    opened = _BRACE.match(where.source.text, where.end)
    text = f" {example};" if opened else f" {{ {example} }}"
    place = Span(where.source, where.start, opened.end() if opened else where.end)
    return Hint(f"for example: {example}", insertion(text, place))


def blamed(reason: str, places: Mapping[str, Span], where: Span) -> Span:
    """Return the place of the entry that a reason quotes first, or the head of the block.

    Args:
        reason: Text of an error.
        places: Places of entries by name.
        where: The head of the block.
    """
    named = [name for name in places if f'"{name}' in reason]
    first = min(named, key=lambda name: reason.index(f'"{name}'), default="")
    return places.get(first, where)


def chosen(item: s.Item, entries: Iterable[str]) -> Hint:
    """Return a hint for an entry without its "is", such as ``rupture allowed``, or none."""
    if isinstance(item, s.Sentence) and item.phrase is None:
        for entry in entries:
            if item.name.key.startswith(f"{entry} "):
                value = item.name.text[len(entry) :].strip()
                return proposal(f"{entry} is {value.removeprefix('are ')}")
    return Hint("")
